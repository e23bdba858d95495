# share/examples/arm/tone.sh and folds: how far passive muscles fold as their bones come nearer, without and with tone.

bats_require_minimum_version 1.5.0

setup_file() {
    export ARM="$BATS_TEST_DIRNAME/../../share/examples/arm" FOLDS="$EXAMPLES/arm/folds"
}

setup() { cd "$BATS_TEST_TMPDIR" || exit 1; }

# SOLVER SETTING: the largest change of an angle, from the table that tone.sh has left in FOLDER
largest() { awk -F '\t' -v s="$2" -v n="$3" '$1 == s && $2 == n { print $3 }' "$1/tone.tsv"; }

# holds CONDITION of numbers
holds() { awk "BEGIN { exit !($1) }" || { echo "not so: $1"; return 1; }; }

# book DEGREES: two triangles hinged on the edge from (0,0,0) to (1,0,0), flat at 0, as OBJ; the third page turns up
book() { awk -v d="$1" 'BEGIN { a = d * 3.14159265358979 / 180
    printf "v 0 0 0\nv 1 0 0\nv 0.4 1 0\nv 0.6 %.15f %.15f\nf 1 2 3\nf 2 1 4\n", -cos(a), sin(a) }'; }

@test "folds tells the change of angles from rest, the shorter way round, whatever the rest shape and a rigid motion" {
    for degrees in 0 30 -30 90 170 -170; do book $degrees > book$degrees.obj; done
    "$FOLDS" book0.obj book0.obj book30.obj book-30.obj book90.obj book-170.obj > flat
    [ "$(cut -f 2 flat | tr '\n' ' ')" = "largest 0.00 30.00 30.00 90.00 170.00 " ]
    [ "$(sed -n 3p flat | cut -f 1,3-)" = "$(printf 'book30.obj\t30.00\t30.00\t0\t1')" ]
    "$FOLDS" book90.obj book30.obj book-30.obj > folded
    [ "$(cut -f 2 folded | tr '\n' ' ')" = "largest 60.00 120.00 " ]
    "$FOLDS" book170.obj book-170.obj > around
    [ "$(cut -f 2 around | tail -n 1)" = 20.00 ]
    # turned by a right angle about z, and moved
    awk '$1 == "v" { print "v", 5 - $3, $2 + 7, $4 - 1; next } { print }' book30.obj > moved.obj
    "$FOLDS" book30.obj moved.obj > same
    [ "$(cut -f 2 same | tail -n 1)" = 0.00 ]
}

@test "folds refuses in one line what it cannot compare" {
    book 30 > book.obj
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > one.obj
    run -1 --separate-stderr "$FOLDS" book.obj one.obj
    [ "$stderr" = "folds: one.obj: it has 3 vertices, and the muscle 4; give the shapes that simulate made of it" ]
    run -1 "$FOLDS" one.obj one.obj
    [ "$output" = "folds: one.obj: no two of its triangles are neighbours; mesh-clean welds them" ]
    run -1 "$FOLDS" missing.obj one.obj
    [ "${#lines[@]}" -eq 1 ]
    run -2 "$FOLDS" book.obj
    run -2 "$ARM/tone.sh" out
}

@test "tone.sh without the program that measures says so before it runs anything" {
    FOLDS=./nowhere run -1 sh "$ARM/tone.sh" out rig.muscle.json --motion a.motion.json
    [ "$output" = "tone.sh: there is no program './nowhere', which measures folds; name it by FOLDS" ]
    [ ! -e out ]
}

@test "the arm's passive biceps folds at 120 degrees under xpbd, with tone by less than half; under qn it bows and does not fold" {
    make -s -f "$ARM/Makefile" TOOLS="$BIN" ARM="$EXAMPLES/arm/arm" TRIANGLES=1000 tone > out 2> err
    tail -n 12 out | cmp - <(tail -n 12 tone/tone.tsv)
    passive=$(largest tone xpbd passive)
    holds "$passive > 90"
    for setting in tone-0.2 restLength-0.9 restLength-0.8 both; do holds "$(largest tone xpbd $setting) < 0.5 * $passive"; done
    # the change that goes with a smooth bow: an edge's share of it
    holds "$(largest tone qn passive) < 15"
    # tone times the contraction is what restLength takes, where nothing but the muscle pulls
    holds "($(largest tone qn tone-0.2) - $(largest tone qn restLength-0.9)) ^ 2 < 0.05 ^ 2"
    [ "$(head -c 4 tone/tone.png | tail -c 3)" = PNG ]
}

@test "the dog's biceps brachii folds with the elbow bent to 120 degrees under qn, with a restLength of 0.8 by less than half" {
    meshes="$DATA/dog-dmcontrol/meshes"
    [ -d "$meshes" ] || skip "no dog-dmcontrol in DATA"
    PATH=$BIN:$PATH
    for bone in Scapula Ulna Radius humerus; do echo "${bone}_L	$meshes/BONE${bone}_L.stl"; done > bones.txt
    # its bones are the first three (attachments.tsv of the data)
    head -n 3 bones.txt > held.txt
    mesh-clean -q "$meshes/MUSCm.biceps_brachii_L.stl" | attach-detect -q --bones held.txt |
        root-select -q | build-structure -q | fiber-flow -q -o biceps.muscle.json
    # dog.xml's elbow_L: it stands bent by 22 degrees, and its range ends 100 further
    echo '{"format": "sinew-motion", "version": 1, "metersPerUnit": 1, "rate": 24, "joints": [{"name": "elbow", "type": "hinge", "axis": [0, -1, -0.2],' \
        '"point": [0.145403, 0.068, 0.28022], "keys": [[0.25, 0], [2, 100], [2.5, 100]], "interpolation": "smooth"}]}' > elbow.motion.json
    "$ARM/tone.sh" dog biceps.muscle.json --motion elbow.motion.json --bones bones.txt --bind Ulna_L=elbow --bind Radius_L=elbow > out 2> err
    passive=$(largest dog qn passive)
    holds "$passive > 40"
    for setting in restLength-0.8 restLength-0.7 both; do holds "$(largest dog qn $setting) < 0.5 * $passive"; done
}
