# motion-sense: readings, activations and triggers from a motion; sides and patterns; tables, charts, reports; what is said of mistakes; the
# strikes of the feet of a recorded run and walk.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

share=$BATS_TEST_DIRNAME/../../share
captures=$DATA/mocap-cmu/motion

# member FILE EXPRESSION: a value of the document d
member() { /usr/bin/python3 -c "import json, sys; d = json.load(open(sys.argv[1])); print(json.dumps($2))" "$1"; }

valid() { # SCHEMA FILE
    /usr/bin/python3 -c 'import json, sys, jsonschema; s = json.load(open(sys.argv[1])); jsonschema.Draft202012Validator.check_schema(s)
jsonschema.Draft202012Validator(s).validate(json.load(open(sys.argv[2])))' "$share/schema/$1.schema.json" "$2"
}

# An arm whose elbow turns about -x, as a course of degrees over t says: bvh RATE SECONDS COURSE
bvh() {
    /usr/bin/python3 - "$@" << 'END'
import sys
from math import sin, cos, pi
rate, seconds, course = float(sys.argv[1]), float(sys.argv[2]), sys.argv[3]
count = round(rate * seconds) + 1
print("HIERARCHY\nROOT humerus\n{\nOFFSET 0 140 0\nCHANNELS 0\nJOINT ulna\n{\nOFFSET 0 -30 0\nCHANNELS 1 Xrotation\nEnd Site\n{\nOFFSET 0 -25 0\n}\n}\n}")
print(f"MOTION\nFrames: {count}\nFrame Time: {1 / rate:.12f}")
for k in range(count):
    t = k / rate
    print(repr(-float(eval(course))))
END
}

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    bvh 120 2 '45 - 45 * cos(pi * t)' > elbow.bvh
    cat > elbow.sensors.json << 'END'
{"format": "sinew-sensors", "version": 1, "name": "elbow", "sensors": [
 {"name": "biceps", "type": "angle", "joint": "ulna", "axis": "-x", "curve": [[0, 0], [90, 0.9]]},
 {"name": "speed", "type": "velocity", "joint": "ulna", "point": "end"},
 {"name": "triceps", "type": "angularVelocity", "joint": "ulna", "axis": "x",
  "trigger": {"threshold": 100, "hysteresis": 20, "attack": 0.05, "decay": 0.2, "level": 0.7}}]}
END
    # the same for two arms and some muscles; the right elbow turns half as far
    cat > body.sensors.json << 'END'
{"format": "sinew-sensors", "version": 1, "sides": ["l", "r"], "filter": 6,
 "muscles": ["brachialis_l", "biceps_long_l", "biceps_short_l", "brachialis_r", "biceps_long_r", "deltoid_r"],
 "sensors": [{"name": "elbow_{side}", "type": "angle", "joint": "{side}ulna", "axis": "-x", "curve": [[0, 0], [90, 1]]}],
 "channels": [{"muscles": ["biceps_*_{side}", "brachialis_{side}"], "sensors": "elbow_{side}", "floor": 0.1}]}
END
    sed 's/humerus/lhumerus/; s/ulna/lulna/; /^MOTION/,$d' elbow.bvh > both.bvh
    sed 's/humerus/rhumerus/; s/ulna/rulna/; 1d; /^MOTION/,$d' elbow.bvh >> both.bvh
    sed -n '/^MOTION/,$p' elbow.bvh | awk 'NF == 1 && !/MOTION/ { print $1, $1 / 2; next } { print }' >> both.bvh
}

@test "the document keeps to its schema, as the sensors do to theirs, and its history tells of both inputs" {
    "$BIN/motion-import" -q elbow.bvh -o elbow.motion.json
    "$BIN/motion-sense" --sensors elbow.sensors.json elbow.motion.json -o a.json 2> err
    [ ! -s err ]
    [ "$(member a.json '[list(d), list(d["channels"]), [len(c["times"]) for c in d["channels"].values()]]')" = \
        '[["format", "version", "name", "channels", "history"], ["biceps", "triceps"], [241, 241]]' ]
    [ "$(member a.json '[d["history"][0]["args"], d["history"][0]["input"]]')" = \
        "[[\"--sensors\", \"sha256:$(sha256sum < elbow.sensors.json | cut -d' ' -f1)\"], \"sha256:$(sha256sum < elbow.motion.json | cut -d' ' -f1)\"]" ]
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || skip "python3-jsonschema is not installed"
    valid activation a.json
    valid sensors elbow.sensors.json
    valid sensors body.sensors.json
    valid sensors "$share/examples/sensors/gait.sensors.json"
    sed 's/"x",/"w",/' elbow.sensors.json > bad.json
    refute valid sensors bad.json
}

@test "a pipe and a file give the same bytes, and so does a second run" {
    "$BIN/motion-import" --no-history elbow.bvh > motion.json
    "$BIN/motion-sense" --sensors elbow.sensors.json motion.json > a.json
    "$BIN/motion-sense" --sensors elbow.sensors.json - < motion.json | cmp - a.json
    "$BIN/motion-import" --no-history elbow.bvh | "$BIN/motion-sense" --sensors elbow.sensors.json | cmp - a.json
    "$BIN/motion-sense" --no-history --sensors elbow.sensors.json motion.json > c.json
    refute grep -q history c.json
    run -1 sh -c "'$BIN/motion-sense' --sensors elbow.sensors.json motion.json > /dev/full"
}

@test "readings and activations are those of the motion, in degrees and metres" {
    "$BIN/motion-sense" --sensors elbow.sensors.json --rate 24 --readings r.tsv elbow.bvh -o a.tsv
    /usr/bin/python3 - << 'END'
import math
rows = [line.rstrip("\n").split("\t") for line in open("r.tsv")]
assert rows[0] == ["time", "biceps", "biceps.activation", "speed", "triceps", "triceps.activation"], rows[0]
assert len(rows) == 50
for k, row in enumerate(rows[1:]):
    t, angle, activation, speed, turning, fired = map(float, row)
    assert abs(t - k / 24) < 1e-12
    w = -45 * math.pi * math.sin(math.pi * t) # of the angle about x
    assert abs(angle - (45 - 45 * math.cos(math.pi * t))) < 0.01, row
    assert abs(activation - angle / 100) < 1e-9
    assert abs(turning - w) < 0.15 and abs(speed - 0.25 * math.radians(abs(w))) < 1e-3, row
# back faster than 100 degrees/s: asin(100 / (45 pi)) / pi behind the turn; below 80 again before the end
begin, end = 1 + math.asin(100 / (45 * math.pi)) / math.pi, 2 - math.asin(80 / (45 * math.pi)) / math.pi
for row in rows[1:]:
    t, fired = float(row[0]), float(row[5])
    level = 0 if t < begin else 0.7 * min(1, (t - begin) / 0.05) if t < end else 0.7 * math.exp((end - t) / 0.2)
    assert abs(fired - level) < 2e-3, (t, fired, level)
channels = [line.rstrip("\n").split("\t") for line in open("a.tsv")]
assert channels[0] == ["time", "biceps", "triceps"] and [c[2] for c in channels[1:]] == [r[5] for r in rows[1:]]
END
    "$BIN/motion-sense" --sensors elbow.sensors.json elbow.bvh -o a.sto
    [ "$(sed -n '1p; /^nRows/p; /^nColumns/p; /^time/p' a.sto | tr '\n' ' ')" = "elbow nRows=241 nColumns=3 time	biceps	triceps " ]
    [ "$(sed '1,/^time/d' a.sto | wc -l)" -eq 241 ]
}

@test "the same motion at 24, 60 and 240 Hz gives the same activations within a hundredth" {
    course='50 - 30 * cos(2 * pi * 0.8 * t) + 15 * sin(2 * pi * 1.7 * t) - 5 * sin(2 * pi * 2.6 * t + 1)'
    sed 's/"speed", "type": "velocity"/"speed", "type": "acceleration", "curve": [[0, 0], [20, 1]]/' elbow.sensors.json > all.sensors.json
    for filter in 0 6; do
        for rate in 24 60 240; do
            bvh $rate 3 "$course" | "$BIN/motion-sense" --sensors all.sensors.json --filter $filter --rate 120 -o $rate.tsv
        done
        /usr/bin/python3 - $filter << 'END'
import sys
tables = [[[float(v) for v in line.split("\t")] for line in open(f"{rate}.tsv").readlines()[1:]] for rate in (24, 60, 240)]
assert all(len(t) == 361 for t in tables)
for column in (1, 2, 3):
    values = [[row[column] for row in t] for t in tables]
    span = max(values[2]) - min(values[2])
    assert span > 0.4, span
    for v in values[:2]:
        wrong = [abs(a - b) / span for a, b in zip(v, values[2])]
        assert max(wrong[5:-5]) < 0.01, (column, max(wrong[5:-5]))
        # in the first and the last frame of 24 Hz a spline has nothing on its other side: accelerations are less exact without a filter
        assert max(wrong) < (0.01 if sys.argv[1] == "6" or column != 2 else 0.1), (column, max(wrong))
END
    done
}

@test "sides and patterns make a channel for each muscle; what they miss is told" {
    "$BIN/motion-sense" --sensors body.sensors.json both.bvh -o a.json 2> err
    [ "$(member a.json 'list(d["channels"])')" = '["biceps_long_l", "biceps_short_l", "brachialis_l", "biceps_long_r", "brachialis_r"]' ]
    [ "$(member a.json '[round(max(c["values"]), 2) for c in d["channels"].values()]')" = '[1, 1, 1, 0.5, 0.5]' ]
    [ "$(member a.json '[min(c["values"]) for c in d["channels"].values()]')" = '[0.1, 0.1, 0.1, 0.1, 0.1]' ]
    [ "$(cat err)" = "motion-sense: warning: body.sensors.json: 1 of 6 muscles have no channel: deltoid_r" ]
    printf '# some\nbiceps_l\nbiceps_a_l\nbrachialis_l\n' > muscles.txt
    "$BIN/motion-sense" --sensors body.sensors.json --muscles muscles.txt both.bvh -o b.json 2> err
    [ "$(member b.json 'list(d["channels"])')" = '["biceps_a_l", "brachialis_l", "brachialis_r"]' ]
    grep -q "there is no muscle biceps_\*_r, brachialis_r" err
    grep -q "1 of 3 muscles have no channel: biceps_l" err
    printf '{"format": "sinew-scene", "version": 1, "muscles": [{"name": "biceps_x_r", "rig": "none"}]}' > a.scene.json
    "$BIN/motion-sense" -q --sensors body.sensors.json --muscles a.scene.json both.bvh -o c.json
    [ "$(member c.json 'list(d["channels"])')" = '["brachialis_l", "biceps_x_r", "brachialis_r"]' ]
}

@test "a list of muscles may begin with a byte order mark and end its lines as Windows does" {
    printf '{"format": "sinew-sensors", "version": 1, "sensors": [{"name": "s", "type": "angle", "joint": "ulna", "axis": "-x", "curve": [[0, 0], [90, 1]]}],
 "channels": [{"muscles": "biceps", "sensors": "s"}]}' > one.sensors.json
    printf '\xef\xbb\xbfbiceps\r\n' > names.txt
    "$BIN/motion-sense" --sensors one.sensors.json --muscles names.txt elbow.bvh -o a.json 2> err
    refute grep -q channel err
    refute grep -q "no muscle" err
}

@test "--list tells joints, sensors and channels, and writes nothing else" {
    "$BIN/motion-sense" --list --sensors body.sensors.json -q both.bvh -o none.json > list
    [ ! -e none.json ]
    printf '%s\t%s\t%s\t%s\n' joint lhumerus - - joint lulna lhumerus end joint rhumerus - - joint rulna rhumerus end > expected
    for s in l r; do printf 'sensor\telbow_%s\tangle\tdegrees\t%sulna\n' $s $s; done >> expected
    for m in biceps_long_l biceps_short_l brachialis_l biceps_long_r brachialis_r; do
        printf 'channel\t%s\tmax\telbow_%s\n' $m "${m##*_}"
    done >> expected
    cmp list expected
    [ "$("$BIN/motion-sense" --list elbow.bvh | wc -l)" -eq 2 ]
}

@test "mistakes are errors that name the place, and nothing is written" {
    refused() { # WORD SED-EXPRESSION
        sed "$2" elbow.sensors.json > bad.sensors.json
        run -1 "$BIN/motion-sense" --sensors bad.sensors.json elbow.bvh -o none.json
        [[ "$output" == "motion-sense: bad.sensors.json:"*"$1"* ]] || { echo "$output"; return 1; }
        [ "${#lines[@]}" -eq 1 ]
        [ ! -e none.json ]
    }
    refused "sensor \"biceps\": the motion has no joint \"ulan\"; --list names" 's/"joint": "ulna", "axis": "-x"/"joint": "ulan", "axis": "-x"/'
    refused "sensors[0].type" 's/"angle"/"angel"/'
    refused "no sensor feeds the channel" 's/]}$/], "channels": [{"muscles": "m", "sensors": []}]}/'
    refused "there is no sensor \"bicesp\"" 's/]}$/], "channels": [{"muscles": "m", "sensors": "bicesp"}]}/'
    refused "activates nothing" 's/]}$/], "channels": [{"muscles": "m", "sensors": "speed"}]}/'
    refused "has two channels" 's/]}$/], "channels": [{"muscles": ["m", "m"], "sensors": "biceps"}]}/'
    refused "no muscles that it could match" 's/]}$/], "channels": [{"muscles": "m*", "sensors": "biceps"}]}/'
    refused "not greater than" 's/\[90, 0.9\]/[-90, 0.9]/'
    refused "its reading is not a finite number" 's/"point": "end"/"point": [1e308,1e308,1e308]/'
    refused "a filter of 0.001 Hz is too low for 240 samples a second: choose 0.0097 Hz or more" 's/"sensors"/"filter": 0.001, "sensors"/'
    printf ':FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0\n' > a.amc
    run -1 "$BIN/motion-sense" --sensors elbow.sensors.json a.amc
    [[ "$output" == "motion-sense: a.amc: is AMC; make a motion document of it with motion-import" ]]
    run -2 "$BIN/motion-sense" elbow.bvh
    [[ "$output" == "motion-sense: --sensors FILE is missing; see motion-sense --help" ]]
    run -2 "$BIN/motion-sense" --sensors elbow.sensors.json --chart a.pdf elbow.bvh
    run -2 "$BIN/motion-sense" --sensors elbow.sensors.json --readings - elbow.bvh
    run -1 "$BIN/motion-sense" --sensors nowhere.json elbow.bvh
    [[ "$output" == *nowhere.json* ]]
}

@test "what does nothing is told in one warning each" {
    told() { # WORD SED-EXPRESSION
        sed "$2" elbow.sensors.json > odd.sensors.json
        "$BIN/motion-sense" --sensors odd.sensors.json elbow.bvh -o a.json 2> err
        grep -q "^motion-sense: warning: .*$1" err || { cat err; return 1; }
        [ "$(wc -l < err)" -eq 1 ]
    }
    told "sensor 'triceps' never fires: it never passes its threshold; it reads from -141.4 to 141.4 degrees/s" 's/"threshold": 100/"threshold": 1000/'
    told "sensor 'triceps' never fires: it starts beyond" 's/"threshold": 100/"threshold": -1000/'
    told "sensor 'biceps' activates by 0 throughout: it reads from [-e0-9.]* to 90 degrees, where its curve is level" \
        's/\[0, 0\], \[90, 0.9\]/[100, 0], [180, 0.9]/'
    told "no channel takes the sensor triceps" 's/]}$/], "channels": [{"muscles": "m", "sensors": "biceps"}]}/'
    told "sensor 'triceps': the attack of its trigger, 50 s, is longer than the motion, 2 s; times are in seconds" 's/"attack": 0.05/"attack": 50/'
    told "sensor 'triceps': the decay of its trigger, 200 s, is longer than the motion" 's/"decay": 0.2/"decay": 200/'
    fixed='reads the same all the time: what it measures and what that is measured from are both fixed to'
    told "sensor \"biceps\" $fixed ulna" 's/"axis": "-x"/"axis": "-x", "relativeTo": "ulna"/'
    told "sensor \"speed\" $fixed ulna" 's/"velocity", "joint": "ulna", "point": "end"/"distance", "joint": "ulna", "point": "end", "to": "ulna"/'
    told "sensor \"speed\" $fixed the world" 's/"velocity", "joint": "ulna", "point": "end"/"velocity", "joint": "world", "point": [0,0,1]/'
    told "sinew knows no member hold_ (did you mean hold?) here" 's/"attack"/"hold_": 1, "attack"/'
    told "a filter of 70 Hz has nothing to take from 120 frames a second" 's/"sensors"/"filter": 70, "sensors"/'
    awk '/^-/ && n++ >= 100 { print $1 - 170; next } { print }' elbow.bvh > flip.bvh
    "$BIN/motion-sense" --sensors elbow.sensors.json flip.bvh -o a.json 2> err
    grep -q "'ulna' turns by 1[67][0-9] degrees from frame" err
    "$BIN/motion-sense" -q --sensors elbow.sensors.json flip.bvh -o a.json 2> err
    [ ! -s err ]
}

@test "times are those of the motion, also where its first key lies before 0" {
    printf '{"format": "sinew-motion", "version": 1, "rate": 10, "joints": [{"name": "ulna", "type": "hinge", "axis": [-1, 0, 0], "point": [0, 0, 0],
 "keys": [[-0.5, 0], [0.5, 100]]}]}' > early.motion.json
    sed 's/, "point": "end"//' elbow.sensors.json > early.sensors.json
    "$BIN/motion-sense" -q --sensors early.sensors.json early.motion.json -o a.json
    [ "$(member a.json '[(c := d["channels"]["biceps"])["times"][0], c["times"][-1], round(c["values"][len(c["times"]) // 2], 6)]')" = '[-0.5, 0.5, 0.5]' ]
}

@test "a joint that has no rest place has angles and no places" {
    printf '{"format": "sinew-motion", "version": 1, "rate": 10, "joints": [{"name": "ulna", "type": "pose", "keys": [{"frame": 0}, {"frame": 9, "translation": [0, 0, 1]}]}]}' > bare.motion.json
    sensor() { printf '{"format": "sinew-sensors", "version": 1, "sensors": [{"name": "s", "joint": "ulna", "axis": "z", %s, "curve": [[0, 0], [1, 1]]}]}' "$1" > bare.sensors.json; }
    sensor '"type": "position"'
    run -1 "$BIN/motion-sense" --sensors bare.sensors.json bare.motion.json -o none.json
    [[ "$output" == *'sensor "s": the motion does not tell where joint "ulna" is at rest'* ]]
    [ ! -e none.json ]
    sensor '"type": "position", "point": [0, 0, 0]'
    "$BIN/motion-sense" -q --sensors bare.sensors.json bare.motion.json -o a.json
    [ "$(member a.json 'd["channels"]["s"]["values"][-1]')" = 1 ]
    sensor '"type": "angle"'
    "$BIN/motion-sense" -q --sensors bare.sensors.json bare.motion.json -o a.json
}

@test "--report, --trace and --stop-after" {
    "$BIN/motion-sense" --sensors elbow.sensors.json --report r.json --trace t.jsonl elbow.bvh -o a.json
    [ "$(member r.json '[d["frames"], d["samples"], d["rate"], [s["name"] for s in d["sensors"]], [c["name"] for c in d["channels"]]]')" = \
        '[241, 241, 120, ["biceps", "speed", "triceps"], ["biceps", "triceps"]]' ]
    [ "$(member r.json '[[round(t, 3) for t in d["sensors"][2]["fired"]], d["sensors"][0].get("fired"), round(d["sensors"][0]["greatest"], 3)]')" = \
        '[[1.25], null, 90]' ]
    [ "$(grep -c '"stage": *"sensor"' t.jsonl) $(grep -c '"stage": *"channel"' t.jsonl)" = "3 2" ]
    "$BIN/motion-sense" --sensors elbow.sensors.json --stop-after 4 elbow.bvh -o b.json
    [ "$(member b.json 'list(d["channels"])')" = '["biceps"]' ]
    [ "$(member b.json 'd["channels"]["biceps"]')" = "$(member a.json 'd["channels"]["biceps"]')" ]
    "$BIN/motion-sense" --sensors elbow.sensors.json --stop-after 1 elbow.bvh -o c.json
    [ "$(member c.json 'd["channels"]')" = '{}' ]
}

@test "a chart, as SVG and as PNG; without gnuplot all else is there" {
    code=0
    PATH=$BIN motion-sense --sensors elbow.sensors.json --chart none.svg elbow.bvh -o a.json 2> err || code=$?
    [ "$code" -eq 3 ]
    grep -q "no chart: gnuplot is not installed" err
    [ -s a.json ]
    command -v gnuplot > /dev/null || skip "gnuplot is not here"
    "$BIN/motion-sense" --sensors elbow.sensors.json --chart a.svg --title 'An "elbow"' elbow.bvh -o b.json 2> err
    "$BIN/motion-sense" --sensors body.sensors.json -q --chart b.png both.bvh -o c.json
    [ ! -s err ]
    cmp a.json b.json
    /usr/bin/python3 - << 'END'
import struct, xml.etree.ElementTree as tree
text = "".join(tree.parse("a.svg").getroot().itertext())
for word in ('An "elbow"', "biceps, degrees", "speed, m/s", "triceps, degrees/s", "time, s"): assert word in text, word
png = open("b.png", "rb").read() # two sensors, and a channel with a floor for each
assert png[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", png[16:24]) == (800, 810), struct.unpack(">II", png[16:24])
END
}

@test "a scene takes its channels, and a muscle contracts by them" {
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" arm > log 2>&1
    cd arm
    /usr/bin/python3 - << 'END'
import json
scene = json.load(open("arm.scene.json"))
json.dump({"format": "sinew-motion", "version": 1, "rate": 24, **scene["motion"]}, open("elbow.motion.json", "w"))
for muscle in scene["muscles"][:2]: muscle["activation"] = {"uri": "arm.activation.json"}
json.dump(scene, open("sensed.scene.json", "w"))
END
    printf '{"format": "sinew-sensors", "version": 1, "sensors": [{"name": "elbow", "type": "angle", "joint": "elbow", "curve": [[0, 0.1], [120, 0.9]]}],
 "channels": [{"muscles": ["biceps", "brachialis"], "sensors": "elbow"}]}' > arm.sensors.json
    "$BIN/motion-sense" --sensors arm.sensors.json --muscles arm.scene.json elbow.motion.json -o arm.activation.json 2> err
    grep -q "1 of 3 muscles have no channel: triceps" err
    "$BIN/simulate" sensed.scene.json --plan > plan.json
    [ "$(member plan.json '[[m["name"], len(m["activation"]["keys"]), [round(v, 3) for v in m["activation"]["keys"][-1]]] for m in d["scene"]["muscles"][:2]]')" = \
        '[["biceps", 241, [2, 0.9]], ["brachialis", 241, [2, 0.9]]]' ]
    "$BIN/simulate" sensed.scene.json --frames 0:2 -o out --log log.jsonl
}

# The run's legs by the example's sensors: strikes MOTION-FILE REPORT
sense_gait() {
    printf 'soleus_left\nsoleus_right\n' > calves.txt
    "$BIN/motion-sense" -q --sensors "$share/examples/sensors/gait.sensors.json" --muscles calves.txt "$1" --report "$2" -o sensed.activation.json
}

@test "the trigger fires once at each foot strike of the run, within two frames, and at nothing else" {
    [ -d "$captures" ] || skip "mocap-cmu is not there"
    "$BIN/motion-import" -q "$captures/02_03.amc" --skeleton "$captures/02.asf" -o run.motion.json
    sense_gait run.motion.json run.report.json
    "$BATS_TEST_DIRNAME/../foot-strikes.py" run.motion.json run.report.json 2
    for rate in 60 240; do # the same run from the other file, as if captured so
        "$BIN/motion-import" -q "$captures/cmu_02_03_run.bvh" --rate $rate -o other.motion.json
        sense_gait other.motion.json other.report.json
        "$BATS_TEST_DIRNAME/../foot-strikes.py" run.motion.json other.report.json 2
    done
    # one firing less, or one more, is found out
    sed 's/"fired": \[[0-9.]*,/"fired": [/' run.report.json > less.json
    refute "$BATS_TEST_DIRNAME/../foot-strikes.py" run.motion.json less.json 2
    sed 's/"fired": \[/"fired": [0.01,/' run.report.json > more.json
    refute "$BATS_TEST_DIRNAME/../foot-strikes.py" run.motion.json more.json 2
}

@test "by the same document it fires once for each step of the walk" {
    [ -d "$captures" ] || skip "mocap-cmu is not there"
    "$BIN/motion-import" -q "$captures/02_01.amc" --skeleton "$captures/02.asf" -o walk.motion.json
    sense_gait walk.motion.json walk.report.json
    # the heel comes first: the ball of the foot has slowed down before it is within 10 mm of its lowest
    "$BATS_TEST_DIRNAME/../foot-strikes.py" walk.motion.json walk.report.json 8
}

@test "run and walk, smoothed to 6 Hz, activate alike at 24, 60 and 240 Hz" {
    [ -d "$captures" ] || skip "mocap-cmu is not there"
    printf 'soleus_left\nsoleus_right\n' > calves.txt
    for motion in 02_03 02_01; do
        for rate in 24 60 120 240; do
            "$BIN/motion-import" -q "$captures/$motion.amc" --skeleton "$captures/02.asf" --filter 6 --rate $rate |
                "$BIN/motion-sense" -q --sensors "$share/examples/sensors/gait.sensors.json" --muscles calves.txt --rate 120 \
                    --readings $rate.tsv -o activation.json
        done
        /usr/bin/python3 - << 'END'
tables = {rate: [line.rstrip("\n").split("\t") for line in open(f"{rate}.tsv")] for rate in (24, 60, 120, 240)}
columns = [i for i, name in enumerate(tables[120][0]) if name.endswith(".activation")]
assert len(columns) == 8
count = min(len(t) for t in tables.values())
for column in columns:
    values = {rate: [float(row[column]) for row in table[1:count]] for rate, table in tables.items()}
    span = max(values[120]) - min(values[120])
    assert span > 0.25, (column, span)
    for rate in (24, 60, 240): # but for two frames of 24 Hz at each end, where nothing lies beyond
        worst = max(abs(a - b) for a, b in list(zip(values[rate], values[120]))[10:-10]) / span
        assert worst < 0.01, (tables[120][0][column], rate, worst)
END
    done
}

@test "gnuplot dies with the tool" {
    mkdir -p fake
    printf '#!/bin/sh\nexec sleep 4711.0818\n' > fake/gnuplot
    chmod +x fake/gnuplot
    PATH=$PWD/fake:$BIN:$PATH motion-sense --sensors elbow.sensors.json --chart none.svg elbow.bvh -o a.json > out 2>&1 &
    tool=$!
    until pgrep -f 'sleep 4711.0818' > found || ! kill -0 $tool; do sleep 0.1; done
    [ -s found ]
    kill -KILL $tool
    for i in $(seq 300); do # it dies soon, and how soon is the machine's affair
        pgrep -f 'sleep 4711.0818' > /dev/null || break
        sleep 0.1
    done
    run pgrep -f 'sleep 4711.0818'
    [ "$status" -ne 0 ]
}
