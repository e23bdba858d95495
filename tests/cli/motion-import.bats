# motion-import: what it writes keeps to the schema and moves the joints as the file says; frames, rate and filter; lists, reports, refusals.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

schema=$BATS_TEST_DIRNAME/../../share/schema/motion.schema.json
captures=$DATA/mocap-cmu/motion

# member FILE EXPRESSION: a value of the document d
member() { /usr/bin/python3 -c "import json, sys; d = json.load(open(sys.argv[1])); print(json.dumps($2))" "$1"; }

# An arm of two joints at 100 Hz: the elbow turns by one degree a frame about z. bvh FRAMES
bvh() {
    printf 'HIERARCHY\nROOT shoulder\n{\nOFFSET 0 100 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n'
    printf 'JOINT elbow\n{\nOFFSET 30 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 25 0 0\n}\n}\n}\n'
    printf 'MOTION\nFrames: %d\nFrame Time: 0.01\n' "$1"
    awk -v n="$1" 'BEGIN { for (i = 0; i < n; i++) print 0, 100, 0, 0, 0, 0, i, 0, 0 }'
}

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    bvh 101 > arm.bvh
}

@test "a BVH becomes a motion document in metres, z up, that keeps to the schema" {
    "$BIN/motion-import" arm.bvh -o arm.motion.json 2> err
    [ ! -s err ]
    [ "$(member arm.motion.json '[list(d), d["name"], d["rate"], d["metersPerUnit"]]')" = \
        '[["format", "version", "name", "metersPerUnit", "rate", "joints", "coordinates", "history"], "arm", 100, 1]' ]
    [ "$(member arm.motion.json '[[j["name"], j.get("parent"), j["rest"], j.get("end"), len(j["keys"])] for j in d["joints"]]')" = \
        '[["shoulder", null, [0, 0, 1], null, 101], ["elbow", "shoulder", [0.3, 0, 1], [0.55, 0, 1], 101]]' ]
    [ "$(member arm.motion.json '[[c["name"], c["unit"]] for c in d["coordinates"]][5:7]')" = '[["shoulder.Yrotation", "rad"], ["elbow.Zrotation", "rad"]]' ]
    # y up in the file: what turned about z there turns about -y here; 90 degrees carry the end of the forearm up
    /usr/bin/python3 - arm.motion.json << 'END'
import json, math, sys
key = json.load(open(sys.argv[1]))["joints"][1]["keys"][90]
w, x, y, z = key["rotation"]
assert key["frame"] == 90 and math.dist((w, x, y, z), (0.5 ** 0.5, 0, -0.5 ** 0.5, 0)) < 1e-15, key
rotate = lambda p: (p[2] * 2 * (x * z + w * y) + p[0] * (1 - 2 * (y * y + z * z)), p[1], p[0] * 2 * (x * z - w * y) + p[2] * (1 - 2 * (x * x + y * y)))
end = [a + b for a, b in zip(rotate((0.55, 0, 1)), key["translation"])]
assert math.dist(end, (0.3, 0, 1.25)) < 1e-14, end
END
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || skip "python3-jsonschema is not installed"
    /usr/bin/python3 -c 'import json, jsonschema; s = json.load(open("'"$schema"'")); jsonschema.Draft202012Validator.check_schema(s)
jsonschema.Draft202012Validator(s).validate(json.load(open("arm.motion.json")))'
}

@test "a pipe and a file give the same bytes but for the name, and so does a second run" {
    "$BIN/motion-import" < arm.bvh > pipe.json
    "$BIN/motion-import" - < arm.bvh | cmp - pipe.json
    "$BIN/motion-import" arm.bvh | sed '/^  "name"/d' > file.json
    cmp file.json pipe.json
    run -1 sh -c "'$BIN/motion-import' arm.bvh > /dev/full"
}

@test "the history tells what changes the result, with files by their hash" {
    "$BIN/motion-import" --filter 6.0 --frames 10:50 --rate 5e1 -q arm.bvh > a.json
    [ "$(member a.json '[[h["tool"], h["args"]] for h in d["history"]]')" = '[["motion-import", ["--frames", "10:50", "--rate", "50", "--filter", "6"]]]' ]
    [ "$(member a.json 'd["history"][0]["input"]')" = "\"sha256:$(sha256sum < arm.bvh | cut -d' ' -f1)\"" ]
    "$BIN/motion-import" a.json --frames 0:5 > b.json
    [ "$(member b.json '[h["args"] for h in d["history"]]')" = '[["--frames", "10:50", "--rate", "50", "--filter", "6"], ["--frames", "0:5"]]' ]
    "$BIN/motion-import" --no-history arm.bvh > c.json
    refute grep -q history c.json
}

@test "frames are kept from A to B, both; one of them may be left out" {
    "$BIN/motion-import" --frames 20:30 arm.bvh > a.json
    [ "$(member a.json '[len(d["joints"][1]["keys"]), d["joints"][1]["keys"][0]["frame"], len(d["coordinates"][6]["values"]), round(d["coordinates"][6]["values"][0] * 57.29577951308232, 9)]')" = '[11, 0, 11, 20.0]' ]
    "$BIN/motion-import" --frames 95: arm.bvh > b.json
    [ "$(member b.json 'len(d["joints"][1]["keys"])')" = 6 ]
    "$BIN/motion-import" --frames :3 arm.bvh > c.json
    [ "$(member c.json 'len(d["joints"][1]["keys"])')" = 4 ]
    for bad in 5:4 -1:3 0:101 x 3 1:2:3 1:x; do
        run -2 "$BIN/motion-import" --frames=$bad arm.bvh
        [ "${#lines[@]}" -eq 1 ]
    done
}

@test "another rate: as many frames as fit, at the same times" {
    "$BIN/motion-import" --rate 24 arm.bvh > a.json
    [ "$(member a.json '[d["rate"], len(d["joints"][1]["keys"]), round(d["coordinates"][6]["values"][24] * 57.29577951308232, 9)]')" = '[24, 25, 100.0]' ]
}

@test "the filter takes what is fast and leaves what is slow; the ends stay" {
    bvh 201 | awk 'NF == 9 && $1 + 0 == $1 { $7 += 3 * sin(n++ * 3.14159265358979 / 2); print; next } { print }' > shaken.bvh # 25 Hz
    "$BIN/motion-import" --filter 6 shaken.bvh > a.json
    /usr/bin/python3 - a.json << 'END'
import json, math, sys
values = [math.degrees(v) for v in json.load(open(sys.argv[1]))["coordinates"][6]["values"]]
assert max(abs(v - i) for i, v in enumerate(values[40:161], 40)) < 0.01, values
assert all(b > a for a, b in zip(values, values[1:])) and abs(values[-1] - 200) < 1e-9
END
    run -2 "$BIN/motion-import" --filter 50 arm.bvh
    [[ "$output" == *"half of the source's rate, 100 Hz"* ]]
}

@test "a jump is told and left: by a warning, in the report, in the trace" {
    bvh 21 | awk 'NF == 9 && $1 + 0 == $1 && n++ >= 10 { $7 += 170 } { print }' > flip.bvh
    "$BIN/motion-import" --filter 6 flip.bvh --report flip.report.json --trace flip.trace > a.json 2> err
    grep -qx "motion-import: warning: flip.bvh: 'elbow' turns by 171 degrees from frame 9 to 10; left as it is" err
    [ "$(member flip.report.json '[[j["joint"], j["frame"], round(j["degrees"])] for j in d["jumps"]]')" = '[["elbow", 10, 171]]' ]
    grep -q '"stage": *"jump"' flip.trace
    /usr/bin/python3 - a.json << 'END'
import json, math, sys
values = [math.degrees(v) for v in json.load(open(sys.argv[1]))["coordinates"][6]["values"]]
assert all(abs(v - i - 170 * (i >= 10)) < 0.05 for i, v in enumerate(values)), values
END
}

@test "--list tells frames, rate, joints and coordinates, and writes nothing else" {
    "$BIN/motion-import" --list arm.bvh -o none.json > list 2> err
    [ ! -s err ]
    [ ! -e none.json ]
    printf 'format\tBVH\nframes\t101\nrate\t100\nseconds\t1\njoint\t1\tshoulder\t-\t0\t0\t1\njoint\t2\telbow\tshoulder\t0.3\t0\t1\n' > expected
    head -6 list | cmp - expected
    grep -q "^coordinate	7	elbow.Zrotation	rad	0	1.745329" list
    [ "$(wc -l < list)" -eq 15 ]
}

@test "unit, axis, rate and positions of a source that does not say are options" {
    "$BIN/motion-import" --units mm --up z --source-rate 50 arm.bvh > a.json
    [ "$(member a.json '[d["joints"][1]["rest"], d["rate"]]')" = '[[0.03, 0.1, 0], 50]' ]
    "$BIN/motion-import" --positions add arm.bvh > b.json
    [ "$(member b.json 'd["joints"][0]["keys"][0]["translation"]')" = '[0, 0, 1]' ]
    "$BIN/motion-import" --positions replace arm.bvh > c.json
    [ "$(member c.json 'd["joints"][0]["keys"][0]["translation"]')" = '[0, 0, 0]' ]
}

@test "--trace tells each step, and --stop-after leaves what was done by then" {
    "$BIN/motion-import" --filter 6 --rate 50 --trace all.trace arm.bvh > all.json
    [ "$(grep -c '"stage": *"filter"' all.trace)" -eq 3 ]
    grep -q '"stage": *"resample"' all.trace
    "$BIN/motion-import" --filter 6 --rate 50 --stop-after 1 arm.bvh > one.json
    [ "$(member one.json '[d["rate"], len(d["joints"][0]["keys"])]')" = '[100, 101]' ]
}

@test "--stop-after takes a number of steps, and nothing else" {
    for count in 1:2 -1 1.5 x; do
        run -2 "$BIN/motion-import" --stop-after=$count arm.bvh -o none.json
        [[ "$output" == *--stop-after* ]]
        [ ! -e none.json ]
    done
}

@test "a joint without a rest place gets none; keys before 0 seconds are told where they go" {
    printf '{"format": "sinew-motion", "version": 1, "rate": 10, "joints": [
 {"name": "drift", "type": "pose", "keys": [{"time": -0.5, "translation": [0, 0, 0]}, {"time": 0.5, "translation": [1, 0, 0]}]},
 {"name": "knee", "parent": "drift", "type": "hinge", "axis": [0, 1, 0], "point": [0, 0, 0.5], "degrees": 30}]}' > early.motion.json
    "$BIN/motion-import" early.motion.json -o late.motion.json 2> err
    grep -q 'early.motion.json: its first key is at -0.5 s' err
    [ "$(member late.motion.json '[[j.get("rest"), len(j["keys"])] for j in d["joints"]]')" = '[[null, 11], [[0, 0, 0.5], 11]]' ]
    "$BIN/motion-import" -q --list early.motion.json | grep -q "^joint	1	drift	-	-	-	-$"
    "$BIN/motion-import" late.motion.json -o again.motion.json 2> err
    refute grep -q "first key" err
}

@test "what only a scene can tell, and coordinates without a sample, are refused" {
    printf '{"format": "sinew-motion", "version": 1, "rate": 48, "joints": [
 {"name": "elbow", "type": "hinge", "axis": [0, 1, 0], "point": [0, 0, 0], "degreesPerFrame": 10}]}' > turn.motion.json
    run -1 "$BIN/motion-import" turn.motion.json
    [[ "$output" == *'joints[0].degreesPerFrame: only the frames of a scene tell'* ]]
    # in a scene of another rate it goes from the scene's first frame to its last
    printf '{"format": "sinew-scene", "version": 1, "rate": 24, "frames": [12, 24], "motion": {"uri": "turn.motion.json"}}' > turn.scene.json
    "$BIN/simulate" -q --plan turn.scene.json > plan.json
    [ "$(member plan.json '[[time, round(degrees, 9)] for time, degrees in d["scene"]["motion"]["joints"][0]["keys"]]')" = '[[0.5, 0], [1, 120.0]]' ]
    printf '{"format": "sinew-motion", "version": 1, "joints": [{"name": "a", "type": "pose", "keys": [{"time": 0}]}],
 "coordinates": [{"name": "q", "values": []}]}' > bare.motion.json
    run -1 "$BIN/motion-import" bare.motion.json
    [[ "$output" == *'coordinates[0].values: there is no sample'* ]]
}

@test "a broken file is refused with its line, and nothing is written" {
    head -115 arm.bvh > cut.bvh
    echo old > kept.json
    run -1 "$BIN/motion-import" cut.bvh -o kept.json
    [[ "$output" == "motion-import: cut.bvh:"*"after "*" of 101 frames; it is cut off" ]]
    [ "$(cat kept.json)" = old ]
    run -1 "$BIN/motion-import" --skeleton nowhere.asf arm.bvh
    [[ "$output" == *nowhere.asf* ]]
}

@test "a scene takes the document: its bone moves, and rest places and coordinates come through its plan" {
    "$BIN/motion-import" -q arm.bvh -o arm.motion.json
    printf 'OFF\n4 4 0\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' > bone.off
    printf '{"format": "sinew-scene", "version": 1, "motion": {"uri": "arm.motion.json"},
 "bones": [{"name": "ulna", "mesh": "bone.off", "joint": "elbow"}]}' > a.scene.json
    "$BIN/simulate" --plan a.scene.json > plan.json 2> err
    refute grep -q "unknown" err
    [ "$(member plan.json '[d["scene"]["motion"]["joints"][1]["rest"], d["scene"]["motion"]["coordinates"][6]["name"], d["scene"]["motion"]["coordinates"][6]["rate"]]')" = \
        '[[0.3, 0, 1], "elbow.Zrotation", 100]' ]
}

@test "Acclaim's walk and run: as long, as fast, and where the BVH has them" {
    [ -d "$captures" ] || skip "mocap-cmu is not there"
    "$BIN/motion-import" -q "$captures/02_01.amc" --skeleton "$captures/02.asf" --report walk.report.json > walk.json
    "$BIN/motion-import" -q "$captures/02_03.amc" --skeleton "$captures/02.asf" --report run.report.json > run.json
    [ "$(member walk.report.json '[d["frames"], d["rate"], d["joints"], round(d["rootSpeed"], 2)]')" = '[343, 120, 31, 1.19]' ]
    [ "$(member run.report.json '[d["frames"], d["rate"], d["joints"], round(d["rootSpeed"], 2)]')" = '[173, 120, 31, 2.66]' ]
    run -1 "$BIN/motion-import" "$captures/02_01.amc"
    [[ "$output" == *"name an .asf file with --skeleton" ]]
    run -0 --separate-stderr "$BIN/motion-import" "$captures/02_01.amc" --skeleton "$captures/02.asf"
    [[ "$stderr" == *"tells no rate: taken as 120 Hz"* ]]
}
