# moment-arm: straps over cylinders, OpenSim's lengths against the model's geometry, a tube in a model; units, gaps, knots, other coordinates;
# tables, charts, reports; measured curves; what is said of mistakes.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

here=$BATS_TEST_DIRNAME/..
share=$here/../share
gait=$DATA/gait1018-opensim
lengths=$gait/walk_gait1018_muscle_lengths.sto
walk=$gait/walk_gait1018_state_reference.mot
model=$gait/walk_gait1018_subject01.osim

# member FILE EXPRESSION: a value of the document d
member() { python3 -c "import json, sys; d = json.load(open(sys.argv[1])); print(json.dumps($2))" "$1"; }

valid() { # SCHEMA FILE
    /usr/bin/python3 -c 'import json, sys, jsonschema; s = json.load(open(sys.argv[1])); jsonschema.Draft202012Validator.check_schema(s)
jsonschema.Draft202012Validator(s).validate(json.load(open(sys.argv[2])))' "$share/schema/$1.schema.json" "$2"
}

# table HEAD ROWS EXPRESSION: a row of names, then the values of the expression (a tuple over k, t = k / ROWS, a = an angle up and down, 0 to 40
# degrees, q = the same in radians) for each k
table() {
    python3 - "$@" << 'END'
import sys
from math import *
head, rows, values = sys.argv[1], int(sys.argv[2]), sys.argv[3]
print("\t".join(head.split()))
for k in range(rows + 1):
    t = k / rows
    a = 40 * (1 - abs(2 * t - 1))
    q = radians(a)
    print("\t".join(v if isinstance(v, str) else repr(v) for v in eval(values)))
END
}

# within FILE LOW HIGH: every arm of a table of moment-arm, and that there are some
within() {
    awk -F '\t' -v low="$2" -v high="$3" 'NR > 1 { n++; if (!($4 >= low && $4 <= high)) { print; bad = 1 } } END { exit bad || n < 2 }' "$1"
}

# storage TABLE LINE...: the table under a header of OpenSim's with these lines
storage() {
    echo x
    printf '%s\n' version=1 "${@:2}" endheader
    cat "$1"
}

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    PATH=$BIN:$PATH
    table 'time elbow.angle strap.1 strap.2' 80 '(t, a, 0.2 - 0.020 * q, 0.2 - 0.022 * q)' > strap.tsv
}

@test "a strap over a cylinder has its radius for an arm; the files say the same" {
    moment-arm --coordinate elbow strap.tsv -o a.tsv --fibers f.tsv --report r.json 2> err
    within a.tsv 0.0209999 0.0210001
    [ "$(head -n 1 a.tsv)" = "muscle	coordinate	angle	arm	sd	lower	upper	noise	up	down	fibers" ]
    [ "$(wc -l < a.tsv)" -eq 92 ]
    [ "$(wc -l < err)" -eq 1 ]
    grep -q '^moment-arm: 1 muscles, 2 fibres over "elbow.angle" from 0 to 40 degrees, 1 ways up and 1 down: up and down differ by .* mm at most; noise' err
    python3 - << 'END'
import json, math
names = "muscle coordinate angle arm sd lower upper noise up down fibers".split()
rows = [dict(zip(names, l.rstrip("\n").split("\t"))) for l in open("a.tsv")][1:]
fibers = [l.rstrip("\n").split("\t") for l in open("f.tsv")]
assert fibers[0] == ["angle", "strap.1", "strap.2"] and len(fibers) == 92
for row, fiber in zip(rows, fibers[1:]):
    angle, a, b = map(float, fiber)
    assert abs(angle - float(row["angle"])) < 1e-9 and row["fibers"] == "2" and row["coordinate"] == "elbow.angle"
    assert abs(a - 0.020) < 1e-8 and abs(b - 0.022) < 1e-8 and abs(float(row["sd"]) - 0.002 / math.sqrt(2)) < 1e-8
    assert row["lower"] == fiber[1] and row["upper"] == fiber[2] and abs(float(row["up"]) - float(row["down"])) < 1e-8
d = json.load(open("r.json"))
assert [s["way"] for s in d["sweeps"]] == ["up", "down"] and d["sweeps"][0]["lastRow"] == 40
m = d["muscles"][0]
assert m["fibers"] == 2 and m["others"] == "alone" and m["residual"] < 1e-9 and m["hysteresis"]["greatest"] < 1e-8
END
    moment-arm -q --coordinate elbow.angle strap.tsv -o a.sto --fibers f.sto
    [ "$(sed -n '/^nRows/p; /^nColumns/p; /^time/p' a.sto | tr '\n' ' ')" = "nRows=81 nColumns=3 time	elbow.angle	strap " ]
    [ "$(sed -n '/^time/p' f.sto)" = "time	elbow.angle	strap.1	strap.2" ]
    [ "$(sed '1,/^time/d' a.sto | awk -F '\t' '$3 > 0.02099 && $3 < 0.02101' | wc -l)" -eq 81 ]
    /usr/bin/python3 -c 'import jsonschema' 2> /dev/null || skip "python3-jsonschema is not installed"
    valid moment-arm r.json
}

@test "a simulated strap over a cylinder bone: its arm is the radius and half of its thickness, within 2 %" {
    for radius in 0.02 0.03; do
        "$here/write-strap" $radius 0.004 30
        attach-detect -q strap.off --units m --pin humerus=indices:"$(cat first)" --pin elbow=indices:"$(cat last)" | root-select -q |
            build-structure | fiber-flow | fiber-fill -n 12 --segments 120 -o strap.muscle.json
        scene-build -q strap.muscle.json --motion turn.motion.json --bone humerus=cylinder.off --bone elbow=end.off --contact \
            --set 'strap.restLength=0.8' -o strap.scene.json
        simulate -q strap.scene.json --lengths l.tsv > log.jsonl
        moment-arm --coordinate elbow l.tsv -o a.tsv --report r.json
        # the turn draws the strap out: longer as the angle grows
        within a.tsv "$(awk "BEGIN { print -1.02 * ($radius + 0.002) }")" "$(awk "BEGIN { print -0.98 * ($radius + 0.002) }")"
        [ "$(member r.json 'd["muscles"][0]["hysteresis"]["greatestOfLargest"] < 0.01')" = true ]
        [ "$(member r.json 'd["muscles"][0]["fibers"]')" -eq 12 ]
    done
}

@test "the page tells every member of the report that the schema has" {
    python3 - "$share/schema/moment-arm.schema.json" "$share/man/moment-arm.1" << 'END'
import json, re, sys
def names(node):
    if isinstance(node, dict):
        for key, value in node.items():
            if key == "properties": yield from value
            yield from names(value)
    elif isinstance(node, list):
        for value in node: yield from names(value)
page = open(sys.argv[2]).read()
page = page[page.index(".Sh THE REPORT"):page.index(".Sh EXIT STATUS")]
told = set(re.findall(r"[A-Za-z]+", " ".join(line for line in page.split("\n") if re.match(r"\.(Cm|It|Pq) ?", line))))
missing = set(names(json.load(open(sys.argv[1])))) - told - {"format"}
assert not missing, missing
END
}

@test "a pipe and a file give the same bytes, and so does a second run" {
    moment-arm -q --coordinate elbow strap.tsv > a.tsv
    moment-arm -q --coordinate elbow - < strap.tsv | cmp - a.tsv
    moment-arm -q --coordinate elbow < strap.tsv | cmp - a.tsv
    run -1 sh -c "moment-arm -q --coordinate elbow strap.tsv > /dev/full"
}

@test "OpenSim's lengths over its coordinates: the derivative of the model's geometry, for muscles that cross one joint" {
    [ -d "$gait" ] || skip "no gait1018-opensim in DATA"
    for side in r l; do
        moment-arm -q --coordinate ankle_angle_$side --motion "$walk" "$lengths" --muscles soleus_$side --muscles tib_ant_$side -o ankle.tsv --report r.json
        python3 "$here/model-arms.py" arms "$model" ankle.tsv 1e-4
        [ "$(member r.json '[m["others"] for m in d["muscles"]]')" = '["alone", "alone"]' ]
        [ "$(wc -l < ankle.tsv)" -eq 183 ]
        moment-arm -q --coordinate /jointset/knee_$side/knee_angle_$side/value --motion "$walk" "$lengths" --muscles bifemsh_$side -o knee.tsv
        python3 "$here/model-arms.py" arms "$model" knee.tsv 1e-4
    done
    # degrees taken for radians would be seen, and so would the other sign
    awk -F '\t' -v OFS='\t' 'NR > 1 { $4 *= 57.3 } { print }' knee.tsv > wrong.tsv
    run -1 python3 "$here/model-arms.py" arms "$model" wrong.tsv 1e-4
    awk -F '\t' -v OFS='\t' 'NR > 1 { $4 = -$4 } { print }' knee.tsv > wrong.tsv
    run -1 python3 "$here/model-arms.py" arms "$model" wrong.tsv 1e-4
}

@test "a walk moves all joints: muscles that cross another one have no moment arm, and that is said" {
    [ -d "$gait" ] || skip "no gait1018-opensim in DATA"
    code=0
    moment-arm --coordinate knee_angle_r --motion "$walk" "$lengths" -o a.tsv --report r.json 2> err || code=$?
    [ "$code" -eq 3 ]
    grep -q '16 of 18 muscles have no moment arm here but a derivative along the motion, "hamstrings_r" first: "' err
    [ "$(member r.json 'sorted(m["name"] for m in d["muscles"] if m["others"] == "alone")')" = '["bifemsh_r", "vasti_r"]' ]
    [ "$(member r.json 'len(d["otherCoordinates"])')" -eq 9 ]
    moment-arm --coordinate knee_angle_r --motion "$walk" "$lengths" -o b.tsv --total 2> err
    refute grep -q "no moment arm" err
    cmp a.tsv b.tsv
}

@test "a tube around the soleus of that model, moved by its ankle, follows the line's arm within 10 %" {
    [ -d "$gait" ] || skip "no gait1018-opensim in DATA"
    python3 -c '
from math import *
print("ankle\nversion=1\nnRows=97\nnColumns=2\ninDegrees=yes\n\nendheader\ntime\tankle_angle_r")
for k in range(97): print(k / 24, 2.5 - 20 * cos(pi * k / 24), sep="\t")' > ankle.mot
    motion-import -q --skeleton "$model" ankle.mot -o ankle.motion.json
    python3 "$here/model-arms.py" tube "$model" soleus_r 0.01 > tube.off
    rings=$(awk 'NR == 2 { print ($1 - 2) / 16 }' tube.off)
    top=$(seq -s , 0 15),$((16 * rings)) bottom=$(seq -s , $((16 * rings - 16)) $((16 * rings - 1))),$((16 * rings + 1))
    attach-detect -q tube.off --units m --pin tibia_r=indices:"$top" --pin calcn_r=indices:"$bottom" | root-select -q | build-structure |
        fiber-flow | fiber-fill -n 20 -o tube.muscle.json
    printf 'OFF\n4 4 6\n0 0 0\n.01 0 0\n0 .01 0\n0 0 .01\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' > bone.off
    arms() { # SET...: simulate with it, and how far the arms are from the line's
        scene-build -q tube.muscle.json --motion ankle.motion.json --bone tibia_r=bone.off --bone calcn_r=bone.off "$@" -o tube.scene.json
        simulate -q tube.scene.json --lengths l.tsv > log.jsonl
        moment-arm --coordinate ankle_angle_r l.tsv -o t.tsv --report r.json
        python3 "$here/model-arms.py" share "$model" t.tsv soleus_r 0.1
    }
    arms --set 'tube.restLength=0.8'
    [ "$(member r.json '[d["coordinate"]["name"], len(d["sweeps"]), d["muscles"][0]["fibers"], d["muscles"][0]["others"]]')" = \
        '["ankle_angle_r.rad", 4, 20, "alone"]' ]
    # by the motion document instead of the table's own column: the same
    moment-arm -q --coordinate ankle_angle_r --motion ankle.motion.json l.tsv -o m.tsv
    cut -f 1,3- t.tsv > a
    cut -f 1,3- m.tsv | cmp - a
    # without, it buckles where the foot points down: no line's arm
    run -1 arms
    [[ "$output" == *"% of the line's arm"* ]]
}

@test "units of coordinates: degrees, radians; what nobody tells is asked for, what cannot be is refused" {
    table 'time theta s' 80 '(t, a, 0.2 - 0.02 * q)' > plain.tsv
    run -1 moment-arm --coordinate theta plain.tsv
    [[ "$output" == *'plain.tsv: nothing tells the unit of "theta"; say --unit degrees, radians or m'* ]]
    moment-arm -q --coordinate theta --unit degrees plain.tsv -o a.tsv
    within a.tsv 0.019999 0.020001
    sed '1s/theta/theta.rad/' plain.tsv > rad.tsv # degrees under the name of radians
    moment-arm --coordinate theta rad.tsv -o none.tsv 2> err
    grep -q 'moves by 40 radians, more than a full turn: are these degrees?' err
    run -2 moment-arm --coordinate theta --unit degrees rad.tsv
    [[ "$output" == *'"theta.rad" is in radians, not in degrees'* ]]
    storage plain.tsv nRows=81 inDegrees=no > no.sto
    run -1 moment-arm --coordinate theta no.sto
    [[ "$output" == *'moves by 40 radians, more than a full turn: if these are degrees, say --unit degrees'* ]]
    storage plain.tsv inDegrees=yes > yes.sto
    moment-arm -q --coordinate theta yes.sto -o b.tsv
    cmp a.tsv b.tsv
    storage plain.tsv > silent.sto
    run -1 moment-arm --coordinate theta silent.sto
    [[ "$output" == *"nothing tells the unit"* ]]
    # radians under a header of degrees: a small range, and an arm of more than a metre
    table 'time theta s' 80 '(t, 2 * q, 0.3 - 0.02 * 2 * q)' > radians.tsv
    sed '1s/theta/theta.rad/' radians.tsv > named.tsv
    moment-arm -q --coordinate theta named.tsv -o c.tsv
    within c.tsv 0.019999 0.020001
    storage radians.tsv inDegrees=yes > lies.sto
    moment-arm --coordinate theta lies.sto -o d.tsv 2> err
    grep -q '"theta" moves by 1.4 degrees in all; if these are radians, say --unit radians' err
    grep -q 'has an arm of 1.15 m: are the lengths in mm (--length-unit), or is the coordinate in radians (--unit)?' err
}

@test "lengths in millimetres, and coordinates that are ways" {
    table 'time theta.angle s' 80 '(t, a, 200 - 20 * q)' > mm.tsv
    run -1 moment-arm --coordinate theta.angle mm.tsv
    [[ "$output" == *'"s" is 200 m long: if these are millimetres, say --length-unit mm'* ]]
    moment-arm -q --coordinate theta --length-unit mm mm.tsv -o e.tsv
    within e.tsv 0.019999 0.020001
    table 'time pelvis_tx s.1' 80 '(t, a / 1000, 0.2 - 0.5 * a / 1000)' > way.tsv
    storage way.tsv inDegrees=yes > way.sto
    run -1 moment-arm --coordinate pelvis_tx way.sto
    [[ "$output" == *'"pelvis_tx" may be a way, as OpenSim calls them so; say --unit m, or --unit degrees'* ]]
    moment-arm --coordinate pelvis_tx --unit m way.sto -o f.tsv 2> err
    grep -q 'is a way, so that arms have no unit' err
    within f.tsv 0.49999 0.50001
    [ "$(head -n 1 f.tsv | cut -f 3)" = position ]
    sed '1s/pelvis_tx/pelvis_tx.m/' way.tsv > named.tsv
    moment-arm -q --coordinate pelvis_tx named.tsv | cut -f 4 > arms
    cut -f 4 f.tsv | cmp - arms
    printf 'muscle\tposition\tarm\ns\t0.01\t0.5\ns\t0.02\t0.6\n' > m.tsv
    moment-arm -q --coordinate pelvis_tx named.tsv --against m.tsv > c.tsv
    [ "$(awk -F '\t' 'NR == 2 { print $2, $4, $5, sprintf("%.4f %.4f", $6, $7), $10 }' c.tsv)" = "2 0.01 0.02 0.0707 -0.0500 100" ]
}

@test "only lengths are taken for lengths" {
    table 'time elbow.angle wrist.rad x.m force a.1 a.2' 80 '(t, a, 0.1, 0.5, 100.0, 0.2 - 0.02 * q, 0.2 - 0.02 * q)' > t.tsv
    moment-arm -q --coordinate elbow t.tsv --report r.json -o a.tsv
    [ "$(member r.json '[[m["name"], m["fibers"]] for m in d["muscles"]]')" = '[["a", 2]]' ]
    [ "$(moment-arm --list t.tsv | cut -f 3 | tr '\n' ' ')" = "coordinate coordinate coordinate plain length length " ]
    # no name says so
    table 'time elbow.angle a b knee' 80 '(t, a, 0.2 - 0.02 * q, 0.3, -0.1)' > t.tsv
    moment-arm --coordinate elbow t.tsv --report r.json -o a.tsv 2> err
    grep -q 't.tsv: no name of a column says that it is a length (NAME.1, PATH|length); taken for lengths: the 2 that are positive' err
    grep -q 't.tsv: 1 columns are no lengths, as they have numbers that are not positive: "knee"' err
    [ "$(member r.json '[m["name"] for m in d["muscles"]]')" = '["a", "b"]' ]
    # activations look like lengths, but for what they do
    table 'time elbow.angle a' 80 '(t, a, 0.01 + 0.9 * t)' > t.tsv
    moment-arm --coordinate elbow t.tsv -o a.tsv 2> err
    grep -q 'a fibre of "a" changes its length by a factor of 91: is that a length?' err
    table 'time elbow.angle a.1' 80 '(t, a, 0.2 if k != 7 else 0.0)' > t.tsv
    run -1 moment-arm --coordinate elbow t.tsv
    [[ "$output" == *'"a.1" is no length: 0 in row 8'* ]]
    table 'time elbow.angle' 80 '(t, a)' > t.tsv
    run -1 moment-arm --coordinate elbow t.tsv
    [[ "$output" == *"no column holds lengths"* ]]
    run -1 moment-arm --coordinate elbow strap.tsv --muscles 'bic*'
    [[ "$output" == *"--muscles: nothing is called \"bic*\""* ]]
    # muscles that are not wanted are no other coordinates
    table 'time elbow.angle a.1 b.1' 80 '(t, a, 0.2 - 0.02 * q, 0.3 + 0.05 * sin(30 * t))' > t.tsv
    moment-arm -q --coordinate elbow t.tsv --muscles a -o a.tsv --report r.json
    [ "$(member r.json 'd["otherCoordinates"]')" = '[]' ]
}

@test "a motion is matched by time: resampled, not extrapolated, and gaps are left out" {
    table 'time s.1' 240 '(t, 0.2 - 0.02 * q)' > s.tsv
    table 'time elbow.angle' 60 '(t, a)' > m.tsv # a quarter of the rate; straight lines between turns
    moment-arm -q --coordinate elbow --motion m.tsv s.tsv -o a.tsv --report r.json
    within a.tsv 0.019999 0.020001
    [ "$(member r.json '[d["coordinate"][n] for n in ("rows", "unusedRows", "interpolatedRows")]')" = '[241, 0, 180]' ]
    awk 'NR == 1 || ($1 > 0.2 && $1 < 0.9)' m.tsv > part.tsv
    moment-arm --coordinate elbow --motion part.tsv s.tsv -o a.tsv 2> err
    within a.tsv 0.019999 0.020001
    grep -q 's.tsv: [0-9]* of 241 rows are not used, as "elbow.angle" has no value there (before, behind or in a gap of the motion' err
    awk -F '\t' 'NR > 1 { print $1 + 10 "\t" $2 } NR == 1' s.tsv > late.tsv
    run -1 moment-arm --coordinate elbow --motion m.tsv late.tsv
    [[ "$output" == *"no row has both a coordinate and lengths"* ]]
    awk 'NR == 1 || $1 < 0.3 || $1 > 0.7' m.tsv > gap.tsv
    moment-arm --coordinate elbow --motion gap.tsv s.tsv -o a.tsv --report r.json 2> err
    [ "$(member r.json 'd["coordinate"]["unusedRows"] > 80 and d["coordinate"]["greatest"] < 25')" = true ]
    cut -f 2- s.tsv > timeless.tsv
    run -1 moment-arm --coordinate elbow --motion m.tsv timeless.tsv
    [[ "$output" == *"timeless.tsv: the first column must be the time, as --motion is matched by it"* ]]
    cut -f 2- strap.tsv > timeless.tsv
    moment-arm -q --coordinate elbow strap.tsv > a.tsv
    moment-arm -q --coordinate elbow timeless.tsv | cmp - a.tsv
    run -1 moment-arm --coordinate elbow timeless.tsv -o a.sto
    [[ "$output" == *"a storage file is by time"* ]]
    # a hinge of a motion document, by its joint
    echo '{"format": "sinew-motion", "version": 1, "rate": 24, "joints": [{"name": "ulna", "type": "hinge", "axis": [0, 1, 0], "point": [0, 0, 0], "keys": [[0, 0], [0.5, 40], [1, 0]]}]}' > h.motion.json
    moment-arm -q --coordinate ulna --motion h.motion.json s.tsv -o a.tsv
    within a.tsv 0.019999 0.020001
}

@test "angles without rows have no arm; too little motion, too few rows and too many knots are refused" {
    table 'elbow.angle s.1' 80 '(a + (20 if a > 20 else 0), 0.2 - 0.02 * radians(a + (20 if a > 20 else 0)))' > t.tsv
    moment-arm --coordinate elbow t.tsv -o a.tsv 2> err
    grep -q 'no row has elbow.angle from 20 to 41 degrees: no arms are told in such gaps, [0-9]* of 91 angles' err
    awk -F '\t' 'NR > 1 { inside = $3 > 20 && $3 < 41; if (inside != ($4 == "NaN")) bad = 1; n += inside } END { exit bad || n < 20 }' a.tsv
    table 'elbow.angle s.1' 80 '(0.02 * a, 0.2)' > t.tsv
    run -1 moment-arm --coordinate elbow t.tsv
    [[ "$output" == "moment-arm: t.tsv: the coordinate moves by 0.8 degrees in all, and an arm needs 1 degrees" ]]
    table 'elbow.angle s.1' 12 '(a, 0.2 - 0.02 * q)' > t.tsv
    run -1 moment-arm --coordinate elbow t.tsv
    [[ "$output" == *"takes 7 different values, and a fit needs 8"* ]]
    run -1 moment-arm --coordinate elbow strap.tsv --knots 40
    [[ "$output" == *"40 knots need 78 different values of the coordinate, and it takes 41; ask for fewer"* ]]
    moment-arm -q --coordinate elbow strap.tsv --knots 6 --samples 5 -o a.tsv --report r.json
    [ "$(member r.json 'd["muscles"][0]["knots"]')" -eq 6 ]
    [ "$(wc -l < a.tsv)" -eq 6 ]
    within a.tsv 0.020999 0.021001
    for words in "--knots 1" "--knots 42" "--samples 1"; do
        # shellcheck disable=SC2086
        run -2 moment-arm --coordinate elbow strap.tsv $words
    done
}

@test "missing lengths are left out of their fibre's fit, and counted" {
    table 'time elbow.angle s.1 s.2' 80 '(t, a, "" if k % 5 == 2 else 0.2 - 0.02 * q, "nan" if 10 < k < 30 else 0.2 - 0.02 * q)' > t.tsv
    moment-arm --coordinate elbow t.tsv -o a.tsv --report r.json 2> err
    within a.tsv 0.019999 0.020001
    grep -q 't.tsv: 35 lengths are missing; each fibre is fitted to those that it has' err
    [ "$(member r.json 'd["muscles"][0]["missingLengths"]')" -eq 35 ]
    table 'time elbow.angle s.1' 80 '(t, a, "nan")' > t.tsv
    run -1 moment-arm --coordinate elbow t.tsv
    [[ "$output" == *'"s.1" has no number at all'* ]]
    table 'time elbow.angle s.1' 80 '(t, "nan" if k == 5 else a, 0.2 - 0.02 * q)' > t.tsv
    moment-arm --coordinate elbow t.tsv -o a.tsv 2> err
    grep -q '1 of 81 rows are not used, as "elbow.angle" has no value there' err
}

@test "noise is told, and what is noise alone is said to be" {
    table 'time elbow.angle s.1' 400 '(t, a, 0.2 - 0.02 * q + 1e-4 * sin(k * k * 7.3))' > t.tsv
    moment-arm --coordinate elbow t.tsv -o a.tsv --report r.json 2> err
    [ "$(member r.json '5e-5 < d["muscles"][0]["residual"] < 9e-5 and 2e-5 < d["muscles"][0]["noise"] < 3e-4')" = true ]
    within a.tsv 0.019 0.021
    refute grep -q warning err
    table 'time elbow.angle s.1' 400 '(t, a, 0.2 + 2e-3 * sin(k * k * 7.3))' > t.tsv
    moment-arm --coordinate elbow t.tsv -o a.tsv 2> err
    grep -q 'the arms of 1 of 1 muscles are noisy: "s" has a standard error of ' err
    grep -q 'the lengths of 1 of 1 muscles are no curve of "elbow.angle": those of "s" are ' err
}

@test "the ways up and down are told apart" {
    table 'time elbow.angle s.1' 80 '(t, a, (0.3 - 0.020 * q if k <= 40 else 0.3 - 0.020 * radians(40) + 0.022 * (radians(40) - q)) - 0.01 * q * q)' > t.tsv
    moment-arm --coordinate elbow t.tsv -o a.tsv --report r.json 2> err
    [ "$(member r.json '[round(d["muscles"][0]["hysteresis"][n], 5) for n in ("greatest", "rms")]')" = '[0.002, 0.002]' ]
    [ "$(member r.json 'abs(d["muscles"][0]["hysteresis"]["greatestOfRange"] - 0.002 / d["muscles"][0]["range"]) < 1e-5')" = true ]
    grep -q "up and down differ by 2 mm at most" err
    awk -F '\t' 'NR > 1 && ($10 - $9 < 0.00199 || $10 - $9 > 0.00201) { bad = 1 } END { exit bad || NR < 92 }' a.tsv
    head -n 42 t.tsv > up.tsv
    moment-arm --coordinate elbow up.tsv -o a.tsv --report r.json 2> err
    [ "$(member r.json 'd["muscles"][0]["hysteresis"]')" = null ]
    grep -q "1 ways up and 0 down: one way alone" err
    [ "$(cut -f 10 a.tsv | sort -u | tr '\n' ' ')" = "NaN down " ]
}

@test "another coordinate that moves along, or by itself" {
    for other in '0.5 * a' '0.5 * a + 20 * sin(200 * t)'; do
        table 'time elbow.angle wrist.angle s.1 both.1' 400 "(t, a, $other, 0.2 - 0.02 * q, 0.2 - 0.02 * q - 0.01 * radians($other))" > t.tsv
        code=0
        moment-arm --coordinate elbow t.tsv -o a.tsv --report r.json 2> err || code=$?
        [ "$code" -eq 3 ]
        member r.json '[m["others"] for m in d["muscles"]]' >> kinds
    done
    [ "$(cat kinds)" = '["alongWithIt", "alongWithIt"]
["alone", "mixed"]' ]
    grep -q '1 of 2 muscles have no moment arm here but a derivative along the motion, "both" first: "wrist" moves too, and may have added' err
    # the same coordinate told twice is none
    table 'time elbow.angle elbow.rad s.1' 80 '(t, a, q, 0.2 - 0.02 * q)' > t.tsv
    moment-arm -q --coordinate elbow.angle t.tsv -o a.tsv --report r.json
    [ "$(member r.json 'd["otherCoordinates"]')" = '[]' ]
    run -1 moment-arm --coordinate elbow t.tsv
    [[ "$output" == *'"elbow" may be "elbow.angle" or "elbow.rad"; write which'* ]]
}

@test "measured curves: overlap, inside, rms, sign; units; what does not fit" {
    printf 'muscle\tcoordinate\tangle\tarm.mm\tsd.mm\nstrap\telbow\t10\t21\t2\nstrap\telbow\t20\t23\t1\nstrap\telbow\t30\t22\t2\nstrap\telbow\t50\t22\t2\nstrap\twrist\t10\t1\t1\nnobody\telbow\t10\t1\t1\n' > m.tsv
    moment-arm --coordinate elbow strap.tsv --against m.tsv --report r.json > c.tsv 2> err
    [ "$(head -n 1 c.tsv)" = "muscle	points	outside	from	to	rms	bias	overlap_percent	inside_percent	sign_percent" ]
    [ "$(wc -l < c.tsv)" -eq 2 ]
    python3 - << 'END'
row = open("c.tsv").read().split("\n")[1].split("\t")
assert row[:3] == ["strap", "3", "1"]
low, high, rms, bias, overlap, inside, sign = map(float, row[3:])
# own band 20 to 22 mm, mean 21; bands 19-23, 22-24, 20-24 mm at weights 1/4, 1/2, 1/4
assert (low, high) == (10, 30) and abs(rms - 1e-3 * (5 / 3) ** 0.5) < 1e-8 and abs(bias + 1e-3) < 1e-8
assert abs(overlap - 100 * (0.25 * 2 + 0 + 0.25 * 2) / (0.25 * 4 + 0.5 * 4 + 0.25 * 4)) < 1e-3, overlap
assert abs(inside - 200 / 3) < 1e-3 and sign == 100
END
    grep -q 'm.tsv: 1 of 2 measured muscles are not in the table of lengths: "nobody"' err
    [ "$(member r.json '[d["against"][0][n] for n in ("muscle", "points", "sign")]')" = '["strap", 3, 1.0]' ] ||
        [ "$(member r.json '[d["against"][0][n] for n in ("muscle", "points", "sign")]')" = '["strap", 3, 1]' ]
    if /usr/bin/python3 -c 'import jsonschema' 2> /dev/null; then valid moment-arm r.json; fi
    # its own output is such a table, and agrees with itself
    moment-arm -q --coordinate elbow strap.tsv -o a.tsv
    moment-arm -q --coordinate elbow strap.tsv --against a.tsv -o b.tsv > c.tsv
    cmp a.tsv b.tsv
    [ "$(awk -F '\t' 'NR == 2 { print $2, $3, ($6 < 1e-12), $8, $9, $10 }' c.tsv)" = "91 0 1 100 100 100" ]
    # no band, no overlap; another sign is said
    printf 'muscle\tangle\tarm\nstrap\t10\t-0.021\nstrap\t20\t-0.021\nstrap\t30\t-0.021\n' > m.tsv
    moment-arm --coordinate elbow strap.tsv --against m.tsv > c.tsv 2> err
    [ "$(awk -F '\t' 'NR == 2 { print $8, $9, $10 }' c.tsv)" = "- - 0" ]
    grep -q '"strap" has the other sign at most angles; an arm is positive here where the muscle shortens as the coordinate grows' err
    printf 'muscle\tangle\tarm\nstrap\t10\t21\n' > m.tsv
    run -1 moment-arm --coordinate elbow strap.tsv --against m.tsv
    [[ "$output" == *"m.tsv:2: an arm of 21 m: is it in mm? Call the column arm.mm, or arm.cm"* ]]
    printf 'muscle\tangle\tarm\nbiceps\t10\t0.021\n' > m.tsv
    run -1 moment-arm --coordinate elbow strap.tsv --against m.tsv
    [[ "$output" == *'none of its muscles is in the table of lengths: "biceps"'* ]]
    run -2 moment-arm --coordinate elbow strap.tsv --against m.tsv -o -
}

@test "mistakes are refused in one sentence" {
    run -2 moment-arm strap.tsv
    [[ "$output" == "moment-arm: --coordinate NAME is missing; see moment-arm --help" ]]
    run -1 moment-arm --coordinate elbwo strap.tsv
    [[ "$output" == 'moment-arm: strap.tsv: there is no coordinate "elbwo"; did you mean "elbow"?' ]]
    run -1 moment-arm --coordinate hip strap.tsv
    [[ "$output" == 'moment-arm: strap.tsv: there is no coordinate "hip", but elbow' ]]
    cut -f 1,3- strap.tsv > none.tsv
    run -1 moment-arm --coordinate hip none.tsv
    [[ "$output" == *"there is no coordinate at all; --motion FILE names where they are"* ]]
    sed '2,$s/\./,/g' strap.tsv > comma.tsv
    run -1 moment-arm --coordinate elbow comma.tsv
    [[ "$output" == "moment-arm: comma.tsv:2: "*"is no number; write decimal points, not commas" ]]
    tr '\t' ',' < comma.tsv > comma.csv
    run -1 moment-arm --coordinate elbow comma.csv
    [[ "$output" == *"where commas are decimal marks, write points" ]]
    tr '\t' ',' < strap.tsv > point.csv
    moment-arm -q --coordinate elbow strap.tsv > a.tsv
    moment-arm -q --coordinate elbow point.csv | cmp - a.tsv
    awk 'NR == 4 { kept = $0; next } { print } NR == 5 { print kept }' strap.tsv > order.tsv
    run -1 moment-arm --coordinate elbow order.tsv
    [[ "$output" == *"order.tsv: the times must ascend, and row 4 is at 0.025 s behind 0.0375 s; sort the rows" ]]
    run -2 moment-arm --coordinate elbow strap.tsv --chart a.pdf
    run -2 moment-arm --coordinate elbow strap.tsv --fibers -
    run -2 moment-arm --coordinate elbow strap.tsv -o a.json
    [ ! -e a.json ]
}

@test "report, trace and stop; the chart" {
    table 'time elbow.angle a.1 b.1' 80 '(t, a, 0.2 - 0.02 * q, 0.3 + 0.01 * q)' > t.tsv
    moment-arm -q --coordinate elbow t.tsv --trace t.jsonl -o a.tsv
    [ "$(wc -l < t.jsonl)" -eq 2 ]
    moment-arm -q --coordinate elbow t.tsv --stop-after 1 -o b.tsv --fibers f.tsv --report r.json
    [ "$(cut -f 1 b.tsv | sort -u | tr '\n' ' ')" = "a muscle " ]
    [ "$(head -n 1 f.tsv)" = "angle	a.1" ]
    [ "$(member r.json '[m["name"] for m in d["muscles"]]')" = '["a"]' ]
    code=0
    PATH=$BIN moment-arm -q --coordinate elbow t.tsv --chart none.svg -o c.tsv 2> err || code=$?
    [ "$code" -eq 3 ]
    grep -q gnuplot err
    cmp a.tsv c.tsv
    command -v gnuplot > /dev/null || skip "gnuplot is not installed"
    printf 'muscle\tangle\tarm\tsd\na\t10\t0.021\t0.001\na\t20\t0.021\t0.001\n' > m.tsv
    moment-arm -q --coordinate elbow t.tsv --chart a.svg --against m.tsv --title 'An "elbow"' > c.tsv 2> err
    moment-arm -q --coordinate elbow t.tsv --chart a.png -o c.tsv 2>> err
    [ ! -s err ]
    grep -q 'An "elbow"\|An &quot;elbow&quot;' a.svg
    grep -q 'a, 1 fibre' a.svg
    grep -q 'measured' a.svg
    [ "$(head -c 4 a.png | tail -c 3)" = PNG ]
}

@test "fibres keep the names of their columns, and two columns of one name are refused" {
    { printf 'time\telbow.angle\tbic.2\tbic.7\tbic.long.3\n'
      for i in 1 2 3 4 5 6 7 8 9 10 11 12; do printf '%s\t%s\t0.2%02d\t0.3%02d\t0.25%02d\n' $i $((5 * i)) $i $i $i; done; } > gaps.tsv
    "$BIN/moment-arm" -q gaps.tsv --coordinate elbow.angle --fibers each.tsv -o all.tsv
    [ "$(head -1 each.tsv | cut -f2-)" = "$(printf 'bic.2\tbic.7\tbic.long.3')" ]
    sed 's/bic\.7/bic.2/' gaps.tsv > twice.tsv
    run -1 "$BIN/moment-arm" twice.tsv --coordinate elbow.angle
    [[ $output == *'twice.tsv:1: two columns are called "bic.2"'* ]]
    sed 's/bic\.7/elbow.angle/' gaps.tsv > twice.tsv
    run -1 "$BIN/moment-arm" twice.tsv --coordinate elbow.angle
    [[ $output == *'two columns are called "elbow.angle"'* ]]
}
