# Files of glTF, FBX, Collada and 3DS through mesh-import; one of several meshes; what a child that dies, hangs or lies does to a tool.

bats_require_minimum_version 1.5.0

# a && b and ! a do not end a test under bats: state every condition by itself, and what must not hold with `refute`
refute() { if "$@"; then echo "held: $*"; return 1; fi; }

# `timeout 300` is a limit against hanging, far beyond what any of these takes: it judges no speed.

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    clean="$BIN/mesh-clean"
    import="$BIN/../libexec/sinew/mesh-import"
    scene="$BATS_TEST_DIRNAME/../write-scene"
    write="$BATS_TEST_DIRNAME/../write-gltf"
    man="$BATS_TEST_DIRNAME/../../share/man/mesh-import.1"
    # sanitizers reserve terabytes, so that the tool's limit of memory is off: theirs instead
    export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}hard_rss_limit_mb=2048:max_allocation_size_mb=2048"
}

# "N vertices, low corner, high corner, unit" of a document
extent() {
    /usr/bin/python3 - "$1" <<'END'
import json, sys
document = json.load(open(sys.argv[1]))
values = document['mesh']['vertices']
axes = [values[k::3] for k in range(3)]
print(len(axes[0]), *('%g' % min(a) for a in axes), *('%g' % max(a) for a in axes), '%g' % document['metersPerUnit'])
END
}

expect_extent() { # FILE WANTED
    local found
    found=$(extent "$1")
    [ "$found" = "$2" ] || { echo "$1: $found, not $2"; return 1; }
}

# Run with a status of 1 and exactly one line on stderr, which matches the pattern; no output.
refused() {
    local pattern=$1 code=0
    shift
    rm -f refused.ply
    "$@" -o refused.ply > out 2> err || code=$?
    [ "$code" -eq 1 ] || { echo "status $code: $*"; cat err; return 1; }
    [ ! -s out ] || { echo "stdout is not empty: $*"; return 1; }
    [ ! -e refused.ply ] || { echo "there is an output: $*"; return 1; }
    [ "$(wc -l < err)" -eq 1 ] || { cat err; return 1; }
    grep -Eq "^[a-z-]+: $pattern" err || { cat err; return 1; }
}

# A shell script in place of mesh-import: its lines.
pretend() {
    mkdir -p fake
    { echo '#!/bin/sh'; printf '%s\n' "$@"; } > fake/mesh-import
    chmod +x fake/mesh-import
    export SINEW_LIBEXEC=$PWD/fake
}

@test "glTF, GLB and its side file: meshes, names, transforms, metres, y up turned to z" {
    for format in gltf glb bin; do
        "$scene" $format ./a.$format
        "$clean" --keep all a.$format -o a.json
        # biceps 0.5..0.6 x 0..0.2 x 0..0.3; triceps -1..0 x 2..3 x 0..1, y up
        expect_extent a.json "16 -1 -1 0 0.6 0 3 1"
        "$clean" --list a.$format > list
        printf '1\tbiceps\t8\t12\n2\ttriceps\t8\t12\n' | cmp - list
    done
}

@test "a mesh that a transform mirrors is not inside out" {
    "$scene" glb a.glb
    "$clean" --check --mesh triceps a.glb
    "$clean" --check --mesh biceps a.glb
}

@test "one of several meshes, by name and by number; it gives the document its name" {
    "$scene" glb a.glb
    "$clean" --mesh triceps a.glb -o name.json
    "$clean" --mesh 2 --no-history a.glb -o number.json
    expect_extent name.json "8 -1 -1 2 0 0 3 1"
    expect_extent number.json "8 -1 -1 2 0 0 3 1"
    grep -q '"name": *"triceps"' name.json
    grep -q '"--mesh"' name.json
    refused "a.glb: .*none is '3'" "$clean" --mesh 3 a.glb
    refused "a.glb: .*none is '0'" "$clean" --mesh 0 a.glb
    refused "a.glb: .*none is 'bic'" "$clean" --mesh bic a.glb
    "$clean" name.json -o again.json
    run -2 "$clean" --mesh 1 name.json
}

@test "--mesh and --list know the groups of an OBJ file, and triangles of none" {
    printf 'v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nv 1 0 0\nv 1.1 0 0\nv 1 .1 0\nv 1 0 .1\n' > two.obj
    printf 'f 5 7 6\nf 5 6 8\nf 6 7 8\nf 7 5 8\ng one\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\ng empty\n' >> two.obj
    "$clean" --list two.obj > list
    printf '1\tone\t4\t4\n2\tempty\t0\t0\n3\t\t4\t4\n' | cmp - list
    "$clean" --mesh one two.obj -o one.json
    expect_extent one.json "4 0 0 0 0.1 0.1 0.1 1"
    "$clean" --mesh 3 two.obj -o three.json
    expect_extent three.json "4 1 0 0 1.1 0.1 0.1 1"
    refused "two.obj: mesh 'empty' has no faces" "$clean" --mesh empty two.obj
    printf 'g a\tb\n' > tab.obj
    cat two.obj >> tab.obj
    "$clean" --list tab.obj > list
    [ "$(head -n 1 list)" = "$(printf '1\ta b\t4\t4')" ]
    sed 's/^g .*//' two.obj > bare.obj
    "$clean" --list bare.obj > list
    printf '1\t\t8\t8\n' | cmp - list
}

@test "--list belongs to every tool of the chain, and a full disk is an error" {
    "$scene" glb a.glb
    for tool in mesh-clean root-select build-structure fiber-flow; do
        "$BIN/$tool" --list a.glb > list
        [ "$(wc -l < list)" -eq 2 ]
    done
    run -1 sh -c "'$clean' --list a.glb > /dev/full"
}

@test "Collada: its unit, its axis and its transforms; coordinates stay the file's" {
    "$scene" dae z.dae
    "$clean" z.dae -o z.json
    expect_extent z.json "8 1 2 3 2 3 4 0.01"
    "$scene" dae y.dae Y_UP 0.0254
    "$clean" y.dae -o y.json
    expect_extent y.json "8 1 -4 2 2 -3 3 0.0254"
    "$scene" dae x.dae X_UP 1
    "$clean" x.dae -o x.json
    expect_extent x.json "8 -3 -4 1 -2 -3 2 1"
    "$clean" --list z.dae > list
    printf '1\tdeltoid\t8\t12\n' | cmp - list
}

@test "FBX, text and binary: centimetres times its factor, its axis, its transforms" {
    "$scene" fbx a.fbx
    "$clean" a.fbx -o a.json
    expect_extent a.json "8 10 -34 20 12 -30 23 0.01"
    "$scene" fbx-binary b.fbx
    "$clean" b.fbx -o b.json
    expect_extent b.json "8 10 -34 20 12 -30 23 0.01"
    "$scene" fbx c.fbx 2.54 2
    "$clean" c.fbx -o c.json
    expect_extent c.json "8 10 20 30 12 23 34 0.0254"
    "$scene" fbx-pivot p.fbx
    "$clean" p.fbx -o p.json
    expect_extent p.json "8 12 -30 20 14 -27 24 0.01"
    "$clean" --list p.fbx > list
    printf '1\tsoleus\t8\t12\n' | cmp - list
    "$clean" --list b.fbx > list
    printf '1\tsoleus\t8\t12\n' | cmp - list
}

@test "3DS has no unit and z up" {
    "$scene" 3ds a.3ds
    "$clean" a.3ds -o a.json
    expect_extent a.json "8 0 0 0 1 1 1 1"
}

@test "--units and --up overrule what a file says" {
    "$scene" glb a.glb
    "$clean" --mesh biceps --units mm --up z a.glb -o a.json
    expect_extent a.json "8 0.5 0 0 0.6 0.2 0.3 0.001"
    "$scene" dae z.dae
    "$clean" --units m --up y z.dae -o z.json
    expect_extent z.json "8 1 -4 2 2 -3 3 1"
}

@test "a format is known by its content: stdin, pipes, wrong extensions; the same bytes each time" {
    for format in gltf glb dae fbx fbx-binary 3ds; do
        "$scene" $format a.$format
        "$clean" a.$format -o file.ply
        "$clean" < a.$format -o stdin.ply
        cmp file.ply stdin.ply
        cat a.$format | "$clean" - -o pipe.ply
        cmp file.ply pipe.ply
        cp a.$format wrong.mot
        "$clean" wrong.mot -o wrong.ply
        cmp file.ply wrong.ply
    done
    head -c 3000 /dev/urandom > noise.fbx
    refused "noise.fbx: is in no known mesh format" "$clean" noise.fbx
}

@test "buffers are read beside the named file only" {
    mkdir folder other
    "$scene" bin folder/a.gltf
    "$clean" folder/a.gltf -o a.ply
    refused "<stdin>: cannot be imported as glTF: .*side.bin" sh -c "'$clean' \"\$@\" < folder/a.gltf" sh
    mv folder/side.bin other
    refused "folder/a.gltf: cannot be imported as glTF: .*side.bin" "$clean" folder/a.gltf
    for uri in ../other/side.bin "$PWD/other/side.bin"; do
        sed "s|side.bin|$uri|" folder/a.gltf > folder/b.gltf
        refused "folder/b.gltf: cannot be imported" "$clean" folder/b.gltf
    done
    mkfifo folder/side.bin
    refused "folder/a.gltf: cannot be imported" timeout 300 "$clean" folder/a.gltf
}

@test "buffers are found by uris with %20, by names as they are, and without an extension" {
    "$scene" bin a.gltf
    "$clean" a.gltf -o a.ply
    for name in 'my side.bin' 'my%20side.bin' 'side' 'm\xc3\xbc side'; do
        name=$(printf "$(echo "$name" | sed 's/%/%%/g')")
        for uri in "$name" "$(echo "$name" | sed 's/%/%25/g; s/ /%20/g; s/ü/%C3%bc/g')"; do
            mv side.bin "$name" 2> /dev/null || [ "$name" = side ] || true
            sed "s|side.bin|$uri|" a.gltf > b.gltf
            "$clean" b.gltf -o b.ply
            cmp a.ply b.ply
        done
        mv "$name" side.bin
    done
    mkdir below
    mv a.gltf below
    for uri in %2e%2e/side.bin ..%2fside.bin side%00.bin; do
        sed "s|side.bin|$uri|" below/a.gltf > below/b.gltf
        refused "below/b.gltf: cannot be imported" "$clean" below/b.gltf
    done
}

@test "a GLB and a 3DS file that go on behind their length are refused" {
    for format in glb 3ds; do
        "$scene" $format a.$format
        cat a.$format a.$format > two.$format
        refused "two.$format: the header counts [0-9]* bytes, but the file has [0-9]*" "$clean" two.$format
    done
}

@test "vertex colours are kept, and a number that is none is dropped on request" {
    "$scene" colours a.glb
    "$clean" --mesh biceps a.glb -o a.ply
    grep -a -q '^property uchar red' a.ply
    "$scene" nan n.glb
    refused "n.glb: vertex 0 has a coordinate that is not" "$clean" n.glb
    "$clean" -q --keep all --repair-nonfinite n.glb -o n.json
    [ "$(extent n.json)" != "" ]
}

# "N vertices, low corner, high corner" in the file's axes and unit, and that its outside is outside, each piece of it
placed() { # FILE WANTED
    "$import" "$1" -o placed.ply 2> err || { cat err; return 1; }
    [ ! -s err ] || { cat err; return 1; }
    /usr/bin/python3 - placed.ply "$1" "$2" <<'END'
import struct, sys
data = open(sys.argv[1], 'rb').read()
head, body = data.split(b'end_header\n', 1)
count = {line.split()[1]: int(line.split()[2]) for line in head.decode().splitlines() if line.startswith('element')}
sizes = [int(line.split()[2]) for line in head.decode().splitlines() if line.startswith('comment mesh')]
points = [struct.unpack_from('<3d', body, 24 * i) for i in range(count['vertex'])]
at, volumes, size = 24 * len(points), [0], 0
for _ in range(count['face']):
    n, = struct.unpack_from('<i', body, at)
    c = [points[i] for i in struct.unpack_from('<%di' % n, body, at + 4)]
    at += 4 + 4 * n
    for k in range(1, n - 1):
        a, b, d = c[0], c[k], c[k + 1]
        volumes[-1] += (a[0] * (b[1] * d[2] - b[2] * d[1]) - a[1] * (b[0] * d[2] - b[2] * d[0]) + a[2] * (b[0] * d[1] - b[1] * d[0])) / 6
    size += n - 2
    if size == sizes[0]:
        sizes.pop(0), volumes.append(0)
        size = 0
found = ' '.join([str(len(points))] + ['%.5g' % f(p[k] for p in points) for f in (min, max) for k in range(3)])
if found != sys.argv[3] or min(volumes[:-1]) <= 0:
    sys.exit('%s: %s, not %s; volumes %s' % (sys.argv[2], found, sys.argv[3], volumes[:-1]))
END
}

@test "glTF: numbers of any kind, sparse, strided; strips and fans; morph targets" {
    for kind in plain u16 i16 u8 i8 integers sparse zeros strip fan strided morph morph-node percent noscene two-scenes; do
        case $kind in
            sparse | morph-node) wanted="4 0 0 0 3 1 1" ;;
            morph) wanted="4 0 0 0 2 1 1" ;;
            two-scenes) wanted="4 5 0 0 6 1 1" ;;
            *) wanted="4 0 0 0 1 1 1" ;;
        esac
        for form in json glb; do
            "$write" $kind a.$form $form
            placed a.$form "$wanted"
        done
    done
}

@test "glTF: instances are all there, with names of their own" {
    for form in json glb; do
        "$write" instances-t t.gltf $form
        placed t.gltf "8 0 0 0 4 1 1"
        "$write" instances-trs trs.gltf $form
        placed trs.gltf "8 0 1 0 3 3 2"
        "$write" instances-mirror mirror.gltf $form
        placed mirror.gltf "8 0 0 0 3 1 1"
    done
    "$clean" --list t.gltf > list
    printf '1\tm 1\t4\t4\n2\tm 2\t4\t4\n' | cmp - list
    "$write" instances-none none.gltf
    refused "none.gltf: nodes\[0\].extensions.EXT_mesh_gpu_instancing: has neither" "$clean" none.gltf
    "$write" instances-uneven uneven.gltf
    refused "uneven.gltf: .*SCALE: is 1 rows of 3 numbers, not 2 of 3" "$clean" uneven.gltf
    "$write" instances-skin both.gltf
    refused "both.gltf: .*EXT_mesh_gpu_instancing: is not read where the node has a skin" "$clean" both.gltf
}

@test "glTF: what an extension packs or changes is refused by name, what leaves surfaces alone is not" {
    for name in ACME_other_geometry KHR_draco_mesh_compression EXT_meshopt_compression KHR_meshopt_compression CESIUM_RTC KHR_mesh; do
        for form in json glb; do
            "$write" plain a.gltf required=$name $form
            refused "a.gltf: requires the extension $name, which .*export it without" "$clean" a.gltf
            run ! "$BIN/motion-import" -q a.gltf -o a.json
            [ "$(echo "$output" | grep -c "requires the extension $name")" -eq 1 ]
        done
    done
    for name in KHR_materials_unlit KHR_materials_pbrSpecularGlossiness KHR_texture_transform KHR_texture_basisu EXT_texture_webp \
        KHR_lights_punctual KHR_mesh_quantization KHR_xmp_json_ld; do
        "$write" plain a.gltf required=$name
        placed a.gltf "4 0 0 0 1 1 1"
    done
    "$write" plain a.gltf used=ACME_other_geometry
    placed a.gltf "4 0 0 0 1 1 1"
    "$write" plain a.gltf used=CESIUM_RTC
    "$clean" a.gltf -o a.json 2> err
    grep -q "^mesh-clean: warning: a.gltf: the extension CESIUM_RTC, which the file uses, is not read" err
    for kind in draco meshopt; do # not required: there may be a copy of the meshes that is not packed
        "$write" $kind-fallback a.gltf
        placed a.gltf "4 0 0 0 1 1 1"
        "$write" $kind a.gltf
        refused "a.gltf: has its meshes packed by the extension (KHR_draco_mesh|EXT_meshopt)_compression" "$clean" a.gltf
    done
}

@test "glTF: a skinned mesh is where its joints have it, not where its node is" {
    for form in json glb; do
        for kind in skin skin-moved skin-unbound skin-lone skin-below; do
            "$write" $kind a.gltf $form
            placed a.gltf "4 0 0 0 1 1 1"
        done
        "$write" skin-scaled a.gltf $form
        placed a.gltf "4 0 0 4 0.01 0.01 4.01"
        "$write" skin-twice a.gltf $form
        placed a.gltf "8 0 0 0 11 1 1"
    done
    "$write" skin-posed a.gltf
    "$clean" --keep all a.gltf -o a.json 2> err
    [ "$(wc -l < err)" -eq 1 ]
    grep -q "^mesh-clean: warning: a.gltf: the joints of 'm' are not as its skin was bound" err
    expect_extent a.json "4 0 -1 0 1 0 1 1"
    # bones without matrices are no crash of motion-import either
    "$write" skin-unbound a.gltf
    run -1 "$BIN/motion-import" a.gltf
    [ "$output" = "motion-import: a.gltf: holds no animation of a node and no bones; an animation of shapes or cameras is no motion" ]
}

@test "glTF: what does not fit is refused in one sentence" {
    while read -r kind pattern; do
        for form in json glb; do
            "$write" "$kind" a.gltf $form
            refused "a.gltf: $pattern" "$clean" a.gltf
        done
    done <<'END'
short (cannot be imported as glTF: buffer 0 holds 5[0-9] bytes, not the 72|.*cut short)
outside accessors\[0\]: 4 rows of 12 bytes from byte 0 on do not fit into its view of 40 bytes
index a face names vertex 4 of 4
accessor meshes\[0\].primitives\[0\].attributes.POSITION: expected a number in
cycle nodes\[1\]: hangs on itself
twice nodes\[2\].children: node 0 hangs on two nodes|.*hangs on two nodes
points holds no surface
version is glTF of version 2.1, and 2.0 is read
END
}

@test "glTF: components of a type that their use does not have are refused by its name, and those that it has are read" {
    # which accessor, type, normalized; the numbers of right ones are beside the point: their bytes are enough for any type
    while read -r kind what type normalized name; do
        "$write" $kind a.gltf
        /usr/bin/python3 - $what $type $normalized << 'END'
import json, sys
what, kind, normalized = sys.argv[1], int(sys.argv[2]), sys.argv[3] == "true"
tree = json.load(open("a.gltf"))
primitive = tree["meshes"][0]["primitives"][0]
number = primitive["indices"] if what == "indices" else primitive["attributes"]["POSITION" if what == "sparse" else what]
accessor = tree["accessors"][number]
if what == "sparse": accessor = accessor["sparse"]["indices"]
accessor["componentType"] = kind
if normalized: accessor["normalized"] = True
if what != "sparse": # room for any
    size = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]] * 4 * accessor["count"]
    tree["bufferViews"].append({"buffer": len(tree["buffers"]), "byteLength": size})
    import base64
    tree["buffers"].append({"byteLength": size, "uri": "data:application/octet-stream;base64," + base64.b64encode(bytes(size)).decode()})
    accessor["bufferView"], accessor["byteOffset"] = len(tree["bufferViews"]) - 1, 0
json.dump(tree, open("a.gltf", "w"))
END
        if [ "$name" = taken ]; then
            "$clean" --check a.gltf > out 2> err || true
            refute grep -q 'type 51' err
        else
            refused "a.gltf: .*($what|sparse|normalized).*type $type \($name\).*(unsigned|floats|cannot be normalized)" "$clean" a.gltf
        fi
    done <<'END'
plain indices 5126 false float
plain indices 5120 false byte
plain indices 5122 false short
plain indices 5123 true unsigned short
plain indices 5125 true unsigned int
plain indices 5121 false taken
plain indices 5123 false taken
plain indices 5125 false taken
plain POSITION 5125 false unsigned int
plain POSITION 5126 true float
sparse sparse 5126 false float
sparse sparse 5122 false short
skin JOINTS_0 5126 false float
skin JOINTS_0 5125 false unsigned int
skin JOINTS_0 5121 true unsigned byte
skin JOINTS_0 5120 false byte
skin WEIGHTS_0 5121 false unsigned byte
skin WEIGHTS_0 5125 false unsigned int
skin WEIGHTS_0 5122 true short
END
}

@test "Collada: the bind shape moves a skinned mesh, its node does not" {
    for kind in plain moved; do
        "$write" dae $kind a.dae
        placed a.dae "8 5 0 0 6 1 1"
    done
    "$write" dae mirrored a.dae
    placed a.dae "8 4 0 0 5 1 1"
    "$write" dae scaled a.dae
    placed a.dae "8 0.05 0 0 0.06 0.01 0.01"
    "$write" dae cm a.dae
    placed a.dae "8 4 0 0 5 1 1"
    "$clean" --keep all a.dae -o a.json # y up turned to z
    expect_extent a.json "8 4 -1 0 5 0 1 0.01"
    "$write" dae posed a.dae
    "$clean" --keep all a.dae -o a.json 2> err
    grep -q "^mesh-clean: warning: a.dae: the joints of 'g' are not as its skin was bound" err
    expect_extent a.json "8 5 0 0 6 1 1 1"
    "$BIN/motion-import" a.dae -o a.motion.json 2> err
    "$write" dae nojoint a.dae
    refused "a.dae: a skin names the joint 'j0', which is not in its scene" "$clean" a.dae
    for kind in twice twins; do
        "$write" dae $kind a.dae
        refused "a.dae: (the skinned mesh 'g' is in the scene twice|two joints have the sid 'j0')" "$clean" a.dae
    done
    "$write" dae sids a.dae
    refused "a.dae: two joints have the sid 'j0'" "$clean" a.dae
    for kind in morph morph-relative; do
        "$write" dae $kind a.dae
        refused "a.dae: mixes shapes \\(morph" "$clean" a.dae
    done
}

@test "FBX: what moves the geometry of a node does not move its children" {
    "$scene" fbx-pivot a.fbx
    /usr/bin/python3 - <<'END'
text = open('a.fbx').read()
geometry = text[text.index('\tGeometry: 1000'):text.index('\tModel: 2000')].replace('1000', '1001')
child = '\tModel: 2001, "Model::child", "Mesh" {\n\t\tProperties70:  {\n\t\t\tP: "Lcl Translation", "Lcl Translation", "", "A",5,0,0\n\t\t}\n\t}\n'
text = text.replace('}\nConnections:  {', geometry + child + '}\nConnections:  {')
open('a.fbx', 'w').write(text.replace('\tC: "OO",1000,2000\n', '\tC: "OO",1000,2000\n\tC: "OO",2001,2000\n\tC: "OO",1001,2001\n'))
END
    # the parent: 1 + 0..1, times 2, moved by 10; the child: 5 + 0..1, times 2, moved by 10
    "$clean" --mesh soleus --up z -q a.fbx -o parent.json
    expect_extent parent.json "8 12 20 27 14 24 30 0.01"
    "$clean" --mesh child --up z -q a.fbx -o child.json
    expect_extent child.json "8 20 20 27 22 24 30 0.01"
}

@test "bones come in their own unit and axis" {
    "$scene" glb bone.glb
    "$clean" --mesh triceps --units mm bone.glb -o muscle.ply # 1 m as a cube of 1 mm ...
    printf '{"format": "sinew-muscle", "version": 1, "metersPerUnit": 0.001, "mesh": {"vertices": [%s], "triangles": [0,2,1, 0,1,3, 1,2,3, 2,0,3]}}' \
        "-500,-500,2500, -400,-500,2500, -500,-400,2500, -500,-500,2600" > inside.json # ... and a muscle of millimetres in the middle of that metre
    "$BIN/attach-detect" --bone b=bone.glb inside.json --report all.json -o all.muscle.json
    grep -q '"attached": 4' all.json
    "$BIN/attach-detect" -q --bone b=bone.glb --bone-units mm inside.json --report none.json -o none.muscle.json
    grep -q '"attached": 0' none.json
}

@test "mesh-import by hand: a PLY file that says unit, axis and meshes; help, errors, its man page" {
    "$scene" fbx a.fbx
    "$import" a.fbx -o a.ply
    [ "$(sed -n 's/^comment //p' a.ply | head -n 3 | tr '\n' '|')" = "metersPerUnit 0.01|up y|mesh 12 soleus|" ]
    "$import" < a.fbx | cmp - a.ply
    "$clean" --list a.ply | grep -q "12$"
    "$import" --version | grep -qx "mesh-import (sinew) [0-9]*\.[0-9]*\.[0-9]*"
    run -2 "$import" --no-such-option
    refused "none.fbx: cannot be opened" "$import" none.fbx
    echo "hello" > text
    refused "text: is in no format that can be imported" "$import" text
    run -1 sh -c "'$import' a.fbx > /dev/full"
    mandoc -Tutf8 "$man" | col -b > page
    for option in $("$import" --help | grep -o -e '^ *\(-.,\)\? *--[a-z-]*' | grep -o -e '--[a-z-]*'); do
        grep -q -e "$option" page || { echo "no $option"; false; }
    done
    mandoc -Tlint -Wwarning "$man"
}

@test "only mesh-import is linked with assimp" {
    for tool in "$BIN"/*; do
        readelf -d "$tool" > needed
        refute grep -q assimp needed
    done
    readelf -d "$import" > needed
    grep -q assimp needed
}

@test "an importer that is not there, crashes or lies is one sentence, and nothing of it stays" {
    "$scene" glb a.glb
    export SINEW_LIBEXEC=$PWD/nowhere
    refused "a.glb: is a glTF file, and what reads these, .*/nowhere/mesh-import, is not there" "$clean" a.glb
    pretend 'kill -SEGV $$'
    refused "a.glb: makes the importer of glTF crash \(Segmentation fault\)" "$clean" a.glb
    pretend 'echo "terminate called after std::bad_alloc" >&2' 'kill -ABRT $$'
    refused "a.glb: needs more than [0-9]+ MB of memory" "$clean" a.glb
    pretend 'echo hello'
    refused "a.glb: .*answers with something that is no mesh" "$clean" a.glb
    pretend 'exit 0'
    refused "a.glb: .*answers with something that is no mesh" "$clean" a.glb
    pretend 'exit 7'
    refused "a.glb: .*failed with status 7" "$clean" a.glb
    pretend 'echo one >&2' 'echo "mesh-import: a.glb: it is too green" >&2' 'exit 1'
    refused "a.glb: it is too green$" "$clean" a.glb
    pretend 'sleep 4711.0815 &' 'echo hello' 'sleep 4711.0815'
    refused "a.glb: .*answers with something that is no mesh" timeout 300 "$clean" a.glb
    refute pgrep -f 'sleep 4711.0815'
    [ "$(ls | tr '\n' ' ')" = "a.glb err fake out " ]
}

@test "an answer is parsed like any file: cut short, indices out of range, counts that do not fit, no end" {
    "$scene" glb a.glb
    "$import" a.glb -o good.ply
    pretend "cat '$PWD/good.ply'"
    "$clean" --mesh biceps a.glb -o a.ply
    lie() { # what the header says differently
        sed -i "$1" answer.ply
        pretend "cat '$PWD/answer.ply'"
        refused "a.glb: .*answers with something that is no mesh" "$clean" a.glb
        cp good.ply answer.ply
    }
    head -c 700 good.ply > answer.ply
    lie ''
    lie 's/^comment mesh 12 biceps/comment mesh 13 biceps/'
    lie 's/^comment mesh 12 biceps/comment mesh -1 biceps/'
    lie 's/^comment mesh 12 biceps/comment mesh 1/'
    lie 's/^comment metersPerUnit 1/comment metersPerUnit 0/'
    lie 's/^element vertex 16/element vertex 15/'
    lie 's/^element face 24/element face 2000000000/'
    lie 's/^end_header/end_footer/'
    lie 's/^comment up y/\x00/'
    pretend 'echo ply' 'exec cat /dev/zero'
    refused "a.glb: holds more than 256 MB of meshes" "$clean" a.glb
}

@test "the child has limits of memory and of files" {
    [ "${CONFIG:-release}" != sanitize ] || skip "sanitizers reserve terabytes"
    "$scene" glb a.glb
    pretend 'echo "mesh-import: kilobytes $(ulimit -v), seconds $(ulimit -t), file $(ulimit -f)" >&2' 'exit 1'
    size=$(wc -c < a.glb)
    refused "a.glb: kilobytes $((2097152 + 16 * size / 1024)), seconds 21, file 0$" "$clean" a.glb # the kernel, behind the 20 s of the parent's watch
    pretend 'exec /usr/bin/python3 -c "bytearray(3 << 30)"'
    refused "a.glb: MemoryError" "$clean" a.glb
}

@test "an importer that hangs is killed after 20 s, whatever it does meanwhile" {
    "$scene" glb a.glb
    hang() { # NAME COMMANDS
        mkdir "$1"
        printf '#!/bin/sh\n%s\n' "$2" > "$1/mesh-import"
        chmod +x "$1/mesh-import"
        SINEW_LIBEXEC=$PWD/$1 timeout 300 "$clean" a.glb > "$1/out" 2> "$1/err" || echo $? > "$1/code"
    }
    hang asleep 'sleep 4711.0816' &
    hang silent 'exec > /dev/null 2>&1; sleep 4711.0816' &
    hang slow 'echo ply; while :; do echo comment; sleep 0.5; done' &
    wait
    for name in asleep silent slow; do
        [ "$(cat $name/code)" -eq 1 ]
        [ ! -s $name/out ]
        [ "$(wc -l < $name/err)" -eq 1 ]
        grep -q "^mesh-clean: a.glb: takes longer than 20 s to be imported as glTF" $name/err
    done
    refute pgrep -f 'sleep 4711.0816'
}

@test "the child dies with the tool" {
    "$scene" glb a.glb
    pretend 'exec sleep 4711.0817'
    "$clean" a.glb > out 2>&1 &
    tool=$!
    until pgrep -f 'sleep 4711.0817' > found || ! kill -0 $tool; do sleep 0.1; done
    [ -s found ]
    kill -KILL $tool
    for i in $(seq 300); do # it dies soon, and how soon is the machine's affair
        pgrep -f 'sleep 4711.0817' > /dev/null || break
        sleep 0.1
    done
    refute pgrep -f 'sleep 4711.0817'
}

@test "mutated skins, instances and sparse numbers: a mesh or one sentence" {
    for kind in skin-twice instances-trs sparse morph; do
        "$write" $kind a.glb glb
        for seed in $(seq 40); do
            "$scene" mutate a.glb "$seed" mutant.glb
            code=0
            timeout 300 "$import" -q --name mutant.glb mutant.glb -o mutant.ply > out 2> err || code=$?
            case $code in
                0) [ ! -s err ] ;;
                1) [ "$(wc -l < err)" -eq 1 ] && grep -q "^mesh-import: mutant.glb: ." err ;;
                *) false ;;
            esac || { echo "$kind $seed: status $code"; cat err; false; }
        done
    done
}

@test "mutated files: a mesh or one sentence, status 0, 1 or 3" {
    for format in glb gltf dae fbx fbx-binary 3ds; do
        "$scene" $format a.$format
        for seed in $(seq 60); do
            "$scene" mutate a.$format "$seed" "mutant.$format"
            code=0
            timeout 300 "$clean" -q "mutant.$format" -o mutant.ply > out 2> err || code=$?
            case $code in
                0) [ ! -s err ] ;;
                1) [ "$(wc -l < err)" -eq 1 ] && grep -q "^mesh-clean: mutant.$format: ." err ;;
                3) [ "$(wc -l < err)" -eq 1 ] ;;
                *) false ;;
            esac || { echo "$format $seed: status $code"; cat err; false; }
            [ ! -s out ]
            rm -f mutant.ply
        done
    done
    [ "$(ls -A | wc -l)" -eq 14 ]
}

@test "a closed standard descriptor is no way for the importer to lose its file" {
    "$scene" glb a.glb
    "$clean" a.glb -o open.json
    "$clean" a.glb -o closed.json <&-
    cmp open.json closed.json
    run -0 sh -c "'$clean' -q a.glb -o shut.json <&- 2>&-"
    cmp open.json shut.json
    run -1 sh -c "'$clean' a.glb >&-" # an error as before, not a file that nobody sees
}
