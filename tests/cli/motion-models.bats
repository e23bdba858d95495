# motion-import on models: OpenSim's, alone and moved by MOT and STO, and MuJoCo's.

bats_require_minimum_version 1.5.0

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    import="$BIN/motion-import"
    walk="$DATA/gait-opensim/motion/subject01_walk1_ik.mot"
    model="$DATA/gait-opensim/motion/subject01_simbody_adjusted.osim"
    dog="$DATA/dog-dmcontrol/dog.xml"
    # a body on a slider, in the ground's axes: x forwards, y up
    cat > slide.osim <<'END'
<OpenSimDocument Version="40000"><Model name="slide"><Ground name="ground"/>
<BodySet><objects><Body name="block"/></objects></BodySet>
<JointSet><objects><SliderJoint name="rail"><socket_parent_frame>ground_offset</socket_parent_frame>
<socket_child_frame>/bodyset/block</socket_child_frame>
<coordinates><Coordinate name="way"><default_value>0.5</default_value></Coordinate></coordinates>
<frames><PhysicalOffsetFrame name="ground_offset"><socket_parent>/ground</socket_parent><translation>0 1 0</translation>
<orientation>0 0 0</orientation></PhysicalOffsetFrame></frames></SliderJoint></objects></JointSet></Model></OpenSimDocument>
END
    printf 'slide\nnRows=2\nnColumns=2\ninDegrees=yes\nendheader\ntime\tway\n1\t0.5\n1.5\t0.75\n' > slide.mot
}

# Run with a status of 1 and exactly one line on stderr that matches $1.
refused() {
    local pattern=$1 code=0
    shift
    "$@" > out 2> err || code=$?
    [ "$code" -eq 1 ] && [ ! -s out ] && [ "$(wc -l < err)" -eq 1 ] || { cat err; return 1; }
    grep -Eq "^motion-import: $pattern" err || { cat err; return 1; }
}

@test "a motion moves its model: metres, z up, frames from the times" {
    "$import" slide.mot --skeleton slide.osim --list > list
    grep -qP '^format\tMOT$' list
    grep -qP '^frames\t2$' list
    grep -qP '^rate\t2$' list
    # at rest at (0.5, 1, 0) of the file: z is up in ours
    grep -qP '^joint\t1\tblock\t-\t0.5\t0\t1$' list
    grep -qP '^coordinate\t1\tway\tm\t0.5\t0.75$' list
    "$import" slide.mot --skeleton slide.osim -o slide.motion.json
    python3 -c '
import json
joint = json.load(open("slide.motion.json"))["joints"][0]
assert joint["keys"][0].get("translation", [0, 0, 0]) == [0, 0, 0], joint
assert joint["keys"][1]["translation"] == [0.25, 0, 0], joint'
}

@test "a model alone is one frame at rest; units scale it; --up leaves its axes" {
    "$import" --list slide.osim > list
    grep -qP '^format\tOSIM$' list
    grep -qP '^frames\t1$' list
    grep -qP '^joint\t1\tblock\t-\t0.5\t0\t1$' list
    "$import" --list --units cm --up z slide.osim > list
    grep -qP '^joint\t1\tblock\t-\t0.005\t0.01\t0$' list
    grep -qP '^coordinate\t1\tway\tm\t0.005\t0.005$' list
}

@test "a motion moves a model of MuJoCo's, which is z up" {
    printf '<mujoco><worldbody><body name="leg" pos="0 0 1"><joint name="hip" axis="0 1 0"/></body></worldbody></mujoco>' > leg.xml
    printf 'leg\ninDegrees=yes\nendheader\ntime\thip\n0\t0\n0.1\t30\n' > leg.sto
    "$import" --list leg.xml | grep -qP '^joint\t1\tleg\t-\t0\t0\t1$'
    "$import" leg.sto --skeleton leg.xml --list > list
    grep -qP '^joint\t1\tleg\t-\t0\t0\t1$' list
    grep -qP '^coordinate\t1\thip\trad\t0\t0.52359877559' list
}

@test "columns that the model lacks: one warning, and what is there moves" {
    printf 'm\nendheader\ntime\tway\tforce\tactivation\n0\t1\t2\t3\n' > more.sto
    "$import" more.sto --skeleton slide.osim -o out.json 2> err
    [ "$(wc -l < err)" -eq 1 ]
    grep -q '2 of 3 columns are no coordinates of the model and are left out: force, activation' err
}

@test "broken files, and files in the wrong place, are refused with their line" {
    refused 'slide.mot: tells no skeleton; name its model' "$import" slide.mot
    refused 'slide.osim: has its skeleton in it' "$import" slide.osim --skeleton slide.osim
    sed 's/nRows=2/nRows=3/' slide.mot > short.mot
    refused 'short.mot:8: there are 2 rows and the header says nRows=3' "$import" short.mot --skeleton slide.osim
    sed 's/0.75/x/' slide.mot > word.mot
    refused 'word.mot:8: column "way": "x" is no number' "$import" word.mot --skeleton slide.osim
    sed 's/SliderJoint/EllipsoidJoint/g' slide.osim > other.osim
    refused 'other.osim:3: a joint of the kind EllipsoidJoint is not read' "$import" other.osim
    refused 'other.osim:3: ' "$import" slide.mot --skeleton other.osim
    head -c 300 slide.osim > cut.osim
    refused 'cut.osim:[0-9]+: the XML is broken' "$import" cut.osim
}

@test "a walk of gait-opensim" {
    [ -f "$walk" ] || skip "no gait-opensim in DATA"
    "$import" "$walk" --skeleton "$model" --list > list
    grep -qP '^frames\t211$' list
    grep -qP '^rate\t60$' list
    [ "$(grep -cP '^joint\t' list)" -eq 12 ]
    [ "$(grep -cP '^coordinate\t' list)" -eq 23 ]
    "$import" "$walk" --skeleton "$model" -o first.json
    "$import" "$walk" --skeleton "$model" -o again.json
    cmp first.json again.json
}

@test "the dog at rest" {
    [ -f "$dog" ] || skip "no dog-dmcontrol in DATA"
    "$import" "$dog" --list > list 2> err
    [ "$(grep -cP '^joint\t' list)" -eq 62 ]
    # its head is in front (x), its tail behind, and it stands on the ground
    awk -F'\t' '$1 == "joint" && $3 == "skull" { if ($5 < 0.2 || $7 < 0.5) exit 1 } $1 == "joint" && $3 == "toe_L" { if ($7 < 0 || $7 > 0.1) exit 1 }' list
    [ "$(wc -l < err)" -eq 1 ]
    grep -q 'includes are not read' err
}
