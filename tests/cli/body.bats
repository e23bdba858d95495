# share/examples/body: muscles of a whole body on a recorded walk, from surfaces to frames, by its Makefile. The short form of make body-walk.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

makefile=$BATS_TEST_DIRNAME/../../share/examples/body/Makefile
# one with a pin, one that is wrapped, one on a bone whose file has another unit, one of two joints, one of the shoulder, one of the thigh
six='*_Left_soleus *_Left_palmaris_longus *_Right_sternocleidomastoid *_Long_head_of_right_biceps_femoris *_Spinal_part_of_left_deltoid *_Left_vastus_lateralis'

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    unset MAKEFLAGS MFLAGS MAKELEVEL
    command -v make > /dev/null || skip "make is not there"
}

anatomy() {
    [ -d "$DATA/body-bp3d-low" ] || skip "no body-bp3d-low in DATA"
    [ -d "$DATA/mocap-cmu" ] || skip "no mocap-cmu in DATA"
}

body() { make -j2 -f "$makefile" TOOLS="$BIN" DATA="$DATA" MUSCLES="$six" FRAMES=0:9 SIMULATE_OPTIONS='--format ply' "$@" > said 2>&1 || { tail -n 20 said; return 1; }; }
ran() { grep -oE "/(motion-import|motion-fit|motion-sense|scene-build|simulate) |: (mesh-clean|root-select|build-structure|fiber-flow|attach-detect)$" said | sort | uniq -c | sed 's/[ /:]//g' | tr '\n' ' '; }

@test "six muscles of a body walk: all in the log, attached vertices where the joints' poses take them, nothing that is not finite" {
    anatomy
    body simulation
    [ "$(ran)" = "1motion-fit 1motion-import 1motion-sense 1scene-build 1simulate 6attach-detect 6build-structure 6fiber-flow 6mesh-clean 6root-select " ]
    /usr/bin/python3 - << 'END'
import glob, json, math, os, struct
def rotate(q, v):
    w, x, y, z = q
    t = (2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0]))
    return (v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0])
def multiply(a, b):
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])
motion, scene = json.load(open("walk.motion.json")), json.load(open("walk.scene.json"))
assert motion["rate"] == scene["rate"] == 120 and scene["frames"] == [0, 9] and scene["preroll"] > 0
poses = {} # of each joint in each frame: its keys, down the tree
for joint in motion["joints"]:
    poses[joint["name"]] = []
    for f in range(10):
        key = joint["keys"][f]
        q, t = tuple(key["rotation"]), tuple(key.get("translation", (0, 0, 0)))
        if joint.get("parent"):
            pq, pt = poses[joint["parent"]][f]
            q, t = multiply(pq, q), tuple(a + b for a, b in zip(rotate(pq, t), pt))
        poses[joint["name"]].append((q, t))
bones = {bone["name"]: bone["joint"] for bone in motion["bones"]}
assert len(bones) == 202
def ply(path):
    data = open(path, "rb").read()
    head, body = data[:data.index(b"end_header\n")].decode(), data[data.index(b"end_header\n") + 11:]
    assert "format binary_little_endian" in head and head.count("property double") == 3
    n = int(head.split("element vertex ")[1].split("\n")[0])
    return [struct.unpack_from("<3d", body, 24 * i) for i in range(n)]
names = sorted(os.path.basename(path)[:-len(".muscle.json")] for path in glob.glob("rigs/*.muscle.json"))
assert len(names) == 6 and names == sorted(m["name"] for m in scene["muscles"]) == sorted(open("names.txt").read().split()), names
farthest = least = held_by = 0
for name in names:
    rig = json.load(open("rigs/%s.muscle.json" % name))
    flat, unit = rig["mesh"]["vertices"], rig["metersPerUnit"]
    assert unit == 0.001
    assert len(rig["attachments"]) > 1, name
    for f in range(10):
        points = ply("frames/%s.%04d.ply" % (name, f))
        assert len(points) == len(flat) // 3 and all(math.isfinite(x) for p in points for x in p)
        for attachment in rig["attachments"]:
            q, t = poses[bones[attachment["bone"]]][f]
            for i in attachment["vertices"]:
                rest = [unit * x for x in flat[3 * i:3 * i + 3]]
                there = tuple(a + b for a, b in zip(rotate(q, rest), t))
                assert math.dist(there, [unit * x for x in points[i]]) < 1e-9, (name, f, i)
                farthest = max(farthest, math.dist(there, rest))
                held_by += 1
assert held_by > 1000 and farthest > 0.5, (held_by, farthest) # the walk begins metres from the rest pose
manubrium = [a for a in json.load(open(glob.glob("rigs/*_sternocleidomastoid.muscle.json")[0]))["attachments"] if a["bone"].endswith("_Manubrium")]
assert manubrium and len(manubrium[0]["vertices"]) >= 3
rows = [json.loads(line) for line in open("walk.jsonl")]
assert sorted((row["frame"], row["muscle"]) for row in rows) == [(f, name) for f in range(10) for name in names]
assert all(row["nan"] == 0 and abs(row["volume_error"]) < 0.05 for row in rows)
assert max(row["activation"] for row in rows) > 0.1 # a sensor speaks
assert json.load(open("walk.report.json"))["outcome"]["exploded"] == []
END
}

@test "what has not changed is not made again; other frames make a scene and run it; a muscle less leaves the rigs as they are" {
    anatomy
    six='*_Left_soleus *_Left_vastus_lateralis' body simulation
    touch -r walk.jsonl before
    six='*_Left_soleus *_Left_vastus_lateralis' body simulation
    [ -z "$(ran)" ]
    [ ! walk.jsonl -nt before ]
    six='*_Left_soleus *_Left_vastus_lateralis' body simulation FRAMES=0:2
    [ "$(ran)" = "1scene-build 1simulate " ]
    [ "$(wc -l < walk.jsonl)" -eq 6 ]
    six='*_Left_soleus' body simulation FRAMES=0:2
    [ "$(ran)" = "1motion-sense 1scene-build 1simulate " ]
    [ "$(cut -d'"' -f8 walk.jsonl | sort -u)" = "$(cat names.txt)" ]
    [ "$(wc -l < walk.jsonl)" -eq 3 ]
}

@test "no body, or no muscle of that name: one sentence, and no work" {
    run -2 make -f "$makefile" TOOLS="$BIN" DATA="$BATS_TEST_TMPDIR/nowhere"
    [[ "$output" == *"no body at '$BATS_TEST_TMPDIR/nowhere/body-bp3d-low'"*DATA* ]]
    mkdir -p here/body-bp3d-low/meshes
    printf 'file\tkind\nm.obj\tmuscle\n' > here/body-bp3d-low/manifest.tsv
    run -2 make -f "$makefile" TOOLS="$BIN" DATA=here
    [[ "$output" == *"no muscle in"*"matches MUSCLES"* ]]
    [ "$(ls)" = here ]
}

# an arm's muscles, one of them on an elbow that bends, one on the forearm alone
arm='*_left_biceps_brachii *_Left_brachialis *_head_of_left_triceps_brachii *_Left_flexor_carpi_radialis *_Left_coracobrachialis'
tied() { body MUSCLES="$arm" BEND_FRAMES=0:70 TORSION_FRAMES=0:75 SHAKE_FRAMES=0:150 TIED_OPTIONS= "$@"; }

@test "an arm tied to itself and to the envelope: it bends, turns and is shaken; rows lie on muscles and the envelope; nothing is torn" {
    anatomy
    tied tied/bend-gain.jsonl tied/torsion.jsonl tied/shake.jsonl
    /usr/bin/python3 - << 'END'
import glob, json, math, struct
names = open("names.txt").read().split()
assert len(names) == 8, names
rigs = {name: json.load(open("rigs/candidates/%s.muscle.json" % name)) for name in names}
envelope = json.load(open("skeleton.envelope.json"))
skeleton = json.load(open("skeleton.muscle.json"))
assert envelope["mesh"]["triangles"] == skeleton["mesh"]["triangles"] and 9000 < len(skeleton["mesh"]["triangles"]) // 3 <= 10700
# every row: the target is there, and the vertex is as far from its point as it says, in the rig's millimetres
rows = {"skeleton": 0, "muscle": 0}
for name, rig in rigs.items():
    assert rig["metersPerUnit"] == 0.001
    for e in rig["externals"]:
        mesh, scale = (skeleton, skeleton["metersPerUnit"] / 0.001) if e["target"] == "skeleton" else (rigs[e["target"]], 1.0)
        corner = lambda i, mesh=mesh["mesh"], scale=scale: [scale * x for x in mesh["vertices"][3 * i:3 * i + 3]]
        for k, v in enumerate(e["vertices"]):
            t = mesh["mesh"]["triangles"][3 * e["triangles"][k]:3 * e["triangles"][k] + 3]
            q = [sum(b * corner(i)[axis] for b, i in zip(e["barycentric"][3 * k:3 * k + 3], t)) for axis in range(3)]
            assert abs(math.dist(q, rig["mesh"]["vertices"][3 * v:3 * v + 3]) - abs(e["distances"][k])) < 1e-3, (name, e["target"], v)
        rows["skeleton" if e["target"] == "skeleton" else "muscle"] += len(e["vertices"])
assert rows["skeleton"] > 50 and rows["muscle"] > 200, rows
def log(name): return [json.loads(line) for line in open("tied/%s.jsonl" % name)]
def cache(name, muscle):
    data = open("tied/%s/%s.pc2" % (name, muscle), "rb").read()
    points, samples = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
    flat = struct.unpack("<%df" % (3 * points * samples), data[32:])
    return [[flat[3 * (s * points + i):3 * (s * points + i) + 3] for i in range(points)] for s in range(samples)]
def way(name, muscle, a, b): c = cache(name, muscle); return max(math.dist(p, q) for p, q in zip(c[a], c[b]))
biceps = next(n for n in names if "Long_head_of_left_biceps" in n)
carpi = next(n for n in names if "flexor_carpi_radialis" in n)
for name, frames in ("bend-gain", 71), ("torsion", 76), ("shake", 151):
    of = log(name)
    assert len(of) == 8 * frames and all(r["nan"] == 0 for r in of), name
    assert open("tied/%s.status" % name).read().strip() == "0", (name, open("tied/%s.said" % name).read()[-600:])
    assert not any(r["torn"] for r in of if r["frame"] == frames - 1), name
    assert max(abs(r["volume_error"]) for r in of) < 0.05, name
# the elbow bends by 130 degrees: what hangs on the forearm goes far, and the biceps acts and gains volume
assert way("bend-gain", carpi, 0, 70) > 200 and way("bend-gain", biceps, 0, 70) > 20
end = [r for r in log("bend-gain") if r["frame"] == 70 and r["muscle"] == biceps][0]
assert end["activation"] > 0.5 and end["volume_goal"] > 1.15 and abs(end["volume_ratio"] / end["volume_goal"] - 1) < 0.03, end
# the forearm turns by 150 degrees
assert min(r["smallest_triangle"] for r in log("torsion")) > 0.05
assert 5 < way("torsion", biceps, 0, 75) < 60
# the shake moves the arm far, and it comes back
for name in names:
    assert way("shake", name, 0, 150) < 2.0, (name, way("shake", name, 0, 150))
assert max(way("shake", carpi, 0, f) for f in range(20, 60)) > 60
END
    "$BIN/simulate" -q tied/torsion.scene.json --plan | /usr/bin/python3 -c 'import json, sys
plan = json.load(sys.stdin)["plan"]
assert [len(g["muscles"]) for g in plan["coupled"]] and sum(g["rows"] for m in plan["muscles"] for g in m["groups"] if g["kind"] == "external") > 150'
}

@test "a motion for arms: joints and bones of the table, axes of left and right that mirror each other, from rest; what it does not know is refused" {
    anatomy
    body MUSCLES="$arm" bend.motion.json shake.motion.json motion
    /usr/bin/python3 - << 'END'
import json
bend, walk = json.load(open("bend.motion.json")), json.load(open("walk.motion.json"))
assert {b["name"]: b["joint"] for b in bend["bones"]} == {b["name"]: b["joint"] for b in walk["bones"]} and len(bend["bones"]) == 202
joints = {j["name"]: j for j in bend["joints"]}
assert sorted(j for j in joints if "keys" in joints[j]) == ["elbow_left", "elbow_right"]
left, right = joints["elbow_left"], joints["elbow_right"]
assert left["keys"][0] == [0, 0] and left["keys"] == right["keys"] and abs(left["keys"][-1][1] - 130) < 1e-9
assert left["axis"][0] < 0 and right["axis"][0] < 0 and left["point"][0] > 0.15 and right["point"][0] < -0.15
for key in json.load(open("shake.motion.json"))["joints"]:
    if "keys" in key: assert abs(key["keys"][0][1]) < 1e-12 and abs(key["keys"][-1][1]) < 1e-12
END
    run -1 awk -v motion=hop -f "$(dirname "$makefile")/arms.awk" /dev/null
    [[ "$output" == *"motion is bend, torsion or shake"* ]]
}

@test "a picture of a run that did not end well says so; one of no frames is refused" {
    mkdir tied
    printf '{"frame":0,"muscle":"m"}\n{"frame":3,"muscle":"m"}\n' > tied/x.jsonl
    echo 3 > tied/x.status
    echo 'simulate: frame 2: muscle "m" has exploded, its edge between vertices 1 and 2 is 11 times its goal length' > tied/x.said
    mkdir tools
    printf '#!/bin/sh\nprintf "%%s\\n" "$@"\n' > tools/rig-view
    chmod +x tools/rig-view
    run -0 env TOOLS=tools sh "$(dirname "$makefile")/sheet.sh" tied/x 4 "A title" -o out.png
    [[ "$output" == *'A title: status 3, frame 2: muscle "m" has exploded'* ]]
    [[ "$output" == *"0,1,2,3"* ]]
    : > tied/x.jsonl
    run -1 env TOOLS=tools sh "$(dirname "$makefile")/sheet.sh" tied/x 4 "A title" -o out.png
    [[ "$output" == *"has no frames"* ]]
}
