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

# A model of two bodies, the second 0.5 m above the first, with meshes: a right-handed tetrahedron of volume 1/6 for what is asked.
# meshed MESHES_OF_BLOCK [MESHES_OF_LID]
meshed() {
    mkdir -p Geometry
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' > Geometry/tetra.obj
    printf '<OpenSimDocument Version="40000"><Model name="m"><Ground name="ground"/><BodySet><objects><Body name="block">
<attached_geometry>%s</attached_geometry></Body><Body name="lid"><attached_geometry>%s</attached_geometry></Body></objects></BodySet>
<JointSet><objects><SliderJoint name="rail"><socket_parent_frame>g</socket_parent_frame><socket_child_frame>/bodyset/block</socket_child_frame>
<coordinates><Coordinate name="way"><default_value>0.5</default_value></Coordinate></coordinates><frames><PhysicalOffsetFrame name="g">
<socket_parent>/ground</socket_parent><translation>0 1 0</translation><orientation>0 0 0</orientation></PhysicalOffsetFrame></frames></SliderJoint>
<PinJoint name="hinge"><socket_parent_frame>b</socket_parent_frame><socket_child_frame>/bodyset/lid</socket_child_frame>
<coordinates><Coordinate name="lift"/></coordinates><frames><PhysicalOffsetFrame name="b"><socket_parent>/bodyset/block</socket_parent>
<translation>0 0.5 0</translation><orientation>0 0 0</orientation></PhysicalOffsetFrame></frames></PinJoint></objects></JointSet></Model>
</OpenSimDocument>' "$1" "${2:-}" > meshed.osim
}

# mesh FILE SCALE: a mesh of the body itself, called as OpenSim calls them
mesh() { printf '<Mesh name="body_geom_1"><socket_frame>..</socket_frame><scale_factors>%s</scale_factors><mesh_file>%s</mesh_file></Mesh>' "$2" "$1"; }

# Vertices and signed volume of a PLY file of motion-import's.
ply() {
    python3 - "$1" << 'END'
import struct, sys
data = open(sys.argv[1], "rb").read()
head, body = data.split(b"end_header\n", 1)
n, m = (int(l.split()[2]) for l in head.decode().split("\n") if l.startswith("element"))
p = [struct.unpack_from("<3d", body, 24 * i) for i in range(n)]
t = [struct.unpack_from("<3i", body, 24 * n + 13 * i + 1) for i in range(m)]
det = lambda a, b, c: a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
print([[round(c, 12) + 0.0 for c in q] for q in p], round(sum(det(*(p[i] for i in f)) for f in t) / 6, 12))
END
}

@test "--bones: the model's meshes in its rest pose, metres, z up, each file beside the model or in Geometry" {
    meshed "$(mesh tetra.obj '1 1 1')" "$(mesh 'C:\models\tetra.obj' '2 2 -2')"
    printf 'm\ninDegrees=yes\nendheader\ntime\tway\tlift\n0\t0.5\t0\n0.5\t0.5\t90\n' > meshed.mot
    "$import" meshed.mot --skeleton meshed.osim --bones bones -o meshed.motion.json
    # (x, y, z) of the file are (x, -z, y) of ours; the block is at (0.5, 0, 1), the lid at (0.5, 0, 1.5)
    [ "$(ply bones/tetra.ply)" = '[[0.5, 0.0, 1.0], [1.5, 0.0, 1.0], [0.5, 0.0, 2.0], [0.5, -1.0, 1.0]] 0.166666666667' ]
    # twice as large and mirrored, with its outside still outside
    [ "$(ply bones/tetra_2.ply)" = '[[0.5, 0.0, 1.5], [2.5, 0.0, 1.5], [0.5, 0.0, 3.5], [0.5, 2.0, 1.5]] 1.333333333333' ]
    [ "$(python3 -c 'import json; print(json.load(open("meshed.motion.json"))["bones"])')" = \
        "[{'name': 'tetra', 'mesh': 'bones/tetra.ply', 'units': 1, 'joint': 'block'}, {'name': 'tetra_2', 'mesh': 'bones/tetra_2.ply', 'units': 1, 'joint': 'lid'}]" ]
    # the same bytes again, with a slash behind the folder; a document keeps its bones, named from where it is
    mkdir -p other/deep
    "$import" meshed.mot --skeleton meshed.osim --bones other/bones/ -o other/deep/m.json --report report.json
    cmp bones/tetra_2.ply other/bones/tetra_2.ply
    grep -q '"mesh": *"../bones/tetra_2.ply"' other/deep/m.json
    python3 -c 'import json; r = json.load(open("report.json")); assert (r["bones"], r["bonesMissing"]) == (2, 0), r'
    "$import" other/deep/m.json --rate 10 | grep -q '"mesh": *"other/deep/../bones/tetra.ply"'
    # in cm, and z up as it is
    "$import" meshed.osim --units cm --up z --bones cm -o cm.json
    [ "$(ply cm/tetra.ply)" = '[[0.005, 0.01, 0.0], [0.015, 0.01, 0.0], [0.005, 0.02, 0.0], [0.005, 0.01, 0.01]] 1.66667e-07' ]
}

@test "--bones: what is not there is said once, with its number; nothing there is an error" {
    meshed "$(mesh tetra.obj '1 1 1')$(mesh tetra.obj '1 1 1')$(mesh gone.vtp '1 1 1')" "$(mesh gone.stl '1 1 1')"
    "$import" meshed.osim --bones bones -o m.json 2> err
    [ "$(cat err)" = "motion-import: warning: meshed.osim: 2 of the model's 3 mesh files are not there and are left out, the first is gone.vtp" ]
    [ "$(ls bones)" = tetra.ply ]
    mkdir else
    mv Geometry/tetra.obj else
    refused "meshed.osim: none of the model's 3 mesh files is there, the first is tetra.obj" "$import" meshed.osim --bones never
    "$import" meshed.osim --bones far --bone-path nowhere --bone-path else -o m.json -q
    cmp far/tetra.ply bones/tetra.ply
    printf 'v 0 0 0\nf 1 2 3\n' > else/tetra.obj
    refused 'else/tetra.obj' "$import" meshed.osim --bones broken --bone-path else -q
    refused 'slide.osim: the model names no mesh file' "$import" slide.osim --bones never
    meshed "$(mesh tetra.obj '1 0 1')"
    refused 'meshed.osim: the mesh "tetra.obj" has a scale of 0' "$import" meshed.osim --bones never
    printf 'HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 1\nFrame Time: 1\n0\n' > a.bvh
    refused 'a.bvh: has no meshes of bones: BVH is no model' "$import" a.bvh --bones never
    [ ! -e never ]
    touch file
    meshed "$(mesh tetra.obj '1 1 1')"
    refused 'file: cannot make this folder' "$import" meshed.osim --bones file
    run -2 "$import" meshed.osim --bone-path else
}

@test "--bones: MuJoCo's meshes by their geoms' names, each once, those that show a body" {
    mkdir m
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' > m/shin.obj
    printf '<mujoco><compiler meshdir="m"/><asset><mesh file="shin.obj" scale="0.1 0.1 0.1"/></asset><worldbody><body name="leg" pos="0 0 1">
<geom name="../shin" type="mesh" mesh="shin" pos="1 0 0"/><geom type="mesh" mesh="shin" pos="1 0 0"/><geom type="mesh" mesh="shin"/>
<geom type="capsule" mesh="shin"/><joint name="hip"/></body></worldbody></mujoco>' > leg.xml
    "$import" leg.xml --bones bones -o leg.json
    [ "$(ls -A bones | LC_ALL=C sort | tr '\n' ' ')" = '_._shin.ply shin.ply ' ]
    [ "$(ply bones/shin.ply)" = '[[0.0, 0.0, 1.0], [0.1, 0.0, 1.0], [0.0, 0.1, 1.0], [0.0, 0.0, 1.1]] 0.000166666667' ]
}

@test "a walk and a run of gait-opensim with the model's own bones, against an independent computation" {
    [ -f "$walk" ] || skip "no gait-opensim in DATA"
    for motion in "$walk" "$DATA/gait-opensim/motion/subject02_running_ik.mot"; do
        "$import" "$motion" --skeleton "$model" --bones bones --bone-path "$DATA/gait-opensim/meshes" -q -o m.json
        python3 "$BATS_TEST_DIRNAME/../model-fk.py" bones "$model" "$motion" m.json "$DATA/gait-opensim/meshes"
    done
}

@test "the dog's own bones, against an independent computation" {
    [ -f "$dog" ] || skip "no dog-dmcontrol in DATA"
    "$import" "$dog" --bones bones --bone-path "$DATA/dog-dmcontrol/meshes" -q -o dog.json
    [ "$(ls bones | wc -l)" -eq 162 ]
    python3 "$BATS_TEST_DIRNAME/../model-fk.py" bones "$dog" - dog.json "$DATA/dog-dmcontrol/meshes"
}
