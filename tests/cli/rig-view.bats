# rig-view: what it takes, what it writes, what it refuses.

bats_require_minimum_version 1.5.0

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    printf 'OFF\n4 4 6\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' > tetra.off
    "$BIN/mesh-clean" tetra.off --no-history -o tetra.muscle.json
    cat > one.scene.json << 'END'
{ "format": "sinew-scene", "version": 1, "name": "one", "frames": [0, 3], "bones": [ { "name": "bone", "mesh": "tetra.off" } ],
  "muscles": [ { "name": "tetra", "rig": "tetra.muscle.json", "activation": 0.5 } ] }
END
}

# width and height of a PNG, from its header
png_size() {
    [ "$(head -c 8 "$1" | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ]
    od -An -j16 -N8 -tu1 "$1" | awk '{ print (($1*256+$2)*256+$3)*256+$4 "x" (($5*256+$6)*256+$7)*256+$8 }'
}

# "POINTCACHE2", version 1, POINTS, first frame 0, rate 1, one sample per argument: every coordinate that float32, in hex
cache() {
    local points=$1 samples=$(($# - 1)) sample i
    shift
    printf 'POINTCACHE2\0\1\0\0\0'
    printf "\\x$(printf %02x "$points")\\0\\0\\0\\0\\0\\0\\0\\0\\0\\x80\\x3f\\x$(printf %02x "$samples")\\0\\0\\0"
    for sample; do
        for i in $(seq $((points * 3))); do
            # the high bit of byte 2 with exponent byte 7f is infinity or NaN
            printf "\\0\\0\\x$(printf %02x $((128 + i * 8)))\\x$sample"
        done
    done
}

@test "a mesh, a document and a pipe give a PNG of the size asked for" {
    "$BIN/rig-view" tetra.off -o mesh.png
    [ "$(png_size mesh.png)" = 800x600 ]
    "$BIN/rig-view" tetra.muscle.json --size 123x77 -o document.png
    [ "$(png_size document.png)" = 123x77 ]
    "$BIN/rig-view" --size 123x77 < tetra.muscle.json > pipe.png
    cmp document.png pipe.png
}

@test "the same bytes on 1, 2 and 5 threads" {
    for threads in 1 2 5; do
        "$BIN/rig-view" tetra.muscle.json --size 200x150 --show surface,wire --threads $threads -o $threads.png
    done
    cmp 1.png 2.png
    cmp 1.png 5.png
}

@test "views and inputs make a contact sheet" {
    "$BIN/rig-view" tetra.off --views 4 --size 100x80 --columns 2 --no-legend -o turns.png
    size=$(png_size turns.png)
    [ "${size%x*}" -ge 200 ]
    [ "${size%x*}" -le 220 ]
    [ "${size#*x}" -ge 160 ]
    [ "${size#*x}" -le 180 ]
    "$BIN/rig-view" tetra.off --views front,left,30:20 --size 100x80 --columns 3 --no-legend -o list.png
    size=$(png_size list.png)
    [ "${size%x*}" -ge 300 ]
    "$BIN/rig-view" tetra.off tetra.muscle.json --size 100x80 --columns 1 -o stages.png
    size=$(png_size stages.png)
    [ "${size#*x}" -ge 160 ]
}

@test "the camera, the zoom, the legend, the background and --show change the picture" {
    "$BIN/rig-view" tetra.muscle.json --size 100x80 -o plain.png
    for words in "--camera top" "--camera 20:-35" "--zoom 2" "--no-legend" "--background black" "--show wire" "--title other" "--bone tetra.off"; do
        "$BIN/rig-view" tetra.muscle.json --size 100x80 $words -o other.png
        run -1 cmp -s plain.png other.png
    done
}

@test "bones by option and by list are the same" {
    printf '# bones\n\nshaft\ttetra.off\n' > list
    "$BIN/rig-view" tetra.muscle.json --size 100x80 --bone shaft=tetra.off -o a.png
    "$BIN/rig-view" tetra.muscle.json --size 100x80 --bones list -o b.png
    cmp a.png b.png
}

@test "a scene at rest and with frames" {
    "$BIN/rig-view" one.scene.json --size 100x80 -o rest.png
    [ "$(png_size rest.png)" = 100x80 ]
    mkdir frames
    cache 4 3d 3e > frames/tetra.pc2
    "$BIN/rig-view" one.scene.json --size 100x80 --frames frames --frame 0 -o 0.png
    "$BIN/rig-view" one.scene.json --size 100x80 --frames frames/tetra.pc2 --frame 1 -o 1.png
    run -1 cmp -s 0.png 1.png
    "$BIN/rig-view" one.scene.json --size 100x80 --frames frames --frame 0:1 --columns 2 -o both.png
    size=$(png_size both.png)
    [ "${size%x*}" -ge 200 ]
}

@test "frames that do not fit are refused by name" {
    cache 5 3d > five.pc2
    run -1 "$BIN/rig-view" one.scene.json --frames five.pc2 -o x.png
    [[ "$output" == *five.pc2*"5 points"*"4 vertices"* ]]
    cache 4 3d > four.pc2
    run -1 "$BIN/rig-view" one.scene.json --frames four.pc2 --frame 7 -o x.png
    [[ "$output" == *"frame 7"* ]]
    run -1 "$BIN/rig-view" one.scene.json --frames none -o x.png
    [[ "$output" == *none* ]]
    cache 4 7f > infinite.pc2
    run -1 "$BIN/rig-view" one.scene.json --frames infinite.pc2 -o x.png
    [ ! -e x.png ]
}

# a scene whose bone turns and whose muscle is bound to it, and its state in the middle of frame 2
state_of_turning_scene() {
    "$BIN/attach-detect" tetra.muscle.json --pin bone=sphere:0,0,0.1,0.01 --no-history -q -o bound.muscle.json
    cat > turn.scene.json << 'END'
{ "format": "sinew-scene", "version": 1, "name": "turn", "frames": [0, 4], "solver": { "method": "xpbd" },
  "motion": { "joints": [ { "name": "j", "type": "hinge", "axis": [1, 0, 0], "point": [0, 0, 0], "keys": [[0, 0], [0.15, 40]] } ] },
  "bones": [ { "name": "bone", "mesh": "tetra.off", "joint": "j" } ],
  "muscles": [ { "name": "tetra", "rig": "bound.muscle.json", "activation": 0.5 } ] }
END
    "$BIN/simulate" turn.scene.json --stop-after 2:3:1 --state half.state -q > half.jsonl
}

@test "a state is drawn by its errors, several states and errors as a sheet" {
    state_of_turning_scene
    "$BIN/rig-view" turn.scene.json --state half.state --size 200x150 --threads 1 -o one.png
    "$BIN/rig-view" turn.scene.json --state half.state --size 200x150 --threads 3 -o three.png
    [ "$(png_size one.png)" = 200x150 ]
    cmp one.png three.png
    for words in "--error dihedral" "--error volume" "--error internal" "--range 100" "--show wire" "--show surface,bones" "--no-legend"; do
        "$BIN/rig-view" turn.scene.json --state half.state --size 200x150 $words -o other.png
        run -1 cmp -s one.png other.png
    done
    "$BIN/simulate" turn.scene.json --stop-after 4 --state end.state -q > end.jsonl
    "$BIN/rig-view" turn.scene.json --state half.state --state end.state --error mesh,area --columns 2 --size 200x150 -o sheet.png
    size=$(png_size sheet.png)
    [ "${size%x*}" -ge 400 ]
    [ "${size#*x}" -ge 300 ]
}

@test "a state made with other settings is drawn when they are given" {
    state_of_turning_scene
    for words in "--scheme kohout" "--scheme romeo" "--solver qn" "--substeps 5" "--law isochoric"; do
        "$BIN/simulate" turn.scene.json $words --stop-after 3 --state other.state -q > other.jsonl
        "$BIN/rig-view" turn.scene.json --state other.state $words --size 100x80 -o other.png
    done
    "$BIN/simulate" turn.scene.json --scheme kohout --stop-after 3 --state other.state -q > other.jsonl
    run -1 "$BIN/rig-view" turn.scene.json --state other.state -o x.png
    [[ "$output" == *other.state*scheme* ]]
    [ ! -e x.png ]
}

@test "a damaged, foreign or missing state is one sentence" {
    state_of_turning_scene
    cp half.state damaged.state
    printf '\x55' | dd of=damaged.state bs=1 seek=700 conv=notrunc status=none
    head -c 500 half.state > short.state
    head -c 50 half.state > shorter.state
    : > empty.state
    echo '{}' > text.state
    "$BIN/simulate" one.scene.json --stop-after 1 --state foreign.state -q > /dev/null
    # a number that is not finite, under a checksum that fits: three doubles before the end of the points
    python3 - << 'END'
import hashlib, struct
data = bytearray(open("half.state", "rb").read())
# the model, the moment; per group: progress, still; counters and residual, inputs, motion of the bones, when margins began to grow, how far ties have parted; energy, stretch, abrupt, pairs, why
# it stopped, turned and torn
head, points = 12 + 4 + 72, 72 + 16 + 16 + 4 + 14 * 8 + 4 * 8 + 80 + 8 + 8 + 2 * 8 + 1 + 3 * 4 + 2
data[head + points:head + points + 8] = struct.pack("d", float("nan"))
data[16:88] = b"sha256:" + hashlib.sha256(data[88:]).hexdigest().encode() + b"\0"
open("nan.state", "wb").write(data)
END
    for state in damaged short shorter empty text foreign nan missing; do
        code=0
        "$BIN/rig-view" turn.scene.json --state $state.state -o x.png 2> err || code=$?
        [ "$code" -eq 1 ] || { echo "$state: $code"; false; }
        [ "$(wc -l < err)" -eq 1 ] || { cat err; false; }
        grep -q "$state.state" err
        [ ! -e x.png ]
    done
    grep -q "missing" err
    "$BIN/rig-view" turn.scene.json --state nan.state -o x.png 2> err || true
    grep -q "points of muscle" err
    run -1 "$BIN/rig-view" tetra.muscle.json --state half.state -o x.png
    [[ "$output" == *"needs the scene"* ]]
}

@test "nothing to draw is an error, not an empty picture" {
    run -1 "$BIN/rig-view" tetra.muscle.json --show roots -o x.png
    [[ "$output" == *"nothing to draw"* ]]
    echo '{ "format": "sinew-scene", "version": 1 }' > empty.scene.json
    run -1 "$BIN/rig-view" empty.scene.json -o x.png
    [ ! -e x.png ]
}

@test "wrong words are wrong usage" {
    for words in "--size 800" "--size 0x10" "--size 10x99999" "--camera sideways" "--camera 10:200" "--views 0" "--views front,,left" \
        "--show surface,nerves" "--background mauve" "--background #12345" "--zoom 0" "--samples 65" "--frame 3:1" "--frame x" "--columns 0" \
        "--error mesh" "--range 1" "--state a --error nerves" "--state a --error mesh,,area" "--state a --range 0" "--state a --frame 1"; do
        code=0
        "$BIN/rig-view" tetra.off $words -o x.png 2> err || code=$?
        [ "$code" -eq 2 ] || { echo "$words: $code"; false; }
        [ "$(wc -l < err)" -eq 1 ]
        [ ! -e x.png ]
    done
}

@test "a full disk and a missing bone are errors" {
    run -1 sh -c "'$BIN/rig-view' tetra.off --size 50x50 > /dev/full"
    run -1 "$BIN/rig-view" tetra.off --bone a=none.ply -o x.png
    [[ "$output" == *none.ply* ]]
    [ ! -e x.png ]
}

@test "real anatomy: a calf muscle with its bones, and a dog's biceps" {
    [ -d "$DATA/leg-vhf" ] || skip "no leg-vhf in $DATA"
    meshes=$DATA/leg-vhf/meshes
    "$BIN/rig-view" "$meshes/VHF_Left_Muscle_Soleus_smooth.ply" --units mm --bone tibia="$meshes/VHF_Left_Bone_Tibia_smooth.ply" -o soleus.png
    [ "$(png_size soleus.png)" = 800x600 ]
    "$BIN/rig-view" "$DATA/dog-dmcontrol/meshes/MUSCm.biceps_brachii_L.stl" -o biceps.png
    [ "$(png_size biceps.png)" = 800x600 ]
}

# A turn of 90 degrees about y at (0,0,1) in 6 frames of 6 Hz, with a bone below; 'bone' is the mesh.
motion() {
    cat << END
{ "format": "sinew-motion", "version": 1, "name": "swing", "rate": 6, "joints": [
  { "name": "hip", "type": "hinge", "axis": [0,1,0], "point": [0,0,1], "end": [0,0,0.2], "keys": [[0,0],[1,-90]] } ],
  "bones": [ { "name": "shin", "mesh": "$1", "joint": "hip" } ] }
END
}

@test "a motion is drawn from a file and a pipe, at a frame and on sheets; its sticks are not its bones" {
    motion tetra.off > swing.motion.json
    "$BIN/rig-view" swing.motion.json --size 200x150 -o first.png
    [ "$(png_size first.png)" = 200x150 ]
    "$BIN/rig-view" --size 200x150 < swing.motion.json > pipe.png
    cmp first.png pipe.png
    "$BIN/rig-view" swing.motion.json --size 200x150 --frame 0 --threads 1 -o same.png
    cmp first.png same.png
    "$BIN/rig-view" swing.motion.json --size 200x150 --frame 6 -o last.png
    run -1 cmp -s first.png last.png
    "$BIN/rig-view" swing.motion.json --size 200x150 --show joints -o joints.png
    "$BIN/rig-view" swing.motion.json --size 200x150 --show bones -o bones.png
    run -1 cmp -s joints.png bones.png
    run -1 cmp -s joints.png first.png
    "$BIN/rig-view" swing.motion.json --frame-count 7 --size 100x80 --columns 7 --no-legend -o spread.png
    "$BIN/rig-view" swing.motion.json --frame 0:6 --size 100x80 --columns 7 --no-legend -o listed.png
    cmp spread.png listed.png
    "$BIN/rig-view" swing.motion.json --frame-count 99 --size 100x80 --columns 7 --no-legend -o all.png
    cmp spread.png all.png
}

@test "a motion's missing bone is an error that names it, unless bones are left out; a frame beyond its end is one" {
    motion nothing.ply > swing.motion.json
    run -1 "$BIN/rig-view" swing.motion.json -o x.png
    [[ "$output" == *nothing.ply*'bone "shin"'* ]]
    [ ! -e x.png ]
    "$BIN/rig-view" swing.motion.json --show joints -o x.png
    run -1 "$BIN/rig-view" swing.motion.json --show joints --frame 7 -o y.png
    [[ "$output" == *"frame 7 is not among those of the motion: 0 to 6"* ]]
    [ ! -e y.png ]
}

@test "a joint without a place is told, and a recording is told to go through motion-import, which gives a picture in a pipe" {
    printf '%s' '{ "format": "sinew-motion", "version": 1, "joints": [ { "name": "a", "type": "pose", "rest": [0,0,0], "end": [0,0,1],
        "keys": [ { "frame": 0 } ] }, { "name": "b", "type": "pose", "keys": [ { "frame": 0 } ] } ] }' > b.motion.json
    run -0 "$BIN/rig-view" b.motion.json -o x.png
    [[ "$output" == *"1 of 2 joints are not drawn"* ]]
    printf '%s\n' HIERARCHY 'ROOT elbow' '{' 'OFFSET 0 110 0' 'CHANNELS 1 Xrotation' 'End Site' '{' 'OFFSET 0 -25 0' '}' '}' MOTION \
        'Frames: 3' 'Frame Time: 0.25' 0 -20 -45 > arm.bvh
    run -1 "$BIN/rig-view" arm.bvh -o y.png
    [[ "$output" == *BVH*motion-import* ]]
    "$BIN/motion-import" arm.bvh | "$BIN/rig-view" --frame-count 3 -o sheet.png
    png_size sheet.png
    run -2 "$BIN/rig-view" arm.bvh --frame 1 --frame-count 2 -o z.png
    run -2 "$BIN/rig-view" arm.bvh --frame-count 0 -o z.png
}

@test "frames of a scene can be spread evenly too" {
    "$BIN/rig-view" one.scene.json --frame-count 2 --size 100x80 -o spread.png
    "$BIN/rig-view" one.scene.json --frame 0,3 --size 100x80 -o listed.png
    cmp spread.png listed.png
}

@test "externals: vertices by target, rows by what acts, a section; foreign rigs and wrong words are refused" {
    "$EXAMPLES/arm/arm" --out arm --triangles 1000
    mkdir rigs
    for name in biceps brachialis triceps; do "$BIN/mesh-clean" -q "arm/$name.ply" -o "rigs/$name.muscle.json"; done
    "$BIN/attach-detect" -q --muscles rigs --reach 8mm rigs/biceps.muscle.json -o b.muscle.json
    grep -q '"target": "brachialis"' b.muscle.json
    "$BIN/rig-view" b.muscle.json --size 160x120 -o plain.png
    "$BIN/rig-view" b.muscle.json --size 160x120 --show externals -o by-target.png
    "$BIN/rig-view" b.muscle.json --size 160x120 --show externals --neighbours rigs -o rows.png
    "$BIN/rig-view" b.muscle.json --size 160x120 --cut z --neighbours rigs --bone arm/humerus.ply -o section.png
    "$BIN/rig-view" b.muscle.json --size 160x120 --cut z --cut-depth 0 --neighbours rigs -o bare.png
    for a in by-target rows section; do [ "$(png_size $a.png)" = 160x120 ]; ! cmp -s plain.png $a.png || return 1; done
    ! cmp -s by-target.png rows.png && ! cmp -s section.png bare.png
    "$BIN/rig-view" b.muscle.json --size 160x120 --cut z --neighbours rigs --bone arm/humerus.ply --threads 3 -o again.png
    cmp section.png again.png
    "$BIN/mesh-clean" -q arm/brachialis.ply --triangles 500 -o rigs/brachialis.muscle.json
    run -1 "$BIN/rig-view" b.muscle.json --show externals --neighbours rigs -o x.png
    [[ "$output" == *'rows on target "brachialis" were found on another mesh'* ]]
    run -1 "$BIN/rig-view" b.muscle.json --cut 0,0,9,0,0,1 -o x.png
    [[ "$output" == *"does not cut the muscle"* ]]
    "$BIN/rig-view" rigs/triceps.muscle.json --show surface,externals --size 160x120 -o x.png 2> err
    grep -q 'has no externals' err
    run -1 "$BIN/rig-view" one.scene.json --cut z -o x.png
    run -2 "$BIN/rig-view" b.muscle.json --cut q -o x.png
    run -2 "$BIN/rig-view" b.muscle.json --cut 0,0,0,0,0,0 -o x.png
    run -2 "$BIN/rig-view" b.muscle.json --cut-depth 1mm -o x.png
    run -2 "$BIN/rig-view" b.muscle.json --neighbours rigs -o x.png
}

# two triangles of a plate, a muscle with two bones beside it, each in a file; the muscle is bound to `near`
bones_apart() {
    for name in near far; do
        at=$([ "$name" = near ] && echo 0.02 || echo 1)
        awk -v at="$at" 'NR > 2 && NF == 3 { $1 += at } { print }' tetra.off > "$name.off"
    done
    "$BIN/attach-detect" tetra.muscle.json --pin near=sphere:0.1,0,0,0.01 --no-history -q -o bound.muscle.json
    printf 'near.off\nfar.off\n' > bones.txt
    cat > apart.scene.json << 'END'
{ "format": "sinew-scene", "version": 1, "name": "apart", "frames": [0, 1],
  "bones": [ { "name": "near", "mesh": "near.off" }, { "name": "far", "mesh": "far.off" } ],
  "muscles": [ { "name": "bound", "rig": "bound.muscle.json" }, { "name": "other muscle", "rig": "tetra.muscle.json" } ] }
END
}

@test "bones of a list or scene to which nothing is attached are left out, and counted under -v" {
    bones_apart
    "$BIN/rig-view" bound.muscle.json --bone near.off --size 100x80 -o one.png
    "$BIN/rig-view" bound.muscle.json --bones bones.txt --size 100x80 -v -o list.png 2> said
    cmp one.png list.png
    grep -q '1 bone is not drawn.*--all-bones' said
    "$BIN/rig-view" bound.muscle.json --bones bones.txt --size 100x80 --all-bones -v -o all.png 2> said
    run -1 cmp -s one.png all.png
    run -1 grep 'not drawn' said
    "$BIN/rig-view" bound.muscle.json --bone near.off --bone far.off --size 100x80 -o named.png # named one by one
    cmp all.png named.png
    "$BIN/rig-view" tetra.muscle.json --bones bones.txt --size 100x80 -v -o loose.png 2> said # attached to nothing: all
    run -1 grep 'not drawn' said
    "$BIN/rig-view" apart.scene.json --size 100x80 -v -o scene.png 2> said
    grep -q '1 bone is not drawn, as no muscle of the scene' said
    "$BIN/rig-view" apart.scene.json --size 100x80 --all-bones -v -o scene-all.png 2> said
    run -1 cmp -s scene.png scene-all.png
    run -1 grep 'not drawn' said
}

@test "--focus aims at muscles and bones by name, and refuses names that nothing has" {
    bones_apart
    "$BIN/rig-view" apart.scene.json --size 100x80 --no-legend --all-bones --camera front -o all.png
    "$BIN/rig-view" apart.scene.json --size 100x80 --no-legend --all-bones --camera front --focus far -o far.png
    run -1 cmp -s all.png far.png
    "$BIN/rig-view" apart.scene.json --size 100x80 --no-legend --camera front --focus 'other muscle' -o other.png
    "$BIN/rig-view" apart.scene.json --size 100x80 --no-legend --camera front --focus 'other*' -o pattern.png
    cmp other.png pattern.png
    "$BIN/rig-view" apart.scene.json --size 100x80 --no-legend --camera front --focus 'bound,near' -o both.png
    "$BIN/rig-view" apart.scene.json --size 100x80 --no-legend --camera front --focus near --focus bound -o twice.png
    cmp both.png twice.png
    run -1 cmp -s both.png other.png
    run -1 "$BIN/rig-view" apart.scene.json --focus bund -o x.png
    [[ "$output" == *"called 'bund'; did you mean bound?"* ]]
    run -1 "$BIN/rig-view" apart.scene.json --focus far -o x.png
    [[ "$output" == *"called 'far'"*"--all-bones"* ]]
    [ ! -e x.png ]
}
