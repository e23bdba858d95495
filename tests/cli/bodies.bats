# Bodies in motion: scenes that take a motion document whole, coordinates in the table of lengths, bones in frames, the run-in.

bats_require_minimum_version 1.5.0

# a && b and ! a do not end a test under bats: state every condition by itself, and what must not hold with `refute`
refute() { if "$@"; then echo "held: $*"; return 1; fi; }

schemas="$BATS_TEST_DIRNAME/../../share/schema"

# The sample arm with its finished rigs, made once; body/arm.motion.json is its motion with bones and coordinates, one.scene.json its
# biceps under that motion, own.scene.json the same with joints and bones of its own.
setup_file() {
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" "$BATS_FILE_TMPDIR/arm"
    cd "$BATS_FILE_TMPDIR/arm" || exit 1
    "$BIN/fiber-fill" -n 20 -q biceps.muscle.json -o filled.muscle.json
    mkdir body
    mv ulna.ply radius.ply body
    python3 - <<'END'
import json
s = json.load(open("arm.scene.json"))
s["muscles"] = s["muscles"][:1]
s["muscles"][0].update(name="biceps", rig="filled.muscle.json")
for bone in s["bones"][2:]: bone["mesh"] = "body/" + bone["mesh"]
json.dump(s, open("own.scene.json", "w"))
elbow = s["motion"]["joints"][0]
wave = [0.25 * k * k for k in range(5)]
json.dump({"format": "sinew-motion", "version": 1, "metersPerUnit": 1, "rate": 24, "joints": [elbow],
           "coordinates": [{"name": "elbow flexion", "unit": "rad", "rate": 12, "values": wave}, {"name": "lift", "unit": "m", "values": [0.5]},
                           {"name": "beat", "values": [1, 2, 3]}],
           "bones": [dict(b, mesh="../" * (i < 2) + b["mesh"].replace("body/", ""), units="m") for i, b in enumerate(s["bones"])]},
          open("body/arm.motion.json", "w"))
s["motion"] = {"uri": "body/arm.motion.json"}
del s["bones"]
json.dump(s, open("one.scene.json", "w"))
END
}

setup() {
    cp -r "$BATS_FILE_TMPDIR/arm" "$BATS_TEST_TMPDIR/arm"
    cd "$BATS_TEST_TMPDIR/arm" || exit 1
    PATH=$BIN:$PATH
}

# FILE EXPRESSION: of the JSON document d
member() { python3 -c 'import json, sys
d = json.load(open(sys.argv[1])); print(json.dumps(eval(sys.argv[2])))' "$1" "$2"; }
# FILE: change the scene s by the Python on standard input
edit() { python3 -c 'import json, sys
s = json.load(open(sys.argv[1])); exec(sys.stdin.read()); json.dump(s, open(sys.argv[1], "w"))' "$1"; }

@test "a scene takes a motion document whole: hinge, keys and bones; the same bytes as with its own" {
    simulate own.scene.json --frames 0:12 -o own.pc2 --log own.jsonl --lengths own.tsv --penetration
    simulate one.scene.json --frames 0:12 -o one.pc2 --log one.jsonl --lengths one.tsv --penetration
    cmp own.pc2 one.pc2
    cmp own.jsonl one.jsonl
    (mkdir away && cd away && simulate ../one.scene.json --frames 0:12 -o one.pc2 --log one.jsonl --penetration --lengths one.tsv)
    cmp own.jsonl away/one.jsonl
    simulate one.scene.json --plan > plan.json
    [ "$(member plan.json '[[b["name"], b["mesh"], b["units"], b.get("joint")] for b in d["scene"]["bones"]]')" = \
        '[["scapula", "body/../scapula.ply", 1, null], ["humerus", "body/../humerus.ply", 1, null], ["ulna", "body/ulna.ply", 1, "elbow"], ["radius", "body/radius.ply", 1, "elbow"]]' ]
    # the plan's scene is a scene, and runs to the same bytes
    python3 -c 'import json; json.dump(json.load(open("plan.json"))["scene"], open("planned.scene.json", "w"))'
    simulate planned.scene.json --frames 0:12 -o planned.pc2 --log planned.jsonl --penetration --lengths planned.tsv
    cmp one.pc2 planned.pc2
    cmp one.tsv planned.tsv
}

@test "a scene's bone takes the place of the document's, on its joint; two bones of a document with one name are refused" {
    cp one.scene.json swapped.scene.json
    edit swapped.scene.json <<< 's["bones"] = [{"name": "radius", "mesh": "humerus.ply", "units": "cm"}, {"name": "ulna", "mesh": "humerus.ply", "joint": "elbow"}]'
    simulate swapped.scene.json --plan > plan.json
    [ "$(member plan.json '[[b["name"], b["mesh"], b.get("units"), b.get("joint")] for b in d["scene"]["bones"]]')" = \
        '[["radius", "humerus.ply", 0.01, "elbow"], ["ulna", "humerus.ply", null, "elbow"], ["scapula", "body/../scapula.ply", 1, null], ["humerus", "body/../humerus.ply", 1, null]]' ]
    edit body/arm.motion.json <<< 's["bones"].append(dict(s["bones"][0]))'
    run -1 simulate one.scene.json --plan
    [[ "$output" == *'two bones have the name "scapula"'* ]]
}

@test "a plan does not tell the unit of a mesh that it has not read, and its scene has the same bones" {
    cat > ulna.dae << 'END'
<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">0 0 0 10 0 0 0 10 0 0 0 10</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
END
    edit own.scene.json <<< 's["bones"][2]["mesh"] = "ulna.dae"'
    edit body/arm.motion.json <<< '[s["bones"][2].pop("units"), s["bones"][2].update(mesh="../ulna.dae")]'
    for scene in own one; do
        simulate $scene.scene.json --plan > plan.json
        python3 -c 'import json; json.dump(json.load(open("plan.json"))["scene"], open("planned.scene.json", "w"))'
        simulate -q $scene.scene.json --frames 0:0 --bone-frames $scene.pvd --log log.jsonl
        simulate -q planned.scene.json --frames 0:0 --bone-frames planned.pvd --log log.jsonl
        cmp $scene.0000.vtp planned.0000.vtp
    done
    cmp own.0000.vtp one.0000.vtp
}

@test "bones beside the joints in a scene's own motion; a mesh that is missing is named with its bone" {
    edit own.scene.json <<< 's["motion"]["bones"] = s.pop("bones")'
    simulate own.scene.json --plan > plan.json
    [ "$(member plan.json '[b["mesh"] for b in d["scene"]["bones"]]')" = '["scapula.ply", "humerus.ply", "body/ulna.ply", "body/radius.ply"]' ]
    if /usr/bin/python3 -c 'import jsonschema' 2> /dev/null; then
        /usr/bin/python3 -c 'import json, sys, jsonschema
for kind, name in (("scene", "own.scene.json"), ("scene", "one.scene.json"), ("motion", "body/arm.motion.json")):
    jsonschema.Draft202012Validator(json.load(open("%s/%s.schema.json" % (sys.argv[1], kind)))).validate(json.load(open(name)))' "$schemas"
    fi
    rm body/ulna.ply
    run -1 simulate one.scene.json --frames 0:1 --lengths l.tsv --penetration
    [[ "$output" == *body/ulna.ply*'bone "ulna"'* ]]
    simulate one.scene.json --frames 0:1 > log.jsonl # nobody needs the surface
}

@test "two columns of one name are told" {
    simulate one.scene.json --frames 0:0 --log log.jsonl --lengths l.tsv 2> err
    refute grep -q columns err
    edit body/arm.motion.json <<< 's["coordinates"].append({"name": "elbow_flexion", "unit": "rad", "values": [1]})'
    simulate one.scene.json --frames 0:0 --log log.jsonl --lengths l.tsv 2> err
    grep -Eq 'l.tsv: two columns have the name "elbow[ _]flexion.rad"' err
    edit body/arm.motion.json <<< 's["coordinates"][-1]["name"] = "lift"' # a name that another has
    run -1 simulate one.scene.json --frames 0:0
    [[ "$output" == *'two coordinates have the name "lift"; give one another name'* ]]
}

@test "lengths have the coordinates as columns, with their units, at the frames' times" {
    simulate one.scene.json --frames 0:12 --lengths l.tsv --log log.jsonl
    simulate one.scene.json --frames 0:12 --lengths l.sto --smooth-lengths --log log.jsonl
    python3 - <<'END'
def table(name):
    lines = open(name).read().split("\n")
    if name.endswith(".sto"): lines = lines[lines.index("endheader") + 1:]
    return lines[0].split("\t"), [[float(x) for x in line.split("\t")] for line in lines[1:] if line]
plain, smooth = table("l.tsv"), table("l.sto")
assert plain[0] == smooth[0]
assert plain[0][:6] == ["time", "elbow.angle", "elbow_flexion.rad", "lift.m", "beat", "biceps.1"], plain[0][:6]
wave = [0.25 * k * k for k in range(5)]
for names, rows in plain, smooth: # inputs are never smoothed
    assert len(rows) == 13
    for f, row in enumerate(rows):
        at = min(f / 24 * 12, 4.0); k = min(int(at), 3)
        assert abs(row[2] - (wave[k] + (at - k) * (wave[k + 1] - wave[k]))) < 1e-12
        assert row[3] == 0.5
        assert abs(row[4] - min(1.0 + f, 3.0)) < 1e-12
assert plain[1][12][5:] != smooth[1][11][5:]
END
}

# What frames of bones are held against: the hinge of the arm by its own formula, vertices from the meshes' files.
bone_checks() { cat <<'END'
import json, math, struct
keys = [[0.25, 0], [2.0, 120]]
def angle(time): # smoothstep between the keys
    t = min(max((time - keys[0][0]) / (keys[1][0] - keys[0][0]), 0), 1)
    return math.radians(120 * t * t * (3 - 2 * t))
def posed(p, time): # about -y through the origin
    c, s = math.cos(angle(time)), math.sin(angle(time))
    return (c * p[0] - s * p[2], p[1], s * p[0] + c * p[2])
def ply(path): # vertices: x, y, z first, in single or double
    data = open(path, "rb").read()
    head, body = data[:data.index(b"end_header\n")].decode().split("\n"), data[data.index(b"end_header\n") + 11:]
    count = int([l.split()[2] for l in head if l.startswith("element vertex")][0])
    kinds, inside = [], False
    for l in head:
        if l.startswith("element"): inside = l.startswith("element vertex")
        if l.startswith("property") and inside: kinds.append({"float": "f", "double": "d", "uchar": "B", "int": "i"}[l.split()[1]])
    if "format ascii 1.0" in head: return [tuple(float(x) for x in l.split()[:3]) for l in body.decode().split("\n")[:count]]
    form = "<" + "".join(kinds)
    return [struct.unpack_from(form, body, i * struct.calcsize(form))[:3] for i in range(count)]
def pc2(path):
    data = open(path, "rb").read()
    signature, version, points, start, rate, samples = struct.unpack("<12siiffi", data[:32])
    assert signature == b"POINTCACHE2\0" and len(data) == 32 + 12 * points * samples
    flat = struct.unpack("<%df" % (3 * points * samples), data[32:])
    return start, [[flat[3 * (s * points + i):][:3] for i in range(points)] for s in range(samples)]
def vtp(path): # raw appended doubles, in the order of their names
    data = open(path, "rb").read()
    mark = data.index(b"_", data.index(b'encoding="raw"')) + 1
    head = data[:mark].decode()
    def array(name):
        tag = [t for t in head.split("<DataArray")[1:] if 'Name="%s"' % name in t][0]
        at = mark + int(tag.split('offset="')[1].split('"')[0])
        size = struct.unpack_from("<Q", data, at)[0]
        kind = {"Float64": "d", "Int32": "i", "UInt8": "B", "Int64": "q"}[tag.split('type="')[1].split('"')[0]]
        return struct.unpack_from("<%d%s" % (size // struct.calcsize(kind), kind), data, at + 8)
    names = head.split('Name="bone_names"')[1].split(">", 1)[1].split("</Array>")[0].split()
    labels = bytes(int(n) for n in names).decode().split("\0")[:-1]
    flat = array("Points")
    return [flat[3 * i:3 * i + 3] for i in range(len(flat) // 3)], array("bone"), labels
files = {"scapula": "scapula.ply", "humerus": "humerus.ply", "ulna": "body/ulna.ply", "radius": "body/radius.ply"}
rest = {name: ply(path) for name, path in files.items()}
def expected(name, time): return [posed(p, time) if name in ("ulna", "radius") else p for p in rest[name]]
def worst(a, b):
    assert len(a) == len(b) > 0
    return max(math.dist(p, q) for p, q in zip(a, b))
END
}

@test "frames of bones are their rest places under the pose: point caches, PLY, VTP" {
    simulate one.scene.json --frames 10:14 -o caches --bone-frames caches --log log.jsonl
    [ "$(ls caches | tr '\n' ' ')" = "biceps.pc2 humerus.pc2 radius.pc2 scapula.pc2 ulna.pc2 " ]
    simulate one.scene.json --frames 10:14 --format ply --bone-frames plys --log log.jsonl
    [ "$(ls plys | wc -l)" -eq 20 ]
    simulate one.scene.json --frames 10:14 --bone-frames vtps.pvd --log log.jsonl
    [ "$(ls vtps* | tr '\n' ' ')" = "vtps.0010.vtp vtps.0011.vtp vtps.0012.vtp vtps.0013.vtp vtps.0014.vtp vtps.pvd " ]
    grep -q 'timestep="0.5" part="0" file="vtps.0012.vtp"' vtps.pvd
    { bone_checks; cat <<'END'; } | python3 -
for name in files:
    start, samples = pc2("caches/%s.pc2" % name)
    assert start == 10 and len(samples) == 5
    for k, sample in enumerate(samples):
        time = (10 + k) / 24
        assert worst(sample, expected(name, time)) < 2e-7 * 0.5 # single precision, half a metre
        assert worst(ply("plys/%s.%04d.ply" % (name, 10 + k)), expected(name, time)) < 1e-7
moved = 0
for k in range(5):
    points, number, labels = vtp("vtps.%04d.vtp" % (10 + k))
    assert labels == ["scapula", "humerus", "ulna", "radius"] and len(number) == len(points)
    for b, name in enumerate(labels):
        mine = [p for p, n in zip(points, number) if n == b]
        assert worst(mine, expected(name, (10 + k) / 24)) < 1e-12
        moved = max(moved, worst(mine, rest[name]))
assert moved > 0.01
END
}

@test "bones beside a muscle in millimetres, stopped inside a frame, and going on from a state" {
    printf 'OFF\n4 4 0\n0 0 0\n100 0 0\n0 100 0\n0 0 100\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' | mesh-clean -q --units mm -o mm.muscle.json
    cp one.scene.json mm.scene.json
    cp one.scene.json mixed.scene.json
    edit mm.scene.json <<< 's["muscles"] = [{"name": "mm", "rig": "mm.muscle.json"}]'
    edit mixed.scene.json <<< 's["muscles"].append({"name": "mm", "rig": "mm.muscle.json"})'
    simulate -q mm.scene.json --frames 12:12 --bone-frames mm.pvd --log log.jsonl
    simulate -q mm.scene.json --frames 12:12 --bone-frames mm --log log.jsonl
    simulate -q mixed.scene.json --frames 12:12 --bone-frames mixed.pvd --log log.jsonl
    simulate one.scene.json --frames 10:14 --bone-frames whole.pvd --log log.jsonl --solver xpbd --substeps 4
    simulate one.scene.json --frames 10:14 --stop-after 12 --state mid.state --bone-frames begun --log log.jsonl --solver xpbd --substeps 4
    simulate one.scene.json --frames 13:14 --from mid.state --bone-frames rest.pvd --log log.jsonl --solver xpbd --substeps 4
    cmp whole.0013.vtp rest.0013.vtp
    cmp whole.0014.vtp rest.0014.vtp
    simulate one.scene.json --frames 10:14 --stop-after 12:3 --bone-frames within.pvd --log log.jsonl --solver xpbd --substeps 4
    { bone_checks; cat <<'END'; } | python3 -
for path, unit in ("mm.0012.vtp", 1e-3), ("mixed.0012.vtp", 1.0): # the muscles' unit, where they have one
    points, number, labels = vtp(path)
    mine = [tuple(x * unit for x in p) for p, n in zip(points, number) if labels[n] == "radius"]
    assert worst(mine, expected("radius", 0.5)) < 1e-12
assert worst(pc2("mm/radius.pc2")[1][0], expected("radius", 0.5)) < 1e-7 # a cache is in its mesh's own unit
points, number, labels = vtp("within.0012.vtp")
mine = [p for p, n in zip(points, number) if labels[n] == "ulna"]
assert worst(mine, expected("ulna", (11 + 3 / 4) / 24)) < 1e-12
END
}

@test "VTK reads the bones and their names" {
    simulate one.scene.json --frames 10:10 --bone-frames vtps.pvd --log log.jsonl
    code=0
    /usr/bin/python3 "$BATS_TEST_DIRNAME/../vtk-check.py" copy vtps.0010.vtp copy.vtp > said || code=$?
    [ "$code" -ne 77 ] || skip "python3-vtk9 is not installed"
    [ "$code" -eq 0 ]
    [ "$(cat said)" = "bone_names scapula humerus ulna radius" ]
}

@test "frames of bones that would share a file, or cannot be, are refused" {
    cp one.scene.json clash.scene.json
    edit clash.scene.json <<< 's["bones"] = [{"name": "a/b", "mesh": "humerus.ply"}, {"name": "a_b", "mesh": "humerus.ply"}]'
    run -1 simulate clash.scene.json --frames 0:0 --bone-frames out --log log.jsonl
    [[ "$output" == *'"a/b" and "a_b" would share a file'* ]]
    edit clash.scene.json <<< 's["bones"] = [{"name": "biceps", "mesh": "humerus.ply"}]'
    run -1 simulate clash.scene.json --frames 0:0 -o out --bone-frames ./out/ --log log.jsonl
    [[ "$output" == *'muscle "biceps" would share a file'* ]]
    simulate clash.scene.json --frames 0:0 -o out --bone-frames out/bones --log log.jsonl
    [ -s out/bones/biceps.pc2 ]
    run -1 simulate one.scene.json --frames 0:0 -o out/ulna.pc2 --bone-frames out --log log.jsonl
    [[ "$output" == *'bone "ulna"'*'would both be'* ]]
    run -2 simulate one.scene.json --frames 0:0 --bone-frames x.pvd --format ply
    run -2 simulate one.scene.json --frames 0:0 --bone-frames -
    run -1 simulate one.scene.json --frames 0:0 --bone-frames none/there
    printf '{"format": "sinew-scene", "version": 1}' > bare.scene.json
    run -1 simulate bare.scene.json --bone-frames out
    [[ "$output" == *"no bones"* ]]
    # a scene of bones alone
    edit one.scene.json <<< 's["muscles"] = []'
    simulate -q one.scene.json --frames 0:3 --bone-frames alone --log log.jsonl
    [ "$(ls alone | wc -l)" -eq 4 ]
}

# STATEMENTS: bent.scene.json, the arm's muscles without activation for half a second, changed by statements on its scene s and elbow e
bent() { python3 - "$1" <<'END'
import json, sys
s = json.load(open("arm.scene.json"))
for bone in s["bones"][2:]: bone["mesh"] = "body/" + bone["mesh"]
for muscle in s["muscles"]: muscle["activation"] = 0.0
s["frames"], e = [0, 12], s["motion"]["joints"][0]
exec(sys.argv[1])
json.dump(s, open("bent.scene.json", "w"))
END
}
# LOG EXPRESSION: for every line l of frame 0
first() { python3 -c 'import json, sys
for line in open(sys.argv[1]):
    l = json.loads(line)
    if l["frame"] == 0: assert eval(sys.argv[2]), l' "$1" "$2"; }
# CACHE CACHE LIMIT: the last samples of two folders are as near as LIMIT, m
near() { python3 - "$@" <<'END'
import math, struct, sys
def last(path):
    data = open(path, "rb").read()
    points, samples = struct.unpack_from("<i", data, 16)[0], struct.unpack_from("<i", data, 28)[0]
    flat = struct.unpack_from("<%df" % (3 * points), data, 32 + 12 * points * (samples - 1))
    return [flat[3 * i:3 * i + 3] for i in range(points)]
for name in "biceps", "brachialis", "triceps":
    worst = max(map(math.dist, last("%s/%s.pc2" % (sys.argv[1], name)), last("%s/%s.pc2" % (sys.argv[2], name))))
    assert worst < float(sys.argv[3]), (name, worst)
END
}

@test "a motion that begins bent: torn at its first frame without a run-in, whole with one, and at the rest of a slow bend" {
    bent 'e["keys"] = [[0, 90]]'
    run -3 simulate -q bent.scene.json --frames 0:0 --fail-on 'triangle<0.3' --log log.jsonl
    simulate -q bent.scene.json --preroll 2 --run-in 1 -o in --fail-on 'triangle<0.7,edge>1.3,torn>0' --log in.jsonl
    bent 'e.update(keys=[[0, 0], [4, 90]]); s["frames"] = [0, 144]'
    simulate -q bent.scene.json -o slow --log slow.jsonl
    near in slow 1e-5
    # at 120 degrees holding alone leaves the brachialis torn on the way
    bent 'e["keys"] = [[0, 120]]; s["preroll"] = 2'
    simulate bent.scene.json --log log.jsonl 2> err
    grep -q '"brachialis" was torn in frame 0' err
    edit bent.scene.json <<< 's["runIn"] = 1'
    simulate bent.scene.json --log log.jsonl 2> err
    refute grep -q torn err
    first log.jsonl 'not l["torn"] and l["smallest_triangle"] > 0.6'
}

@test "poses run in as hinges do, about their centre or along their screw, under both solvers" {
    bent 'e["keys"] = [[0, 90]]; s["preroll"], s["runIn"] = 2, 1'
    key='s["motion"]["joints"][0] = {"name": "elbow", "type": "pose", "keys": [{"time": 0, "rotation": [0.5 ** 0.5, 0, -0.5 ** 0.5, 0]}]}'
    for solver in qn xpbd; do
        simulate -q bent.scene.json --frames 0:0 --solver $solver -o hinge-$solver --log log.jsonl
    done
    edit bent.scene.json <<< "$key"
    for solver in qn xpbd; do
        simulate -q bent.scene.json --frames 0:0 --solver $solver -o screw-$solver --log log.jsonl
        near screw-$solver hinge-$solver 1e-6
    done
    edit bent.scene.json <<< 's["motion"]["joints"][0]["rest"] = [0, 0, 0]'
    for solver in qn xpbd; do
        simulate -q bent.scene.json --frames 0:0 --solver $solver -o centre-$solver --log log.jsonl
        near centre-$solver hinge-$solver 1e-6
    done
}

@test "no run-in and one that moves nothing: the same bytes; threads change none" {
    bent 'e["keys"] = [[0, 0], [0.5, 20]]; s["preroll"] = 1; s["gravity"] = [0, 0, -9.81]'
    simulate -q bent.scene.json -o absent --log absent.jsonl --state absent.state
    simulate -q bent.scene.json -o zero --log zero.jsonl --state zero.state --run-in 0
    simulate -q bent.scene.json -o still --log still.jsonl --state still.state --run-in 0.5
    for muscle in biceps brachialis triceps; do cmp absent/$muscle.pc2 zero/$muscle.pc2; cmp absent/$muscle.pc2 still/$muscle.pc2; done
    cmp absent.jsonl zero.jsonl
    cmp absent.jsonl still.jsonl
    cmp absent.state still.state
    bent 'e["keys"] = [[0, 100]]; s["preroll"], s["runIn"] = 1, 0.6'
    for threads in 1 3; do simulate -q bent.scene.json --threads $threads -o t$threads --log t$threads.jsonl --state t$threads.state; done
    cmp t1.state t3.state
    cmp t1.jsonl t3.jsonl
    # and somebody who watches sees the same
    simulate -q bent.scene.json --trace trace.jsonl -o seen --log seen.jsonl --state seen.state
    cmp t1.state seen.state
}

@test "a run that stops after its run-in goes on to the same bytes" {
    bent 'e["keys"] = [[0, 100], [0.5, 110]]; s["preroll"], s["runIn"] = 0.8, 0.6'
    for solver in qn xpbd; do
        simulate -q bent.scene.json --solver $solver --frames 0:6 --log whole.jsonl --state whole.state
        simulate -q bent.scene.json --solver $solver --frames 0:6 --stop-after 0 --log begun.jsonl --state begun.state
        simulate -q bent.scene.json --solver $solver --frames 1:6 --from begun.state --log ended.jsonl --state ended.state
        cmp whole.state ended.state
        cat begun.jsonl ended.jsonl | cmp - whole.jsonl
    done
}

@test "an explosion in the run-in is told, and a run-in beyond the preroll refused" {
    bent 'e["keys"] = [[0, 170]]; s["preroll"], s["runIn"] = 0.5, 0.05; s["solver"] = {"method": "xpbd", "scheme": "romeo", "substeps": 1, "iterations": 1}'
    run -3 simulate bent.scene.json --frames 0:0 --log log.jsonl
    [[ "$output" == *"the run-in, "*" % of the way to frame 0: muscle "*"exploded"*"a longer run-in may help"* ]]
    run -1 simulate bent.scene.json --frames 0:0 --log log.jsonl --preroll 0.01
    [[ "$output" == *"runIn is 0.05 s; it is a part of the preroll"* ]]
    run -1 simulate bent.scene.json --frames 0:0 --log log.jsonl --run-in 1
    edit bent.scene.json <<< 's["runIn"] = -1'
    run -1 simulate bent.scene.json --frames 0:0
    [[ "$output" == *runIn* ]]
}
