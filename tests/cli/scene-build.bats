# scene-build: the sample arm as it is written by hand, a model of OpenSim's at once, what is left out and said, what is refused.

bats_require_minimum_version 1.5.0

schemas="$BATS_TEST_DIRNAME/../../share/schema"

setup_file() {
    export SAMPLE="$BATS_FILE_TMPDIR/sample"
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" "$SAMPLE"
    cat > "$SAMPLE/elbow.motion.json" << 'END'
{ "format": "sinew-motion", "version": 1, "metersPerUnit": 1, "rate": 24, "joints": [
  { "name": "elbow", "type": "hinge", "axis": [0,-1,0], "point": [0,0,0], "keys": [[0.25,0], [2,120]], "interpolation": "smooth" } ] }
END
}

setup() {
    cp -r "$SAMPLE" "$BATS_TEST_TMPDIR/arm"
    cd "$BATS_TEST_TMPDIR/arm" || exit 1
    build="$BIN/scene-build"
    bones="-b scapula.ply -b humerus.ply -b ulna.ply -b radius.ply --bind ulna=elbow --bind radius=elbow"
    arm="--motion elbow.motion.json $bones"
}

# Run with status $1 and exactly one line on stderr that matches $2, and no scene written.
refused() {
    local status=$1 pattern=$2 code=0
    shift 2
    "$@" -o refused.scene.json > out 2> err || code=$?
    [ "$code" -eq "$status" ] && [ ! -s out ] && [ ! -e refused.scene.json ] && [ "$(wc -l < err)" -eq 1 ] || { echo "$code"; cat err; return 1; }
    grep -Eq "^scene-build: $pattern" err || { cat err; return 1; }
}

# ask FILE EXPRESSION: of the document s
ask() { python3 -c 'import json, sys; s = json.load(open(sys.argv[1])); assert eval(sys.argv[2]), s' "$@"; }

valid() {
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || return 0
    /usr/bin/python3 -c 'import json, sys, jsonschema
schema = json.load(open(sys.argv[1] + "/scene.schema.json"))
for name in sys.argv[2:]: jsonschema.Draft202012Validator(schema).validate(json.load(open(name)))' "$schemas" "$@"
}

@test "the sample arm: built, it moves as the one written by hand, byte for byte" {
    "$build" . $arm --frames 0:60 --set '*.law=isochoric' --set biceps.contraction=0.26 --set brachialis.contraction=0.4 \
        --set triceps.contraction=0.36 --set triceps.restActivation=0.5 \
        --set 'b*.activation={"keys": [[0, 0], [2, 0.9]], "interpolation": "smooth"}' \
        --set 'triceps.activation={"keys": [[0, 0.5], [2, 0]], "interpolation": "smooth"}' -o built.scene.json
    valid built.scene.json
    mkdir hand machine
    "$BIN/simulate" -q arm.scene.json -o hand --log hand.jsonl
    "$BIN/simulate" -q built.scene.json -o machine --log machine.jsonl
    cmp hand.jsonl machine.jsonl
    for muscle in biceps brachialis triceps; do cmp hand/$muscle.pc2 machine/$muscle.pc2; done
}

@test "contact and external constraints are in the scene where they are asked for" {
    # shellcheck disable=SC2086
    "$build" *.muscle.json $arm --contact --externals -o both.scene.json
    # shellcheck disable=SC2086
    "$build" *.muscle.json $arm -o none.scene.json
    ask both.scene.json 's["contact"] is True and s["externals"] is True'
    ask none.scene.json '"contact" not in s and "externals" not in s'
    valid both.scene.json
    "$BIN/simulate" -q both.scene.json --plan > plan.json
    ask plan.json 's["scene"]["contact"] and s["scene"]["externals"]["stiffness"] == 10'
}

@test "paths are from the scene, wherever it is; the same bytes each time, and from a folder as from its files" {
    mkdir -p deep/er
    "$build" . $arm -o deep/er/a.scene.json
    ask deep/er/a.scene.json 's["muscles"][0]["rig"] == "../../biceps.muscle.json" and s["motion"] == {"uri": "../../elbow.motion.json"} and s["bones"][0]["mesh"] == "../../scapula.ply" and s["name"] == "a"'
    "$BIN/simulate" --plan deep/er/a.scene.json > plan.json
    "$build" . $arm > one 2> /dev/null
    "$build" biceps.muscle.json brachialis.muscle.json triceps.muscle.json $arm > two 2> /dev/null
    cmp one two
    ask one 'len(s["history"]) == 1 and s["history"][0]["tool"] == "scene-build"'
    "$build" . $arm --no-history 2> /dev/null | python3 -c 'import json, sys; assert "history" not in json.load(sys.stdin)'
}

@test "rate, frames, preroll and run-in: the motion's, at rest and away from rest, and as asked for" {
    "$build" . $arm -o a.scene.json 2> err
    ask a.scene.json 's["rate"] == 24 and s["frames"] == [0, 48] and s["preroll"] == s["runIn"] == 0 and s["solver"] == {"method": "qn"}'
    grep -q '2 of 4 bones are on no joint and stand still: scapula, humerus$' err
    [ "$(wc -l < err)" -eq 1 ]
    "$build" . $arm --rate 60 --solver xpbd -o a.scene.json
    ask a.scene.json 's["rate"] == 60 and s["frames"] == [0, 120] and s["solver"] == {"method": "xpbd"}'
    "$build" . $arm --frames 48:50 -o a.scene.json 2> err
    ask a.scene.json 's["frames"] == [48, 50] and s["preroll"] == 2 and s["runIn"] == 1'
    grep -q 'frames 0 to 48 at 24 a second; outside' err
    grep -q 'at frame 48 bones are up to 120 degrees and 0 m from rest: they go there in the first 1 s of a preroll of 2 s' err
    "$BIN/simulate" -q a.scene.json -o . --fail-on 'torn>0' --log a.jsonl
    "$build" . $arm --frames 48:50 --run-in 0.5 -o a.scene.json 2> err
    ask a.scene.json 's["preroll"] == 1 and s["runIn"] == 0.5'
    "$build" . $arm --frames 48:50 --preroll 0 -o a.scene.json 2> err
    ask a.scene.json 's["preroll"] == s["runIn"] == 0'
    grep -q 'warning: at frame 48 bones are .* and begin there' err
    "$build" . $arm --preroll 0.5 -o a.scene.json 2> err
    ask a.scene.json 's["preroll"] == 0.5 and s["runIn"] == 0'
    refused 2 '--run-in: 3 s are more than the preroll' "$build" . $arm --run-in 3 --preroll 1
    refused 2 "--frames: '5:2' is not A:B" "$build" . $arm --frames 5:2
}

@test "every member can be set, and the reader of scenes knows it; later settings go before earlier ones" {
    "$build" . $arm --solver xpbd --set '*.enabled=true' --set '*.activation=0.25' --set '*.contraction=0.4' --set '*.restActivation=0.1' \
        --set '*.tone=0.05' --set '*.restLength=0.9' --set '*.law=paper' --set '*.stretch=springs' --set '*.stiffness.relaxed=1e5' \
        --set '*.stiffness.active=1e6' --set '*.stiffness.internal=2' --set '*.stiffness.dihedral=1e-4' --set '*.stiffness.volume=3000' \
        --set '*.stiffness.areaScaled=false' --set '*.stiffness.curve=[[0,1e5],[1,1e6]]' --set '*.anisotropy=xpbd' --set '*.leastArea=0.3' \
        --set '*.volumeRatio=[[0,1],[1,0.9]]' --set '*.mass=unit' --set '*.density=1000' --set '*.damping=3' --set '*.iterations=4' \
        --set 'b*.tone=0.2' --set 'biceps.tone=0.3' -o a.scene.json
    valid a.scene.json
    "$BIN/simulate" --plan a.scene.json > plan.json 2> err
    [ ! -s err ]
    python3 << 'END'
import json
biceps, brachialis, triceps = json.load(open("plan.json"))["scene"]["muscles"]
assert [m["tone"] for m in (biceps, brachialis, triceps)] == [0.3, 0.2, 0.05]
want = {"activation": 0.25, "contraction": 0.4, "restActivation": 0.1, "restLength": 0.9, "law": "paper", "anisotropy": "xpbd", "leastArea": 0.3,
        "volumeRatio": [[0, 1], [1, 0.9]], "mass": "unit", "density": 1000, "damping": 3, "iterations": 4, "stretch": "springs",
        "stiffness": {"relaxed": 1e5, "active": 1e6, "internal": 2, "dihedral": 1e-4, "volume": 3000, "areaScaled": False, "curve": [[0, 1e5], [1, 1e6]]}}
assert {k: triceps[k] for k in want} == want, triceps
END
    "$build" . $arm --set 'triceps.enabled=false' -o b.scene.json 2> err
    ask b.scene.json '[m.get("enabled") for m in s["muscles"]] == [None, None, False]'
}

@test "activations: channels by name; what is left over on either side is said; settings go before them" {
    echo '{"format": "sinew-activation", "version": 1, "channels": {"biceps": {"times": [0, 1], "values": [0, 1]}, "triceps": {"times": [0], "values": [0.5]}, "deltoid": {"times": [0], "values": [0]}}}' > x.activation.json
    "$build" . $arm --activation x.activation.json --set triceps.activation=0.1 -o a.scene.json --report report.json 2> err
    ask a.scene.json '[m.get("activation") for m in s["muscles"]] == [{"uri": "x.activation.json", "channel": "biceps"}, None, 0.1]'
    grep -q 'warning: x.activation.json: 1 of 3 channels are no muscle.s: deltoid$' err
    grep -q 'warning: 1 of 3 muscles have no channel in x.activation.json .*: brachialis$' err
    ask report.json 's["musclesWithoutChannel"] == 1 and s["channelsWithoutMuscle"] == 1 and s["muscles"] == 3 and s["bones"] == 4'
    "$BIN/simulate" --plan a.scene.json > plan.json
    echo '{"channels": {"deltoid": {"times": [0], "values": [0]}}}' > none.activation.json
    refused 1 'none.activation.json: has no channel of any muscle.s name; its channels: deltoid' "$build" . $arm --activation none.activation.json
    echo '{"channels": {"biceps": {"times": [1, 0], "values": [0, 0]}}}' > back.activation.json
    refused 1 'back.activation.json:1:.*is not later' "$build" biceps.muscle.json $arm --activation back.activation.json
}

@test "muscles on bones that are not there: all of them in one error; --skip-unattached leaves them out" {
    refused 1 '3 of 3 muscles are attached to bones that are not there: biceps to scapula, brachialis to humerus, triceps to scapula;' "$build" . --motion elbow.motion.json
    some="--motion elbow.motion.json -b scapula.ply -b humerus.ply -b ulna.ply --bind ulna=elbow"
    refused 1 '1 of 3 muscles are attached to bones that are not there: biceps to radius;' "$build" . $some
    "$build" . $some --skip-unattached -o a.scene.json 2> err
    ask a.scene.json '[m["name"] for m in s["muscles"]] == ["brachialis", "triceps"]'
    grep -q 'warning: 1 of 3 muscles are left out, .*: biceps to radius$' err
    "$BIN/simulate" --plan a.scene.json > plan.json
    refused 1 '1 of 1 muscles' "$build" biceps.muscle.json $some --skip-unattached
}

@test "bones of the motion document: taken, replaced by namesakes on their joints, bound anew" {
    mkdir other && cp ulna.ply other
    python3 -c '
import json
m = json.load(open("elbow.motion.json"))
m["bones"] = [{"name": b, "mesh": b + ".ply", "units": 1, **({"joint": "elbow"} if b in ("ulna", "radius") else {})} for b in ("scapula", "humerus", "ulna", "radius")]
json.dump(m, open("whole.motion.json", "w"))'
    "$build" . --motion whole.motion.json --frames 0:60 -o a.scene.json
    ask a.scene.json 's["bones"] == []'
    "$build" . --motion whole.motion.json --bones other -o b.scene.json
    ask b.scene.json 's["bones"] == [{"name": "ulna", "mesh": "other/ulna.ply", "joint": "elbow"}]'
    "$build" . --motion whole.motion.json --bind 'h*=elbow' -o c.scene.json
    ask c.scene.json 's["bones"] == [{"name": "humerus", "mesh": "humerus.ply", "units": 1, "joint": "elbow"}]'
    for scene in a b c; do "$BIN/simulate" --plan $scene.scene.json > plan.$scene; done
    python3 -c '
import json
joint = lambda scene: {b["name"]: b.get("joint") for b in json.load(open("plan." + scene))["scene"]["bones"]}
assert joint("a") == joint("b") == {"scapula": None, "humerus": None, "ulna": "elbow", "radius": "elbow"}, joint("b")
assert joint("c")["humerus"] == "elbow"'
    # a bone that is called as a joint hangs on it
    "$build" . --motion elbow.motion.json -b scapula.ply -b humerus.ply -b ulna.ply -b radius.ply -b elbow=ulna.ply -o d.scene.json
    ask d.scene.json 's["bones"][4]["joint"] == "elbow" and all("joint" not in b for b in s["bones"][:4])'
}

@test "another unit, or another place than the rigs': attachments far from their bones are said" {
    "$build" . $arm --units mm -o a.scene.json 2> err
    grep -q 'warning: muscle "biceps": what is attached to radius lies 0.0[0-9]* m from it: another unit, or another rest pose?' err
    "$build" . $arm --units m -o a.scene.json 2> err
    [ "$(grep -c 'lies' err)" -eq 0 ]
    "$BIN/mesh-clean" humerus.ply -o h.obj 2> /dev/null
    awk '$1 == "v" { $2 += 0.1 } { print }' h.obj > moved.obj
    "$build" . --motion elbow.motion.json -b scapula.ply -b humerus=moved.obj -b ulna.ply -b radius.ply --bind ulna=elbow -o a.scene.json 2> err
    [ "$(grep -c 'attached to humerus lies' err)" -eq 2 ]
    [ "$(grep -c 'lies' err)" -eq 2 ]
    # pinned off its bone it is meant to be, unless it is farther off than the muscle is long
    python3 -c 'import json
for name in ("brachialis", "triceps"):
    rig = json.load(open(name + ".muscle.json"))
    for a in rig["attachments"]: a["reasons"] = [1] * len(a["vertices"])
    json.dump(rig, open(name + ".muscle.json", "w"))'
    "$build" . --motion elbow.motion.json -b scapula.ply -b humerus=moved.obj -b ulna.ply -b radius.ply --bind ulna=elbow -o a.scene.json 2> err
    [ "$(grep -c 'lies' err)" -eq 0 ]
    awk '$1 == "v" { $2 += 1 } { print }' h.obj > moved.obj
    "$build" . --motion elbow.motion.json -b scapula.ply -b humerus=moved.obj -b ulna.ply -b radius.ply --bind ulna=elbow -o a.scene.json 2> err
    [ "$(grep -c 'pinned to humerus lies .* m from it: another unit' err)" -eq 2 ]
    [ "$(grep -c 'lies' err)" -eq 2 ]
}

@test "a motion that moves no bone, names that are nobody's, values that cannot be: refused, and nothing is written" {
    refused 1 'elbow.motion.json: moves none of the 4 bones, as no joint has the name of one \(the first joint is "elbow"\)' "$build" . --motion elbow.motion.json -b scapula.ply -b humerus.ply -b ulna.ply -b radius.ply
    refused 1 "'ulna=knee': the motion has no joint \"knee\"" "$build" . $arm --bind ulna=knee
    refused 1 "'x\*=elbow': there is no bone" "$build" . $arm --bind 'x*=elbow'
    refused 2 "--bind: 'ulna' is not PATTERN=JOINT" "$build" . $arm --bind ulna
    refused 1 "'x\*.tone=0.1': no muscle" "$build" . $arm --set 'x*.tone=0.1'
    refused 2 "--set: '\*.tune=1': a muscle has no such member" "$build" . $arm --set '*.tune=1'
    refused 2 "--set: 'tone=1' is not PATTERN.MEMBER=VALUE" "$build" . $arm --set tone=1
    refused 2 "--set: '\*.tone=7': tone: expected a number in \[0,1\], found 7" "$build" . $arm --set '*.tone=7'
    refused 2 "--set: '\*.law=pigeon': law: expected \"projected\"" "$build" . $arm --set '*.law=pigeon'
    refused 2 "--set: '\*.tone=1,\"x\":2': .* is no value" "$build" . $arm --set '*.tone=1,"x":2'
    refused 2 "--set: '\*.tone=null': .* is no value" "$build" . $arm --set '*.tone=null'
    refused 2 "--set: '\*.anisotropy=pbd': .*xpbd" "$build" . $arm --set '*.anisotropy=pbd'
    refused 1 ".*nope.json: cannot be opened" "$build" . $arm --set '*.activation={"uri":"nope.json"}'
    refused 1 'refused.scene.json: muscle "biceps": its mesh has no attribute "paint"' "$build" . $arm --set '*.maps.activation=paint'
    refused 1 'biceps.muscle.json: holds the muscle "biceps", and so does biceps.muscle.json' "$build" . biceps.muscle.json $arm
    refused 1 'radius.ply: is called "ulna", and so is ulna.ply' "$build" . $arm -b ulna=radius.ply
    refused 1 'nowhere.ply: cannot be opened|.*nowhere.ply' "$build" . $arm -b x=nowhere.ply --bind x=elbow
    refused 1 'none.json: cannot be opened' "$build" . $bones --motion none.json
    refused 1 'arm.scene.json:.*expected "sinew-motion"' "$build" . $bones --motion arm.scene.json
    printf 'HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n0 0 0\n' > a.bvh
    refused 1 'a.bvh: is BVH; make a motion document of it' "$build" . $bones --motion a.bvh
    refused 1 'frames: no rig' "$build" frames
    refused 2 'name the rigs' "$build"
    refused 2 "a scene names its rigs by their files" "$build" - $arm
    refused 2 '--bones-dir and --bone-path are for --model' "$build" . $arm --bones-dir x
}

@test "a scene does not take the place of a file that it names" {
    cp ulna.ply bone
    for name in biceps.muscle.json ./elbow.motion.json bone; do
        cp $name kept
        run -2 "$build" . $arm -b more=bone -o $name
        [[ "$output" == *"--output $name: the scene names this file"* || "$output" == *"--output $name are one file"* ]] || { echo "$output"; false; }
        cmp $name kept
    done
    run -2 "$build" . $arm -o ulna.ply # whose ending says that it is no scene
    cmp ulna.ply kept
    ln -s biceps.muscle.json linked.json
    run -2 "$build" . $arm -o linked.json
    "$build" . $arm -o a.scene.json
    "$build" . $arm -o a.scene.json # again is no mistake
    "$build" . $arm -o /dev/null
}

@test "--list tells what would be in it and writes nothing" {
    "$build" . $arm --set 'b*.tone=0.1' --list -o a.scene.json > list 2> err
    [ ! -e a.scene.json ]
    grep -qP '^frames\t0\t48$' list
    grep -qP '^joints\t1$' list
    grep -qP '^bone\t3\tulna\telbow\t2\tulna.ply$' list
    grep -qP '^bone\t2\thumerus\t-\t2\thumerus.ply$' list
    grep -qP '^muscle\t1\tbiceps\t[0-9]+\tscapula,radius\t-\tbiceps.muscle.json$' list
    [ "$(grep -cP '^set\t[12]\tb[a-z]*\ttone\t0.1$' list)" -eq 2 ]
    [ "$(grep -c '^muscle' list)" -eq 3 ]
}

@test "no motion: bones stand still, and the muscles can contract" {
    "$build" . -b scapula.ply -b humerus.ply -b ulna.ply -b radius.ply --set 'biceps.activation=0.5' --frames 0:2 -o a.scene.json 2> err
    [ ! -s err ]
    valid a.scene.json
    "$BIN/simulate" -q a.scene.json -o . --log a.jsonl
    grep -q '"activation":0.5' a.jsonl
}

@test "a model of OpenSim's: bones, joints, motion and a muscle on them at once" {
    gait="$DATA/gait-opensim"
    [ -d "$gait" ] || skip "no gait-opensim in DATA"
    model="$gait/motion/subject01_simbody_adjusted.osim"
    walk="$gait/motion/subject01_walk1_ik.mot"
    mkdir made
    "$build" --model "$model" --motion "$walk" --bone-path "$gait/meshes" -o made/bare.scene.json 2> err
    [ "$(find made/bare.bones -name '*.ply' | wc -l)" -eq 20 ]
    grep -q '1 of 20 bones are on no joint and stand still: treadmill' err
    grep -q 'at frame 0 bones are up to 28 degrees and 0.825 m from rest' err
    # a tube from the femur to the tibia, in the model's rest pose
    cat > tube.py << 'END'
import json, math
from struct import unpack
def points(name):
    data = open("made/bare.bones/" + name + ".ply", "rb").read()
    head, body = data.split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    count = int([l for l in lines if l.startswith("element vertex")][0].split()[-1])
    kind = [l.split()[1] for l in lines if l.startswith("property") and l.endswith(" x")][0]
    size = {"float": 4, "double": 8}[kind]
    return [unpack("<3" + "fd"[size == 8], body[k * 3 * size:(k + 1) * 3 * size]) for k in range(count)]
def middle(p, low, high):
    z = sorted(q[2] for q in p)
    a, b = z[0] + low * (z[-1] - z[0]), z[0] + high * (z[-1] - z[0])
    q = [r for r in p if a <= r[2] <= b]
    return [sum(c) / len(q) for c in zip(*q)]
top, bottom = middle(points("femur_r"), 0.4, 0.6), middle(points("tibia_r"), 0.6, 0.8)
rings, around, radius = 24, 12, 0.025
vertices, faces = [], []
for i in range(rings + 1):
    t = i / rings
    c = [a + t * (b - a) for a, b in zip(top, bottom)]
    r = radius * (0.5 + math.sin(math.pi * t))
    for k in range(around):
        a = 2 * math.pi * k / around
        vertices.append((c[0] + r * math.cos(a), c[1] + r * math.sin(a), c[2]))
for i in range(rings):
    for k in range(around):
        a, b = i * around + k, i * around + (k + 1) % around
        faces += [(a, a + around, b), (b, a + around, b + around)]
for ring, flip in ((0, False), (rings, True)):
    vertices.append(tuple(sum(v[j] for v in vertices[ring * around:(ring + 1) * around]) / around for j in range(3)))
    for k in range(around):
        a, b = ring * around + k, ring * around + (k + 1) % around
        faces.append((len(vertices) - 1, a, b) if not flip else (len(vertices) - 1, b, a))
print("OFF\n%d %d 0" % (len(vertices), len(faces)))
for v in vertices: print(*v)
for f in faces: print(3, *f)
END
    python3 tube.py > tube.off
    "$BIN/mesh-clean" tube.off 2> /dev/null | "$BIN/attach-detect" -b made/bare.bones/femur_r.ply -b made/bare.bones/tibia_r.ply --distance 2cm 2> /dev/null \
        | "$BIN/root-select" | "$BIN/build-structure" | "$BIN/fiber-flow" > tube.muscle.json
    "$build" tube.muscle.json --model "$model" --motion "$walk" --bone-path "$gait/meshes" --frames 0:10 --set 'tube.tone=0.1' \
        -o made/gait.scene.json 2> err
    [ "$(grep -c 'lies' err)" -eq 0 ]
    valid made/gait.scene.json
    ask made/gait.scene.json 's["rate"] == 60 and s["frames"] == [0, 10] and s["runIn"] == 1 and s["motion"] == {"uri": "gait.bones/subject01_walk1_ik.motion.json"}'
    diff -r --exclude '*.motion.json' made/bare.bones made/gait.bones
    "$BIN/simulate" --plan made/gait.scene.json > plan.json
    python3 -c '
import json
scene = json.load(open("plan.json"))["scene"]
joint = {b["name"]: b.get("joint") for b in scene["bones"]}
assert joint["femur_r"] == "femur_r" and joint["foot"] == "calcn_r" and len(scene["motion"]["joints"]) == 12, joint'
    "$BIN/rig-view" made/gait.scene.json --frame 0:10:10 -o gait.png
    "$BIN/simulate" -q made/gait.scene.json -o made --log made/gait.jsonl
    [ "$(wc -l < made/gait.jsonl)" -eq 11 ]
    # the model's motion made by motion-import is the same
    "$BIN/motion-import" "$walk" --skeleton "$model" --bones other --bone-path "$gait/meshes" -o other.motion.json
    python3 -c '
import json
a, b = json.load(open("other.motion.json")), json.load(open("made/gait.bones/subject01_walk1_ik.motion.json"))
assert a["joints"] == b["joints"] and a["coordinates"] == b["coordinates"] and len(a["bones"]) == len(b["bones"]) == 20'
    refused 1 ".*none of the model's 20 mesh files is there" "$build" --model "$model" --motion "$walk"
    refused 1 'tube.off: is no model' "$build" --model tube.off
    refused 1 "'tube.*=nobody': the motion has no joint" "$build" tube.muscle.json --model "$model" --bone-path "$gait/meshes" --bind 'tube=nobody'
    [ ! -e refused.bones ]
}
