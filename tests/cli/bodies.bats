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
    [ "$(member plan.json '[[b["name"], b["mesh"], b["units"], b.get("joint")] for b in d["scene"]["bones"]]')" = \
        '[["radius", "humerus.ply", 0.01, "elbow"], ["ulna", "humerus.ply", 1, "elbow"], ["scapula", "body/../scapula.ply", 1, null], ["humerus", "body/../humerus.ply", 1, null]]' ]
    edit body/arm.motion.json <<< 's["bones"].append(dict(s["bones"][0]))'
    run -1 simulate one.scene.json --plan
    [[ "$output" == *'two bones have the name "scapula"'* ]]
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
