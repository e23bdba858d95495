# envelope-bind: an envelope around two bones; the bones as one mesh; frames; the report; what is refused; a whole body that walks.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

schema=$BATS_TEST_DIRNAME/../../share/schema/envelope.schema.json
body=$BATS_TEST_DIRNAME/../../share/examples/body/bp3d.tsv

# member FILE EXPRESSION: a value of the document d
member() { /usr/bin/python3 -c "import json, math, sys; d = json.load(open(sys.argv[1])); print(json.dumps($2))" "$1"; }

# A bar along x from X0 to X1 in a unit of 1/UNIT m, half as thick as R: bar FILE X0 X1 R UNIT
bar() {
    awk -v a="$2" -v b="$3" -v r="$4" -v u="$5" 'BEGIN { n = 40; m = 12; pi = atan2(0, -1)
        for (i = 0; i <= n; i++) for (k = 0; k < m; k++)
            printf "v %.17g %.17g %.17g\n", u * (a + (b - a) * i / n), u * r * cos(2 * pi * k / m), u * r * sin(2 * pi * k / m)
        for (i = 0; i < n; i++) for (k = 0; k < m; k++) { l = (k + 1) % m; p = i * m + 1
            print "f", p + k, p + l, p + k + m; print "f", p + l, p + l + m, p + k + m }
        for (k = 1; k + 1 < m; k++) { print "f", 1, 1 + k + 1, 1 + k; p = n * m + 1; print "f", p, p + k, p + k + 1 } }' > "$1"
}

# Two bars that meet at the origin, the second in millimetres; the elbow bends by 90 degrees in a second about y.
setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    bar upper.obj -0.3 -0.005 0.02 1
    bar lower.obj 0.005 0.3 0.02 1000
    bar skin.obj -0.31 0.31 0.03 1
    cat > bend.motion.json << 'END'
{"format":"sinew-motion","version":1,"rate":24,
 "joints":[{"name":"elbow","type":"hinge","axis":[0,1,0],"point":[0,0,0],"keys":[[0,0],[1,90]]}],
 "bones":[{"name":"upper","mesh":"upper.obj"},{"name":"lower","mesh":"lower.obj","units":"mm","joint":"elbow"}]}
END
}

@test "the document keeps to its schema, and is the same on one thread, on three and in a pipe" {
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json -o a.envelope.json --threads 1
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json -o b.envelope.json --threads 3
    "$BIN/envelope-bind" -q --units m --bones bend.motion.json < skin.obj > c.envelope.json
    cmp a.envelope.json b.envelope.json
    [ "$(member a.envelope.json 'd["influences"]')" = "$(member c.envelope.json 'd["influences"]')" ]
    [ "$(member a.envelope.json 'd["bones"]')" = '["upper", "lower"]' ]
    [ "$(member a.envelope.json 'len(d["influences"]["counts"]) == len(d["mesh"]["vertices"]) / 3')" = true ]
    [ "$(member a.envelope.json 'd["history"][-1]["tool"]')" = '"envelope-bind"' ]
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || skip "python3-jsonschema is not installed"
    /usr/bin/python3 - "$schema" a.envelope.json << 'END'
import json, jsonschema, sys
schema = json.load(open(sys.argv[1]))
jsonschema.Draft202012Validator.check_schema(schema)
jsonschema.validate(json.load(open(sys.argv[2])), schema)
END
}

@test "a vertex far from the joint is on one bone, one above it on both alike; a longer reach takes more" {
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json -o a.envelope.json
    cat > weights.py << 'END'
import json, sys
d = json.load(open(sys.argv[1])); i = d["influences"]; n = 0; shared = 0
for v, count in enumerate(i["counts"]):
    x = d["mesh"]["vertices"][3 * v]
    w = dict(zip(i["bones"][n:n + count], i["weights"][n:n + count])); n += count
    assert abs(sum(w.values()) - 1) < 1e-15
    if abs(x) > 0.06: assert w == {(0 if x < 0 else 1): 1}, (x, w)
    if abs(x) < 1e-12: assert abs(w[0] - 0.5) < 1e-3, (x, w)
    shared += count > 1
print(shared)
END
    near=$(/usr/bin/python3 weights.py a.envelope.json)
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json --reach 60mm -o b.envelope.json
    sed -i 's/> 0.06/> 0.08/' weights.py
    [ "$(/usr/bin/python3 weights.py b.envelope.json)" -gt "$near" ]
}

@test "frames: a cache, or meshes that are numbered; ends go with their bones" {
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json -o a.envelope.json --frames a.pc2 --every 12
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json -o b.envelope.json --frames b.ply --every 12
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json -o b.envelope.json --frames b.vtp --every 12
    [ "$(ls b.*.ply b.*.vtp | wc -l)" -eq 6 ]
    "$BIN/mesh-clean" -q b.0024.vtp --check --units m
    /usr/bin/python3 - << 'END'
import json, struct
raw = open("a.pc2", "rb").read()
n, = struct.unpack("<i", raw[16:20]); start, rate, samples = struct.unpack("<ffi", raw[20:32])
assert (start, rate, samples) == (0, 12, 3), (start, rate, samples)
rest = json.load(open("a.envelope.json"))["mesh"]["vertices"]
for k, (c, s) in enumerate(((1, 0), (0.5 ** 0.5, 0.5 ** 0.5), (0, 1))):
    for v in range(n):
        x, y, z = rest[3 * v:3 * v + 3]
        at = struct.unpack_from("<fff", raw, 32 + 12 * (k * n + v))
        if x > 0.06: x, z = c * x + s * z, -s * x + c * z
        if abs(x) > 0.06 or k == 0: assert max(abs(a - b) for a, b in zip(at, (x, y, z))) < 1e-6 or -0.06 < rest[3 * v] < 0.06, (k, v, at)
END
}

@test "the bones as one mesh: each in its own unit" {
    "$BIN/envelope-bind" --bones bend.motion.json --write-bones bones.ply < /dev/null
    "$BIN/mesh-clean" -q bones.ply --keep all --units m --report r.json -o clean.ply
    [ "$(member r.json 'd["before"]["components"]')" -eq 2 ]
    [ "$(member r.json '0.6 < d["before"]["diagonal"] < 0.61')" = true ]
    "$BIN/mesh-clean" -q bones.ply --wrap 0.02 --keep all --units m --report r.json -o wrap.ply
    [ "$(member r.json '[d["after"]["components"], d["after"]["closed"]]')" = '[1, true]' ]
}

@test "the report tells bones that come out and triangles that shrink; method and motion of a bound envelope can change" {
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json --report r.json -o a.envelope.json
    [ "$(member r.json 'd["idleBones"]')" = '[]' ]
    [ "$(member r.json '[d["motion"]["frames"], d["rest"]["deepest"]["distance"] < -0.008, d["motion"]["leastArea"]["frame"]]')" = '[25, true, 24]' ]
    "$BIN/envelope-bind" -q a.envelope.json --bones bend.motion.json --method wrap --report w.json -o w.envelope.json
    [ "$(member w.envelope.json '[d["method"], [h["tool"] for h in d["history"]]]')" = '["wrap", ["envelope-bind", "envelope-bind"]]' ]
    [ "$(member w.envelope.json 'd["influences"]')" = "$(member a.envelope.json 'd["influences"]')" ]
    # at rest nothing is outside; a tube that is drawn in at the bend lets more of the bones out
    [ "$(member w.json 'd["rest"]["outsideShare"] == 0')" = true ]
    [ "$(/usr/bin/python3 -c 'import json; print(json.load(open("w.json"))["motion"]["deepest"]["distance"] >= json.load(open("r.json"))["motion"]["deepest"]["distance"])')" = True ]
}

@test "a skin of another unit or place draws a warning" {
    "$BIN/envelope-bind" --units cm skin.obj --bones bend.motion.json -o a.envelope.json 2> err
    [ ! -s err ] || refute grep -q 'farther than' err
    sed 's/^v \([^ ]*\)/v 5/' skin.obj > far.obj
    "$BIN/envelope-bind" --units m far.obj --bones bend.motion.json -o a.envelope.json 2> err
    grep -q 'vertices are farther than 0.1 m from every bone' err
    # one that was bound before, over other bones than those
    "$BIN/envelope-bind" --units m skin.obj --bones bend.motion.json -o a.envelope.json
    "$BIN/envelope-bind" a.envelope.json --bones bend.motion.json --report r.json -o b.envelope.json 2> err
    [ "$(grep -c 'farther than' err)" -eq 0 ]
    [ "$(member r.json '[d["clearance"]["farVertices"], 0.009 < d["clearance"]["mean"] < 0.011]')" = '[0, true]' ]
    sed 's/"units":"mm"/"units":"m"/' bend.motion.json > units.motion.json
    "$BIN/envelope-bind" a.envelope.json --bones units.motion.json -o b.envelope.json 2> err
    grep -Eq 'warning: [0-9]+ vertices are farther than 0.1 m from the bone that carries them most, vertex [0-9]+ by ' err
}

@test "what makes no sense is refused by name" {
    run -2 "$BIN/envelope-bind" skin.obj
    [[ "$output" == *--bones* ]]
    run -2 "$BIN/envelope-bind" skin.obj --bones bend.motion.json --reach 0mm
    run -2 "$BIN/envelope-bind" --bones bend.motion.json --write-bones bones.xyz
    [[ "$output" == *"--write-bones bones.xyz: no mesh format has this ending"* ]]
    [ ! -e bones.xyz ]
    run -0 "$BIN/envelope-bind" --bones bend.motion.json --write-bones ./bones
    mkdir folder.ply
    for name in x.stl x folder.ply/x .; do
        run -2 "$BIN/envelope-bind" --units m skin.obj --bones bend.motion.json --frames "$name" -o kept.envelope.json
        [[ "$output" == *"--frames $name:"* ]]
        [ ! -e kept.envelope.json ]
    done
    sed 's/"bones"/"_bones"/' bend.motion.json > none.motion.json
    run -1 "$BIN/envelope-bind" skin.obj --bones none.motion.json
    [[ "$output" == *"names no bones"* ]]
    "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json -o a.envelope.json
    run -2 "$BIN/envelope-bind" a.envelope.json --bones bend.motion.json --reach 10mm
    sed 's/"lower"/"other"/' bend.motion.json > other.motion.json
    run -1 "$BIN/envelope-bind" a.envelope.json --bones other.motion.json
    [[ "$output" == *'"lower"'* ]]
    sed 's/lower.obj/absent.obj/' bend.motion.json > absent.motion.json
    run -1 "$BIN/envelope-bind" skin.obj --bones absent.motion.json -o kept.envelope.json
    [[ "$output" == *absent.obj* ]]
    [ ! -e kept.envelope.json ]
}

@test "bones that are told to be the same draw the line: two of one name are refused" {
    sed 's/"name":"lower"/"name":"upper"/' bend.motion.json > twice.motion.json
    run -1 "$BIN/envelope-bind" skin.obj --bones twice.motion.json
    [[ "$output" == *upper* ]]
}

# CMU's walk and run on 202 bones: one piece of 10,700 triangles around all. The mesh, the reach and the room were chosen on these motions.
@test "an envelope over a whole body keeps the bones in and its triangles up, as it walks and runs" {
    [ -d "$DATA/body-bp3d-low" ] && [ -d "$DATA/mocap-cmu" ] || skip "no body or captures in $DATA"
    awk -F'\t' -v folder="$(cd "$DATA/body-bp3d-low" && pwd)" '$2 == "bone" { print folder "/meshes/" $1 }' "$DATA/body-bp3d-low/manifest.tsv" > bones.txt
    for motion in 01_walk 03_run; do
        "$BIN/motion-fit" -q "$DATA/mocap-cmu/motion/cmu_02_$motion.bvh" --body "$body" --bones bones.txt -o "$motion.motion.json"
    done
    "$BIN/envelope-bind" --bones 01_walk.motion.json --write-bones all.ply < /dev/null
    "$BIN/mesh-clean" -q all.ply --units m --wrap 0.0014 --keep all --smooth 1 --triangles 10700 --flip-slivers --report mesh.json -o skin.ply
    [ "$(member mesh.json '[d["after"]["components"], d["after"]["closed"], 10000 < d["after"]["triangles"] < 11000]')" = '[1, true, true]' ]
    for motion in 01_walk 03_run; do
        "$BIN/envelope-bind" -q skin.ply --units m --bones "$motion.motion.json" --reach 53mm --grow 9mm --every 20 --report r.json -o a.envelope.json
        [ "$(member r.json '[d["rest"]["deepShare"] < 1e-3, d["motion"]["deepShare"] < 0.01, d["motion"]["worstDeepShare"] < 0.015]')" = '[true, true, true]' ]
        [ "$(member r.json '[d["motion"]["leastArea"]["ratio"] > 0.2, d["motion"]["smallTriangles"], d["clearance"]["farVertices"]]')" = '[true, 0, 0]' ]
    done
}

@test "frames over an older, longer sequence, or one of other numbers, are wrong usage before any work; over their own they are not" {
    bind() { "$BIN/envelope-bind" -q --units m skin.obj --bones bend.motion.json -o a.envelope.json "$@"; }
    for format in ply vtp; do
        rm -f a.envelope.json skin.*."$format"
        bind --frames skin.$format --every 6
        bind --frames skin.$format --every 6 # its own
        rm a.envelope.json
        for other in 0025 0100 -001; do
            touch skin.$other.$format
            run -2 bind --frames skin.$format --every 6
            [[ "$output" == *"skin.$other.$format: is of an older sequence"*"remove it, or name another folder"* ]] || { echo "$output"; false; }
            refute [ -e a.envelope.json ]
            rm skin.$other.$format
        done
    done
}
