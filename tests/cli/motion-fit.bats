# motion-fit: bones on the joints of a recording; alignment, scale, floor; tables that are wrong; a walk and a run on a whole body.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

schema=$BATS_TEST_DIRNAME/../../share/schema/motion.schema.json
body=$BATS_TEST_DIRNAME/../../share/examples/body/bp3d.tsv
captures=$DATA/mocap-cmu/motion
meshes=$DATA/body-bp3d-low

# member FILE EXPRESSION: a value of the document d
member() { /usr/bin/python3 -c "import json, math, sys; d = json.load(open(sys.argv[1])); print(json.dumps($2))" "$1"; }

# A ball of radius R about X,Y,Z: ball NAME R X Y Z
ball() {
    awk -v r="$2" -v x="$3" -v y="$4" -v z="$5" 'BEGIN { n = 12; pi = atan2(0, -1)
        for (i = 0; i < n; i++) for (k = 0; k < 2 * n; k++) { a = pi * (i + 0.5) / n; b = pi * k / n
            printf "v %.17g %.17g %.17g\n", x + r * sin(a) * cos(b), y + r * sin(a) * sin(b), z + r * cos(a) }
        for (i = 0; i + 1 < n; i++) for (k = 0; k < 2 * n; k++) { m = (k + 1) % (2 * n); p = i * 2 * n
            print "f", p + k + 1, p + k + 1 + 2 * n, p + m + 1; print "f", p + m + 1, p + k + 1 + 2 * n, p + m + 1 + 2 * n } }' > "$1"
}

# A leg as balls in metres times UNIT, y forward -: hips at 0.8 m, knees at 0.45 m, ankles at 0.1 m. bones FOLDER UNIT
bones() {
    mkdir -p "$1"
    for b in pelvis:0.1:0:0:0.95 left_thigh:0.03:0.1:0:0.8 left_shank:0.02:0.1:0:0.45 left_foot:0.05:0.1:-0.05:0.05 \
        right_thigh:0.03:-0.1:0:0.8 right_shank:0.02:-0.1:0:0.45 right_foot:0.05:-0.1:-0.05:0.05; do
        IFS=: read -r name r x y z <<< "$b"
        ball "$1/$name.obj" "$(num "$r*$2")" "$(num "$x*$2")" "$(num "$y*$2")" "$(num "$z*$2")"
    done
}
num() { awk "BEGIN { printf \"%.12g\", $1 }"; }

# Its table, in a unit: table UNIT METRES-IN-IT
table() {
    printf 'units\t%s\njoint\tpelvis\t-\thips\tsphere pelvis\tlevel hip_right>hip_left\n' "$1"
    printf 'joint\thip_{side}\tpelvis\t{s}hip\tsphere {side}_thigh\tknee_{side}\n'
    printf 'joint\tknee_{side}\thip_{side}\t{s}knee\tsphere {side}_shank\tankle_{side}\n'
    printf 'joint\tankle_{side}\tknee_{side}\t{s}ankle\tpoint {+}%s,0,%s\t-\n' "$(num "0.1*$2")" "$(num "0.1*$2")"
    printf 'bone\tpelvis\tpelvis\nbone\t{side}_thigh\thip_{side}\nbone\t{side}_shank\tknee_{side}\nbone\t{side}_foot\tankle_{side}\n'
    printf 'leg\thip_{side}\tknee_{side}\tankle_{side}\nfoot\tankle_{side}\n'
}

# A source that is taller, y up, legs spread by 30 degrees at rest; it goes forward (z) and swings its legs, the knees bend. bvh FRAMES [RISE]
bvh() {
    awk -v n="$1" -v rise="${2:-0}" 'BEGIN {
        print "HIERARCHY\nROOT hips\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
        for (s = 1; s >= -1; s -= 2) { c = s > 0 ? "l" : "r"
            printf "JOINT %ship\n{\nOFFSET %g -10 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nJOINT %sknee\n{\nOFFSET %g %.12g 0\n", c, 12 * s, c, 25 * s, -25 * sqrt(3)
            printf "CHANNELS 3 Zrotation Xrotation Yrotation\nJOINT %sankle\n{\nOFFSET %g %.12g 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 0 15\n}\n}\n}\n}\n", c, 25 * s, -25 * sqrt(3) }
        print "}\nMOTION\nFrames:", n, "\nFrame Time: 0.02"
        for (i = 0; i < n; i++) { a = 25 * sin(i / 8)
            print 0, 110 + rise * i, 2 * i, 0, 0, 0, -30, -a, 0, 0, 20 + a / 2, 0, 0, 0, 0, 30, a, 0, 0, 20 - a / 2, 0, 0, 0, 0 } }'
}

# world poses and places of the joints of a motion document, for python
cat > "$BATS_FILE_TMPDIR/motion.py" << 'END'
import json, math
def rotate(q, v):
    w, x, y, z = q
    t = (2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0]))
    return (v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0])
def multiply(a, b):
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])
def add(a, b): return tuple(x + y for x, y in zip(a, b))
def subtract(a, b): return tuple(x - y for x, y in zip(a, b))
class Motion:
    def __init__(self, path):
        self.document = json.load(open(path))
        self.joints, self.poses = {}, {}
        for joint in self.document["joints"]:
            self.joints[joint["name"]], poses = joint, []
            for f, key in enumerate(joint["keys"]):
                q, t = tuple(key["rotation"]), tuple(key.get("translation", (0, 0, 0)))
                if joint.get("parent"):
                    pq, pt = self.poses[joint["parent"]][f]
                    q, t = multiply(pq, q), add(rotate(pq, t), pt)
                poses.append((q, t))
            self.poses[joint["name"]] = poses
        self.frames = len(poses)
    def place(self, name, f, point=None):
        q, t = self.poses[name][f]
        return add(rotate(q, point or self.joints[name]["rest"]), t)
END

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    PYTHONPATH=$BATS_FILE_TMPDIR; export PYTHONPATH
    bones parts 1
    table m 1 > body.tsv
    bvh 60 > walk.bvh
}

@test "bones hang on the body's joints; the document keeps to the schema and names their files from where it is" {
    mkdir out
    "$BIN/motion-fit" walk.bvh --body body.tsv --bones parts -o out/fit.motion.json 2> err
    grep -qx "motion-fit: 7 bones on 7 joints, 60 frames; the way of the root is scaled by 0.7000, by the length of the legs" err
    [ "$(member out/fit.motion.json '[[j["name"], j.get("parent")] for j in d["joints"]]')" = \
        '[["pelvis", null], ["hip_left", "pelvis"], ["hip_right", "pelvis"], ["knee_left", "hip_left"], ["knee_right", "hip_right"], ["ankle_left", "knee_left"], ["ankle_right", "knee_right"]]' ]
    [ "$(member out/fit.motion.json 'd["bones"][0]')" = '{"name": "left_foot", "mesh": "../parts/left_foot.obj", "units": 1, "joint": "ankle_left"}' ]
    [ "$(member out/fit.motion.json '[len(d["bones"]), len(d["coordinates"]), [abs(round(x, 9)) for x in d["joints"][3]["rest"]]]')" = '[7, 24, [0.1, 0.0, 0.45]]' ]
    "$BIN/motion-import" out/fit.motion.json | grep -q '"left_foot"'
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || skip "python3-jsonschema is not installed"
    /usr/bin/python3 -c 'import json, jsonschema; jsonschema.Draft202012Validator(json.load(open("'"$schema"'"))).validate(json.load(open("out/fit.motion.json")))'
}

@test "segments point as the source's do, joints stay together, hips go the source's way, feet stand on the floor" {
    "$BIN/motion-import" walk.bvh -o source.motion.json
    "$BIN/motion-fit" -q walk.bvh --body body.tsv --bones parts -o fit.motion.json
    "$BIN/motion-fit" -q source.motion.json --body body.tsv --bones parts -o same.motion.json
    /usr/bin/python3 - << 'END'
from motion import *
source, fit, same = Motion("source.motion.json"), Motion("fit.motion.json"), Motion("same.motion.json")
def direction(m, a, b, f):
    d = subtract(m.place(b, f), m.place(a, f))
    return tuple(x / math.hypot(*d) for x in d)
lowest = math.inf
for f in range(fit.frames):
    middle = [tuple((a + b) / 2 for a, b in zip(m.place(l, f), m.place(r, f))) for m, l, r in ((source, "lhip", "rhip"), (fit, "hip_left", "hip_right"))]
    assert math.dist([0.7 * x for x in middle[0][:2]], middle[1][:2]) < 1e-12
    for s, side in (("l", "left"), ("r", "right")):
        for a, b in (("hip", "knee"), ("knee", "ankle")):
            assert math.dist(direction(source, s + a, s + b, f), direction(fit, a + "_" + side, b + "_" + side, f)) < 1e-12
            assert math.dist(fit.place(b + "_" + side, f), fit.place(a + "_" + side, f, fit.joints[b + "_" + side]["rest"])) < 1e-14
            assert math.dist(fit.place(b + "_" + side, f), same.place(b + "_" + side, f)) < 1e-12
END
}

@test "the same body in another unit moves the same, to rounding" {
    bones parts_cm 100
    table cm 100 > body_cm.tsv
    bones parts_odd 36.5
    table 0.0273972602739726 36.5 > body_odd.tsv
    sed 's/^bone.*/&\t0.01/; s/^units.*/units\tm/; s/point {+}10,0,10/point {+}0.1,0,0.1/' body_cm.tsv > body_rows.tsv
    "$BIN/motion-fit" -q walk.bvh --body body.tsv --bones parts -o m.json
    "$BIN/motion-fit" -q walk.bvh --body body_cm.tsv --bones parts_cm -o cm.json
    "$BIN/motion-fit" -q walk.bvh --body body_odd.tsv --bones parts_odd -o odd.json
    "$BIN/motion-fit" -q walk.bvh --body body_rows.tsv --bones parts_cm -o rows.json
    /usr/bin/python3 - << 'END'
from motion import *
m = Motion("m.json")
for other in map(Motion, ("cm.json", "odd.json", "rows.json")):
    assert max(math.dist(m.place(j, f), other.place(j, f)) for j in m.joints for f in range(m.frames)) < 1e-9
END
    [ "$(member cm.json 'd["bones"][0]["units"]')" = 0.01 ]
    # in the wrong unit nothing is silently scaled away: the table's metres and bones in centimetres do not meet
    sed 's/sphere {side}_thigh/sphere {side}_thigh@ball:{+}0.1,0,0.8,0.05/' body.tsv > wrong.tsv
    run -1 "$BIN/motion-fit" -q walk.bvh --body wrong.tsv --bones parts_cm
    [[ "$output" == *"are units and axes those of the body?"* ]]
}

@test "a floor that rises with the way is levelled and told; a slope is left; --no-ground leaves all" {
    # standing turn by turn: a source that slides along on stiff legs would never stand, so this one rests for 20 frames, goes, and rests
    awk '/Frame Time/ { on = 1; print; next } on { n++; z = n <= 20 ? 0 : n >= 40 ? 200 : (n - 20) * 10; $2 = 110 + z * rise; $3 = z
        for (i = 7; i <= NF; i++) $i = 0; print; next } { print }' rise=0.02 walk.bvh > ramp.bvh
    "$BIN/motion-fit" ramp.bvh --body body.tsv --bones parts -o level.json --report level.report.json 2> err
    grep -q "rises by 1.15 degrees along their way; the motion is turned to level it" err # atan 0.02
    [ "$(member level.report.json '[d["levelled"], round(d["slope"], 2), [len(f["stances"]) for f in d["feet"]]]')" = '[true, 1.15, [2, 2]]' ]
    /usr/bin/python3 - << 'END'
from motion import *
m = Motion("level.json")
ankles = [m.place("ankle_left", f)[2] for f in (0, m.frames - 1)]
assert abs(ankles[0] - ankles[1]) < 1e-4, ankles
END
    "$BIN/motion-fit" ramp.bvh --body body.tsv --bones parts --no-ground -o raw.json --report raw.report.json 2> err
    refute grep -q "degrees along" err
    [ "$(member raw.report.json '[d["levelled"], d["raised"]]')" = '[false, 0]' ]
    sed 's/^\([^ ]* \)\([0-9.]*\) /\1\2 /' ramp.bvh | awk '/Frame Time/ { on = 1; print; next } on { $2 = 110 + $3 * 0.2 } { print }' > steep.bvh
    "$BIN/motion-fit" steep.bvh --body body.tsv --bones parts -o steep.json 2> err
    grep -q "rises by 11.31 degrees along their way: a slope, which is left" err
}

@test "what a table cannot mean is one line that names it" {
    fails() { # WORDS WHAT-IS-SAID
        run -1 "$BIN/motion-fit" walk.bvh --body "$1" --bones parts -o none.json
        [ ! -e none.json ]
        [ "${#lines[@]}" -eq 1 ]
        [[ "$output" == "motion-fit: "$2 ]] || { echo "$output"; false; }
    }
    sed 's/{s}knee/{s}knie/' body.tsv > a.tsv
    fails a.tsv 'a.tsv:4: "knee_left": the motion has no joint "lknie"; motion-import --list tells its joints'
    sed 's/sphere pelvis/sphere pelvic/' body.tsv > b.tsv
    fails b.tsv 'b.tsv:2: "pelvis": no bone has a name like "pelvic"'
    sed 's/sphere {side}_shank/sphere {side}_shank@far:0,0,1,0.0001@far:1,0,0,0.0002/' body.tsv > c.tsv
    fails c.tsv 'c.tsv:4: "knee_left": 3 vertices are too few for a sphere, which needs 6; take a larger region'
    sed 's/^bone\tpelvis.*/bone\tx\tpelvis/; s/^bone\t{side}/bone\tno{side}/' body.tsv > d.tsv
    fails d.tsv 'd.tsv: no row binds any of the 7 bones; are these the bones of another body\?'
    sed 's/^joint\tpelvis\t-/joint\tpelvis\tankle_left/' body.tsv > e.tsv
    fails e.tsv 'e.tsv:2: joint "pelvis" hangs on itself: its parents go round in a circle'
    head -c 200 /dev/zero > f.tsv
    fails f.tsv 'f.tsv:1: the line has a byte of zero in it; is this a table\?'
    printf 'joint\tpelvis\t-\thips\tmean pelvis\t{\n' > g.tsv
    fails g.tsv 'g.tsv:1: what is in braces is none of*'
    sed 's/level hip_right>hip_left/ankle_top/' body.tsv > h.tsv
    fails h.tsv 'h.tsv:2: no row names the joint or place "ankle_top"'
    : > empty.tsv
    fails empty.tsv 'empty.tsv: there is no row "joint"'
    fails nowhere.tsv '*nowhere.tsv*'
    run -2 "$BIN/motion-fit" walk.bvh --bones parts
    run -2 "$BIN/motion-fit" walk.bvh --body body.tsv
    run -1 "$BIN/motion-fit" walk.bvh --body body.tsv --bones out_of_nowhere
    mkdir bare
    run -1 "$BIN/motion-fit" walk.bvh --body body.tsv --bones bare
    [[ "$output" == *"no mesh"* ]]
}

@test "what is left over is warned of: bones, rows, joints of either side" {
    ball parts/hat.obj 0.1 0 0 1.5
    sed '/^bone\t{side}_foot/d; s/^bone\tpelvis/bone\ttail\tpelvis\n&/' body.tsv > less.tsv
    sed -i '/^joint\tankle/d; /^leg/d; /^foot/d; s/\tankle_{side}$/\t-/' less.tsv
    awk '/Frame Time/ { on = 1; print; next } on { $15 = NR } { print }' walk.bvh > turned.bvh # lankle.Zrotation
    "$BIN/motion-fit" turned.bvh --body less.tsv --bones parts -o none.json 2> err
    grep -qx "motion-fit: warning: less.tsv: no row binds 3 of 8 bones, which are left out: hat, left_foot, right_foot" err
    grep -qx "motion-fit: warning: less.tsv: rows that bind no bone: tail" err
    grep -qx "motion-fit: warning: turned.bvh: joints that turn and drive nothing: lankle" err
    grep -q "as the table names no leg" err
    sed 's/^bone\t{side}_foot.*//' body.tsv > barefoot.tsv
    "$BIN/motion-fit" walk.bvh --body barefoot.tsv --bones parts -o none.json 2> err
    grep -qx "motion-fit: warning: barefoot.tsv: joints that carry no bone: ankle_left, ankle_right" err
    sed 's/level hip_right>hip_left/hip_left/' body.tsv > blind.tsv
    "$BIN/motion-fit" walk.bvh --body blind.tsv --bones parts -o none.json 2> err
    grep -q 'nothing tells which way "pelvis" faces' err
}

@test "a pipe, a folder in the table, and any number of threads give the same; the history tells what was used" {
    "$BIN/motion-fit" -q walk.bvh --body body.tsv --bones parts -o a.json --report a.report.json --gap-every 3 --threads 1
    "$BIN/motion-fit" -q --body body.tsv --bones parts --report b.report.json --gap-every 3 --threads 4 < walk.bvh | sed '/^  "name"/d' > b.json
    sed '/^  "name"/d' a.json | cmp - b.json
    [ "$(member a.report.json 'd["joints"]')" = "$(member b.report.json 'd["joints"]')" ]
    [ "$(member a.json '[h["tool"] for h in d["history"]] + d["history"][0]["args"][::2]')" = '["motion-fit", "--body", "--bones"]' ]
    sed '1a folder\tparts' body.tsv > with.tsv
    "$BIN/motion-fit" -q walk.bvh --body with.tsv --no-history -o c.json
    "$BIN/motion-fit" -q walk.bvh --body body.tsv --bones parts --no-history | cmp - c.json
    run -1 sh -c "'$BIN/motion-fit' -q walk.bvh --body body.tsv --bones parts > /dev/full"
}

@test "the report's distances are those of the balls" {
    # shank and thigh: centres 0.35 m apart, radii 0.02 and 0.03, in every frame, as balls about the knee's and hip's own centres
    "$BIN/motion-fit" -q walk.bvh --body body.tsv --bones parts -o a.json --report r.json --gap-every 1 --gap-tolerance 0.01
    [ "$(member r.json '[[abs(g[k] - 0.3) < 2e-3 for k in ("rest", "least", "greatest")] for g in [j["gap"] for j in d["joints"] if j["name"] == "knee_left"]]')" = '[[true, true, true]]' ]
    # a ball in the pelvis: the point of its surface that is nearest to the pelvis' centre, 10 mm from it, lies 90 mm deep
    ball parts/left_thigh.obj 0.03 0.02 0 0.95
    "$BIN/motion-fit" -q walk.bvh --body body.tsv --bones parts -o a.json --report r.json --gap-every 30
    [ "$(member r.json '[abs(j["gap"]["rest"] + 0.09) < 3e-3 for j in d["joints"] if j["name"] == "hip_left"]')" = '[true]' ]
}

# fit NAME: walk or run on the 202 bones, every fifth frame measured
fit() {
    [ -d "$captures" ] && [ -d "$meshes" ] || skip "no real bodies and motions in $DATA"
    awk -F '\t' -v folder="$meshes/meshes/" '$2 == "bone" { print folder $1 }' "$meshes/manifest.tsv" > bones.txt
    [ "$(wc -l < bones.txt)" -eq 202 ]
    "$BIN/motion-fit" "$captures/cmu_02_$1.bvh" --body "$body" --bones bones.txt -o fit.motion.json --report fit.json 2> err
    refute grep warning err
}

# the bones' surfaces at six joints; feet that stand
judge() {
    /usr/bin/python3 - << 'END'
import json
d = json.load(open("fit.json"))
wanted = [j + "_" + s for j in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist") for s in ("left", "right")]
gaps = {j["name"]: j["gap"] for j in d["joints"] if "gap" in j}
for name in wanted:
    assert gaps[name]["change"] < 5e-3, (name, gaps[name])
    assert abs(gaps[name]["rest"]) < 3.5e-3, (name, gaps[name])
long = [s for f in d["feet"] for s in f["stances"] if s["last"] - s["first"] > 0.1 * d["rate"]]
assert len(long) >= 4 and max(s["travel"] for s in long) < 0.04, long
assert all(-0.02 < f["lowest"] <= 0 for f in d["feet"]), [f["lowest"] for f in d["feet"]]
assert d["bones"] == 202 and d["levelled"] and 0.5 < d["slope"] < 1.5
radii = {j["name"]: j["spheres"] for j in d["joints"] if "spheres" in j}
for side in ("left", "right"):
    assert abs(radii["hip_" + side][0]["radius"] - 0.023) < 0.001 and radii["hip_" + side][0]["rms"] < 0.0005
END
}

# the body goes where it looks; knees bend backwards, elbows forwards; feet point forward, arms hang beside, the head is on top
posture() {
    /usr/bin/python3 - << 'END'
from motion import *
m = Motion("fit.motion.json")
way = subtract(m.place("pelvis", m.frames - 1), m.place("pelvis", 0))
ahead = (way[0] / math.hypot(*way[:2]), way[1] / math.hypot(*way[:2]), 0)
dot = lambda a, b: sum(x * y for x, y in zip(a, b))
left = (-ahead[1], ahead[0], 0)
for f in range(m.frames):
    front = rotate(m.poses["pelvis"][f][0], (0, -1, 0))
    assert dot(front, ahead) > 0.9
    assert m.place("head", f)[2] > m.place("neck", f)[2] > m.place("lumbar", f)[2]
    for side, s in (("left", 1), ("right", -1)):
        hip, knee, ankle, toes = (m.place(j + "_" + side, f) for j in ("hip", "knee", "ankle", "toes"))
        shoulder, elbow, wrist = (m.place(j + "_" + side, f) for j in ("shoulder", "elbow", "wrist"))
        thigh, shank, foot = subtract(knee, hip), subtract(ankle, knee), subtract(toes, ankle)
        # flexion: the shank turns backwards from the thigh's line, about the axis to the left
        bend = math.degrees(math.atan2(dot(left, (thigh[1] * shank[2] - thigh[2] * shank[1], thigh[2] * shank[0] - thigh[0] * shank[2], thigh[0] * shank[1] - thigh[1] * shank[0])), dot(thigh, shank)))
        assert -5 < bend < 130, (f, side, bend)
        heading = dot(foot, ahead) / math.hypot(*foot[:2])
        assert heading > 0.7 or math.hypot(*foot[:2]) < -foot[2], (f, side, heading) # or the foot hangs down
        upper, fore = subtract(elbow, shoulder), subtract(wrist, elbow)
        assert elbow[2] < shoulder[2] - 0.1, (f, side, upper)
        assert dot(fore, ahead) > dot(upper, ahead) - 0.05, (f, side, upper, fore) # an elbow bends forwards
        assert abs(dot(upper, left)) < 0.12, (f, side, upper)
END
}

@test "a walk moves the 202 bones of a body: joints hold, feet stand" {
    fit 01_walk
    judge
    posture
}

@test "a run moves the 202 bones of a body: joints hold, feet stand" {
    fit 03_run
    judge
    posture
}

@test "ASF and AMC and the BVH made from it fit alike" {
    [ -d "$captures" ] && [ -d "$meshes" ] || skip "no real bodies and motions in $DATA"
    awk -F '\t' -v folder="$meshes/meshes/" '$2 == "bone" { print folder $1 }' "$meshes/manifest.tsv" > bones.txt
    "$BIN/motion-fit" -q "$captures/cmu_02_03_run.bvh" --body "$body" --bones bones.txt -o bvh.json
    "$BIN/motion-fit" -q "$captures/02_03.amc" --skeleton "$captures/02.asf" --body "$body" --bones bones.txt -o amc.json
    /usr/bin/python3 - << 'END'
from motion import *
a, b = Motion("bvh.json"), Motion("amc.json")
assert a.frames == b.frames and max(math.dist(a.place(j, f), b.place(j, f)) for j in a.joints for f in range(0, a.frames, 7)) < 1e-6
END
}
