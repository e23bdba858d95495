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
