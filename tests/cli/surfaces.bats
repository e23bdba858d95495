# Surfaces of a scene: muscles on an envelope, and on the same surface as a host would hand it over: PC2, MDD, numbered meshes.

bats_require_minimum_version 1.5.0

schemas="$BATS_TEST_DIRNAME/../../share/schema"

# The sample arm with an envelope over its bones, to which the biceps' insertion is attached in place of the radius.
setup_file() {
    export SAMPLE="$BATS_FILE_TMPDIR/sample"
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" "$SAMPLE"
    cd "$SAMPLE" || exit 1
    cat > elbow.motion.json << 'END'
{ "format": "sinew-motion", "version": 1, "metersPerUnit": 1, "rate": 24, "joints": [
  { "name": "elbow", "type": "hinge", "axis": [0,-1,0], "point": [0,0,0], "keys": [[0.25,0], [2,120]], "interpolation": "smooth" } ],
  "bones": [ {"name":"scapula","mesh":"scapula.ply"}, {"name":"humerus","mesh":"humerus.ply"}, {"name":"ulna","mesh":"ulna.ply","joint":"elbow"},
             {"name":"radius","mesh":"radius.ply","joint":"elbow"} ] }
END
    "$BIN/envelope-bind" --bones elbow.motion.json --write-bones bones.ply
    "$BIN/mesh-clean" -q bones.ply --wrap 0.004 --keep all -o skin.ply
    "$BIN/envelope-bind" -q skin.ply --bones elbow.motion.json -o skin.envelope.json --frames skin.pc2 --every 1
    "$BIN/attach-detect" -q brachialis.muscle.json --bone humerus=humerus.ply --bone skin=skin.ply -o on_skin.muscle.json
    rm triceps.muscle.json biceps.muscle.json
    mkdir rigs && mv on_skin.muscle.json rigs/brachialis.muscle.json
    "$BIN/scene-build" -q rigs --motion elbow.motion.json --envelope skin.envelope.json --frames 0:30 -o envelope.scene.json
    "$BIN/simulate" -q envelope.scene.json -o envelope.pc2 --log envelope.jsonl
}

setup() {
    cp -r "$SAMPLE" "$BATS_TEST_TMPDIR/arm"
    cd "$BATS_TEST_TMPDIR/arm" || exit 1
}

# driven NAME FRAMES [MEMBERS]: NAME.scene.json has the skin as a mesh whose frames are in FRAMES
driven() {
    /usr/bin/python3 - "$@" << 'END'
import json, sys
scene = json.load(open("envelope.scene.json"))
scene["surfaces"] = [dict({"name": "skin", "mesh": "skin.ply", "frames": sys.argv[2]}, **json.loads(sys.argv[3] if len(sys.argv) > 3 else "{}"))]
json.dump(scene, open(sys.argv[1] + ".scene.json", "w"))
END
}

cat_py='
import struct
def pc2(name):
    data = open(name, "rb").read()
    points, samples = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
    values = struct.unpack("<%df" % (3 * points * samples), data[32:])
    return [[values[3 * (s * points + p):3 * (s * points + p) + 3] for p in range(points)] for s in range(samples)]
import json
held = [a for a in json.load(open("rigs/brachialis.muscle.json"))["attachments"] if a["bone"] == "skin"][0]["vertices"]
def away(a, b, which): return max(sum((x - y) ** 2 for x, y in zip(f[v], g[v])) ** 0.5 for f, g in zip(a, b) for v in which)
def same(a, b):  # what is attached, to the floats; the rest to what the solver makes of a difference in the last bit
    d = away(a, b, held), away(a, b, range(len(a[0]))); print(d)
    return d[0] < 1e-7 and d[1] < 1e-3
'

refused() {
    local pattern=$1 code=0
    shift
    "$@" > out 2> err || code=$?
    [ "$code" -eq 1 ] && [ "$(wc -l < err)" -eq 1 ] || { echo "$code"; cat err; return 1; }
    grep -Eq "$pattern" err || { cat err; return 1; }
}

@test "what is attached to an envelope stays as far from it as at rest, while that moves by centimetres" {
    /usr/bin/python3 - << END
$cat_py
assert len(held) > 10
skin, muscle = pc2("skin.pc2"), pc2("envelope.pc2")
flat = json.load(open("skin.envelope.json"))["mesh"]["triangles"]
tri = [flat[3 * i:3 * i + 3] for i in range(len(flat) // 3)]
sub = lambda a, b: [x - y for x, y in zip(a, b)]
dot = lambda a, b: sum(x * y for x, y in zip(a, b))
cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
def distance2(p, a, b, c):
    ab, ac, ap = sub(b, a), sub(c, a), sub(p, a)
    n = cross(ab, ac); d = dot(n, n)
    if d > 0:
        v, w = dot(cross(ap, ac), n) / d, dot(cross(ab, ap), n) / d
        if v >= 0 and w >= 0 and v + w <= 1: return dot(ap, n) ** 2 / d
    best = 1e9
    for q, r in ((a, b), (b, c), (c, a)):
        e = sub(r, q); t = min(max(dot(sub(p, q), e) / max(dot(e, e), 1e-30), 0), 1)
        away = sub(p, [x + t * y for x, y in zip(q, e)]); best = min(best, dot(away, away))
    return best
far = lambda f, v: min(distance2(muscle[f][v], *(skin[f][i] for i in t)) for t in tri) ** 0.5
change = max(abs(far(f, v) - far(0, v)) for v in held[::3] for f in (15, 30))
way = max(sum((x - y) ** 2 for x, y in zip(muscle[0][v], muscle[30][v])) ** 0.5 for v in held)
print(change, way)
assert change < 1e-3 and way > 0.02, (change, way)
END
}

@test "the same skin as PC2, MDD and numbered meshes gives the same muscle, to what their floats hold" {
    /usr/bin/python3 - << END
$cat_py
frames = pc2("skin.pc2"); n = len(frames[0])
with open("skin.mdd", "wb") as out:
    out.write(struct.pack(">ii", len(frames), n) + struct.pack(">%df" % len(frames), *(i / 24 for i in range(len(frames)))))
    for f in frames: out.write(struct.pack(">%df" % (3 * n), *(x for p in f for x in p)))
END
    "$BIN/envelope-bind" -q skin.envelope.json --bones elbow.motion.json --frames skin.ply --every 1 -o again.envelope.json
    mkdir seq && mv skin.0*.ply seq
    driven pc2 skin.pc2
    driven mdd skin.mdd
    driven ply 'seq/skin.####.ply'
    for kind in pc2 mdd ply; do
        "$BIN/simulate" -q $kind.scene.json -o $kind.frames.pc2 --log $kind.jsonl 2> err
        [ ! -s err ] || { cat err; false; }
    done
    /usr/bin/python3 - << END
$cat_py
a = pc2("envelope.pc2")
for kind in ("pc2", "mdd", "ply"):
    assert same(a, pc2(kind + ".frames.pc2")), kind
END
}

@test "unit, axis and rate of frames are the document's to tell" {
    /usr/bin/python3 - << END
$cat_py
frames = pc2("skin.pc2"); n = len(frames[0])
with open("skin.mdd", "wb") as out:  # millimetres, y up, times that mean nothing
    out.write(struct.pack(">ii", len(frames), n) + struct.pack(">%df" % len(frames), *(i * 7.0 for i in range(len(frames)))))
    for f in frames: out.write(struct.pack(">%df" % (3 * n), *(1000 * x for p in f for x in (p[0], p[2], -p[1]))))
END
    "$BIN/mesh-clean" -q skin.ply -o skin.obj
    [ "$(grep -c '^v ' skin.obj)" -eq "$(/usr/bin/python3 -c 'import struct; print(struct.unpack("<i", open("skin.pc2", "rb").read()[16:20])[0])')" ]
    awk '$1 == "v" { printf "v %.17g %.17g %.17g\n", 1000 * $2, 1000 * $4, -1000 * $3; next } { print }' skin.obj > skin_mm.obj
    driven mm skin.mdd '{"mesh": "skin_mm.obj", "units": "mm", "up": "y", "rate": 24}'
    "$BIN/simulate" -q mm.scene.json -o mm.pc2 --log /dev/null
    /usr/bin/python3 - << END
$cat_py
assert same(pc2("envelope.pc2"), pc2("mm.pc2"))
END
}

@test "a scene on surfaces: its plan, its schema, its picture; a surface that nobody hangs on is not read" {
    "$BIN/simulate" --plan envelope.scene.json > plan.json
    /usr/bin/python3 -c 'import json; d = json.load(open("plan.json")); assert d["scene"]["surfaces"] == [{"name": "skin", "envelope": "skin.envelope.json"}], d'
    driven pc2 skin.pc2 '{"units": "m", "up": "z", "rate": 24}'
    if /usr/bin/python3 -c 'import jsonschema' 2> /dev/null; then
        /usr/bin/python3 -c 'import json, sys, jsonschema
schema = json.load(open(sys.argv[1] + "/scene.schema.json"))
jsonschema.Draft202012Validator.check_schema(schema)
for name in sys.argv[2:]: jsonschema.Draft202012Validator(schema).validate(json.load(open(name)))' "$schemas" envelope.scene.json pc2.scene.json
    fi
    "$BIN/rig-view" -q envelope.scene.json --frame 0,20 -o with.png
    "$BIN/rig-view" -q envelope.scene.json --frame 0,20 --show surface,bones -o without.png
    ! cmp -s with.png without.png
    sed -i 's/"bone": "skin"/"bone": "radius"/' rigs/brachialis.muscle.json
    rm skin.envelope.json
    "$BIN/simulate" -q envelope.scene.json --frames 0:2 -o frames.pc2
}

@test "scene-build names an envelope, counts what hangs on it, and misses what is not there" {
    "$BIN/scene-build" rigs --motion elbow.motion.json --envelope skin.envelope.json --list > list
    grep -Pq '^envelope\t1\tskin\t1\tskin.envelope.json$' list
    refused 'attached to bones that are not there: brachialis to skin' "$BIN/scene-build" rigs --motion elbow.motion.json -o x.scene.json
    refused 'is called "radius", and so is' "$BIN/scene-build" rigs --motion elbow.motion.json --envelope radius=skin.envelope.json -o x.scene.json
    "$BIN/scene-build" -q rigs --motion elbow.motion.json --envelope skin=./skin.envelope.json -o y.scene.json
    grep -q '"envelope": *"./skin.envelope.json"\|"envelope": *"skin.envelope.json"' y.scene.json
}

@test "an envelope of other bones, or without a file, is told by scene-build" {
    "$BIN/scene-build" rigs --motion elbow.motion.json --envelope skin.envelope.json -o a.scene.json 2> err
    [ "$(grep -c 'warning: envelope' err)" -eq 0 ]
    sed 's/"mesh":"\([a-z]*\).ply"/"mesh":"\1.ply","units":"mm"/g' elbow.motion.json > mm.motion.json
    "$BIN/scene-build" rigs --motion mm.motion.json --envelope skin.envelope.json -o a.scene.json 2> err
    grep -q 'warning: envelope "skin": it lies 0.[0-9]* m from the bones that carry it, on average: was it bound to bones of another rest pose' err
    run -2 "$BIN/scene-build" rigs --motion elbow.motion.json --envelope '' -o a.scene.json
    [[ "$output" == *"--envelope: '' names no file"* ]]
    run -2 "$BIN/scene-build" rigs --motion elbow.motion.json --envelope skin= -o a.scene.json
    run -1 "$BIN/scene-build" rigs --motion elbow.motion.json --envelope skin.envelope.json -o nowhere/a.scene.json
    [[ "$output" == *"nowhere/a.scene.json: cannot be written"* ]]
}

@test "wrong frames are refused in one sentence that names the file" {
    cp skin.pc2 whole.pc2
    head -c 5000 whole.pc2 > skin.pc2; driven cut skin.pc2
    refused 'skin.pc2.*cut short' "$BIN/simulate" cut.scene.json
    printf 'nonsense nonsense' > skin.mdd; driven junk skin.mdd
    refused 'skin.mdd.*neither a PC2' "$BIN/simulate" junk.scene.json
    "$BIN/simulate" -q envelope.scene.json -o m.pc2 --frames 0:1; driven other m.pc2
    refused 'm.pc2: has [0-9]+ points, but the mesh that it moves has' "$BIN/simulate" other.scene.json
    /usr/bin/python3 - << 'END'
import struct
data = bytearray(open("whole.pc2", "rb").read()); data[32 + 12 * 7:36 + 12 * 7] = struct.pack("<f", float("nan")); open("nan.pc2", "wb").write(data)
data = bytearray(open("whole.pc2", "rb").read()); data[24:28] = struct.pack("<f", 0.0); open("still.pc2", "wb").write(data)
END
    driven nan nan.pc2
    refused 'nan.pc2.*point 7 is not finite' "$BIN/simulate" nan.scene.json
    driven still still.pc2
    refused 'still.pc2.*frames 0 apart' "$BIN/simulate" still.scene.json
    driven none 'no.####.ply'
    refused 'there is no file of that name' "$BIN/simulate" none.scene.json
    driven gone gone.pc2
    refused 'gone.pc2.*cannot be opened' "$BIN/simulate" gone.scene.json
    driven bare whole.pc2
    sed -i 's/"frames": "whole.pc2"/"frame": "whole.pc2"/' bare.scene.json
    refused 'surfaces\[0\].*frames' "$BIN/simulate" bare.scene.json
    driven empty ''
    refused 'surfaces\[0\].frames: expected the name of a file' "$BIN/simulate" empty.scene.json
    sed 's/"skin.envelope.json"/"skin.ply"/' envelope.scene.json > ply.scene.json
    refused 'skin.ply' "$BIN/simulate" ply.scene.json
    sed 's/"name": *"radius"/"name": "other"/' elbow.motion.json > o.motion.json
    sed 's/elbow.motion.json/o.motion.json/' envelope.scene.json > o.scene.json
    refused 'bound to the bone "radius"' "$BIN/simulate" o.scene.json
}

@test "frames in another unit, or of another time, and an attachment far from its surface are told" {
    driven time skin.pc2 '{"rate": 480}'
    "$BIN/simulate" time.scene.json -o t.pc2 2> err
    grep -q 'its frames are from 0 s to .* stands still' err
    /usr/bin/python3 - << END
$cat_py
frames = pc2("skin.pc2"); n = len(frames[0])
with open("big.mdd", "wb") as out:
    out.write(struct.pack(">ii", len(frames), n) + struct.pack(">%df" % len(frames), *(i / 24 for i in range(len(frames)))))
    for f in frames: out.write(struct.pack(">%df" % (3 * n), *(1000 * x for p in f for x in p)))
END
    driven big big.mdd
    "$BIN/simulate" big.scene.json --frames 0:0 -o b.pc2 2> err || true
    grep -q 'both in one unit' err
    driven far skin.pc2 '{"units": 0.5}'
    "$BIN/simulate" far.scene.json --frames 0:0 -o f.pc2 2> err || true
    grep -q 'a vertex attached to the surface "skin" is .* mm away from it' err
}

@test "frames of another order of vertices, of another axis, of times that are numbers, and those that --frames leaves out, are told" {
    /usr/bin/python3 - << END
$cat_py
frames = pc2("skin.pc2"); n = len(frames[0]); header = open("skin.pc2", "rb").read()[:32]
def cache(name, of):
    with open(name, "wb") as out: out.write(header + b"".join(struct.pack("<%df" % (3 * n), *(x for p in of(f) for x in p)) for f in frames))
cache("order.pc2", lambda f: [f[(131 * i) % n] for i in range(n)])
cache("axis.pc2", lambda f: [(x, z, -y) for x, y, z in f])
cache("away.pc2", lambda f: [(x + 5, y, z) for x, y, z in f])
with open("numbers.mdd", "wb") as out:
    out.write(struct.pack(">ii", len(frames), n) + struct.pack(">%df" % len(frames), *range(len(frames))))
    for f in frames: out.write(struct.pack(">%df" % (3 * n), *(x for p in f for x in p)))
END
    # told FILE PATTERN: what is said, besides nothing else
    told() {
        driven doubt "$1"
        "$BIN/simulate" doubt.scene.json --frames 0:0 -o doubt.pc2 --log doubt.jsonl 2> err || true
        [ "$(grep -c 'warning: surface' err)" -eq 1 ]
        grep -q "warning: surface \"skin\": $2" err
    }
    told order.pc2 'its edges are .* times as long in its first frame as at rest; are the vertices of both in one order'
    told axis.pc2 'its first frame is .* m away from rest, and .* m if y and z are exchanged'
    told numbers.mdd 'its frames are 1 s apart; "rate" tells'
    driven away away.pc2
    "$BIN/simulate" away.scene.json --frames 0:0 -o doubt.pc2 --log doubt.jsonl 2> err || true # as when somebody walks
    [ "$(grep -c 'warning: surface' err)" -eq 0 ]
    driven whole skin.pc2
    "$BIN/simulate" whole.scene.json --frames 40:48 -o w.pc2 --log w.jsonl 2> err || true
    [ "$(grep -c 'stands still' err)" -eq 0 ]
    "$BIN/simulate" whole.scene.json --frames 40:49 -o w.pc2 --log w.jsonl 2> err || true
    grep -q 'its frames are from 0 s to 2 s, the scene.s from 1.66667 s to 2.04167 s; outside of its own it stands still' err
}

@test "a motion that begins before 0 s: frames of its envelope are at their times, in caches and files, as the envelope itself" {
    sed 's/\[\[0.25,0\]/[[-0.5,0]/' elbow.motion.json > early.motion.json
    "$BIN/envelope-bind" -q skin.envelope.json --bones early.motion.json --every 1 --frames early.pc2 -o early.envelope.json
    "$BIN/envelope-bind" -q skin.envelope.json --bones early.motion.json --every 1 --frames early.ply -o early.envelope.json
    [ -e early.-012.ply ] && [ -e early.0000.ply ] && [ -e early.0048.ply ] && [ ! -e early.0049.ply ]
    "$BIN/scene-build" -q rigs --motion early.motion.json --envelope skin.envelope.json --frames=-12:20 -o envelope.scene.json
    driven cache early.pc2
    driven files 'early.#.ply'
    for scene in envelope cache files; do "$BIN/simulate" -q $scene.scene.json -o $scene.pc2 --log $scene.jsonl; done
    /usr/bin/python3 - << END
$cat_py
a = pc2("envelope.pc2"); assert away(a[:1], a[-1:], held) > 0.01
assert same(a, pc2("cache.pc2")) and same(a, pc2("files.pc2"))
END
    sed 's/\[\[0.25,0\]/[[-0.51,0]/' elbow.motion.json > odd.motion.json
    "$BIN/envelope-bind" skin.envelope.json --bones odd.motion.json --every 1 --frames odd.ply -o odd.envelope.json 2> err
    grep -q 'warning: odd.motion.json begins at -0.51 s, which is frame -12.24: files are numbered from -13 on' err
}

# The arm's three muscles beside the skin over its bones, which they keep out of.
beside_skin() {
    mkdir whole && sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" "$PWD/whole"
    rm -rf rigs && mkdir rigs && cp whole/*.muscle.json rigs
    "$BIN/scene-build" -q rigs --motion elbow.motion.json --envelope skin.envelope.json --keep-out skin --frames 0:30 -o contact.scene.json
}

@test "muscles keep out of an envelope and of the same surface as a host's frames; off is absent; the plan tells; threads and stopping change nothing" {
    beside_skin
    mkdir a b c
    grep -q '"contact": true' contact.scene.json
    "$BIN/simulate" -q contact.scene.json --contact -o a --log a.jsonl --threads 1
    "$BIN/simulate" -q contact.scene.json --contact -o b --log b.jsonl --threads 4
    cmp a.jsonl b.jsonl; cmp a/triceps.pc2 b/triceps.pc2
    "$BIN/simulate" -q contact.scene.json --contact -o c --log c1.jsonl --frames 0:17 --state s.state
    "$BIN/simulate" -q contact.scene.json --contact -o c --log c2.jsonl --frames 18:30 --from s.state
    cat c1.jsonl c2.jsonl | cmp - a.jsonl
    # margins go on growing from where the first run began
    "$BIN/simulate" -q contact.scene.json --contact --resolve 1 -o b --log b.jsonl
    "$BIN/simulate" -q contact.scene.json --contact --resolve 1 -o c --log c1.jsonl --frames 0:17 --state s.state
    "$BIN/simulate" -q contact.scene.json --contact --resolve 1 -o c --log c2.jsonl --frames 18:30 --from s.state
    cat c1.jsonl c2.jsonl | cmp - b.jsonl
    run -1 cmp a.jsonl b.jsonl
    /usr/bin/python3 -c '
import json, sys
scene = json.load(open("contact.scene.json"))
json.dump(scene, open("skin.scene.json", "w"))
scene["surfaces"] = [{"name": "skin", "contact": True, "mesh": "skin.ply", "frames": "skin.pc2"}]
json.dump(scene, open("driven.scene.json", "w"))
scene["surfaces"][0]["contact"] = False
json.dump(scene, open("none.scene.json", "w"))'
    "$BIN/simulate" -q skin.scene.json --contact -o a --log a.jsonl
    "$BIN/simulate" -q driven.scene.json --contact -o b --log b.jsonl
    /usr/bin/python3 -c '
import json
'"${cat_py%%import json*}"'
runs = [[json.loads(l) for l in open(f)] for f in ("a.jsonl", "b.jsonl")]
for run in runs:
    assert max(d["penetration"] for d in run) < 1e-8
    assert sum(d["contacts"] for d in run) > 50
a, b = pc2("a/triceps.pc2"), pc2("b/triceps.pc2")
far = max(sum((x - y) ** 2 for x, y in zip(p, q)) ** 0.5 for f, g in zip(a, b) for p, q in zip(f, g))
assert far < 2e-3, far'
    "$BIN/simulate" --contact --plan skin.scene.json > plan.json
    /usr/bin/python3 -c '
import json
m = json.load(open("plan.json"))["plan"]["muscles"][0]
assert "skin" not in m["bonesInReach"] and len(m["bonesInReach"]) + m["bonesLeftOut"] == 4, m
assert m["surfacesInReach"][0]["surface"] == "skin" and 50 < m["surfacesInReach"][0]["triangles"] < m["surfacesInReach"][0]["ofTriangles"], m'
    # a surface that nobody keeps out of is as none
    "$BIN/scene-build" -q rigs --motion elbow.motion.json --frames 0:30 -o bones.scene.json
    "$BIN/simulate" -q none.scene.json --contact -o a --log a.jsonl
    "$BIN/simulate" -q bones.scene.json --contact -o b --log b.jsonl
    cmp a/triceps.pc2 b/triceps.pc2; cmp a.jsonl b.jsonl
    # what is asked for and not done is said
    "$BIN/simulate" contact.scene.json --frames 0:0 -o a > /dev/null 2> err
    grep -q 'surface "skin" is not felt: contact is off' err
    "$BIN/simulate" contact.scene.json --contact --scheme kohout --solver xpbd --frames 0:0 -o a > /dev/null 2> err
    grep -q 'surface "skin" is not felt: the collision is by voxels' err
    run -2 "$BIN/scene-build" rigs --motion elbow.motion.json --envelope skin.envelope.json --keep-out skni -o x.scene.json
    [[ $output == *skni* ]]
}

@test "a surface that has no two sides is refused, with what would help" {
    beside_skin
    /usr/bin/python3 - << 'END'
import json, re
lines = open("skin.envelope.json").read()
e = json.loads(lines)
t = e["mesh"]["triangles"] if "mesh" in e else e["triangles"]
flat = not isinstance(t[0], list)
if flat: t[3], t[4] = t[4], t[3]
else: t[1] = [t[1][1], t[1][0], t[1][2]]
json.dump(e, open("skin.envelope.json", "w"))
END
    refused 'surface "skin" cannot be touched: .*opposite sides.*mesh-clean' "$BIN/simulate" contact.scene.json --contact --frames 0:1
}
