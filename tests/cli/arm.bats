# The sample arm: its meshes, its rigs built by make and by pipes, its simulation.

bats_require_minimum_version 1.5.0

setup_file() {
    export ARM="$EXAMPLES/arm/arm" HERE="$BATS_TEST_DIRNAME/../../share/examples/arm" SAMPLE="$BATS_FILE_TMPDIR/sample"
    "$ARM" --out "$SAMPLE" --triangles 1000 --dirty
    make -s -C "$SAMPLE" -f "$HERE/Makefile" TOOLS="$BIN"
}

setup() { cd "$BATS_TEST_TMPDIR" || exit 1; }

faces() { head -n 12 "$1" | LC_ALL=C sed -n 's/^element face //p'; }

# value REPORT PATH...: one number of a report
value() { python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); [d := d[k] for k in sys.argv[2:]]; print(d)' "$@"; }

bones_of() { python3 -c 'import json, sys; print(*sorted(a["bone"] for a in json.load(open(sys.argv[1]))["attachments"]))' "$1"; }

@test "every surface is closed, manifold, outward, of genus 0, without self-intersections or slivers from 1k to 60k triangles" {
    for triangles in 1000 4000 60000; do
        "$ARM" --out . --triangles $triangles
        for mesh in *.ply; do
            "$BIN/mesh-clean" --check --self-intersections "$mesh" --report report.json
            [ "$(value report.json before genus)" = 0 ]
            [ "$(value report.json before components)" = 1 ]
            [ "$(value report.json before selfIntersections)" = 0 ]
            python3 -c 'import sys; sys.exit(not float(sys.argv[1]) > 0.5)' "$(value report.json before worstQuality)"
        done
    done
}

@test "the biceps has about the triangles asked for, and other muscles scale with it" {
    for triangles in 1000 4000 26000; do
        "$ARM" --out . --triangles $triangles
        count=$(faces biceps.ply)
        [ "$count" -gt $((triangles * 90 / 100)) ] && [ "$count" -lt $((triangles * 110 / 100)) ]
        [ "$(faces triceps.ply)" -gt $((triangles / 2)) ]
    done
}

@test "--resolution is the edge length" {
    "$ARM" --out . --resolution 3mm
    "$BIN/mesh-clean" --check biceps.ply --report report.json
    python3 -c 'import sys; sys.exit(not 2.7e-3 < float(sys.argv[1]) < 3.3e-3)' "$(value report.json before edgeMean)"
}

@test "the same options give the same bytes" {
    "$ARM" --out again --triangles 1000 --dirty
    for file in again/*; do cmp "$file" "$SAMPLE/${file#again/}"; done
}

@test "wrong usage: status 2 and one line; a folder that cannot be made: status 1" {
    for words in "" "--out" "--out x extra" "--out x --triangles 10" "--out x --resolution 3parsec" "--out x --resolution 1m" "--no-such"; do
        run -2 "$ARM" $words
        [ "${#lines[@]}" -eq 1 ]
    done
    [ ! -e x ]
    : > file
    run -1 "$ARM" --out file/below
    [[ "$output" == *"file/below"* ]]
}

@test "pipes give the bytes of the Makefile's files, and so does a second run" {
    mkdir piped again
    TOOLS="$BIN" "$HERE/pipeline.sh" "$SAMPLE" piped
    cp "$SAMPLE"/*.ply again
    make -s -C again -f "$HERE/Makefile" TOOLS="$BIN"
    for muscle in biceps brachialis triceps; do
        cmp "$SAMPLE/$muscle.muscle.json" piped/$muscle.muscle.json
        cmp "$SAMPLE/$muscle.muscle.json" again/$muscle.muscle.json
    done
}

@test "one thread and two give the same rig and the same frames" {
    cd "$SAMPLE"
    bones="--bone scapula=scapula.ply --bone humerus=humerus.ply --bone ulna=ulna.ply --bone radius=radius.ply"
    cp "$HERE/arm.scene.json" .
    for threads in 1 2; do
        "$BIN/attach-detect" biceps.fibers.json $bones --threads $threads -o "$BATS_TEST_TMPDIR/$threads.json"
        mkdir "$BATS_TEST_TMPDIR/$threads"
        "$BIN/simulate" arm.scene.json --frames 0:2 --threads $threads -o "$BATS_TEST_TMPDIR/$threads" > "$BATS_TEST_TMPDIR/$threads/log"
    done
    cmp "$BATS_TEST_TMPDIR/1.json" "$BATS_TEST_TMPDIR/2.json"
    cmp biceps.muscle.json "$BATS_TEST_TMPDIR/1.json"
    diff -r "$BATS_TEST_TMPDIR/1" "$BATS_TEST_TMPDIR/2"
}

@test "muscles are attached to their bones and to no other" {
    [ "$(bones_of "$SAMPLE/biceps.muscle.json")" = "radius scapula" ]
    [ "$(bones_of "$SAMPLE/brachialis.muscle.json")" = "humerus ulna" ]
    [ "$(bones_of "$SAMPLE/triceps.muscle.json")" = "humerus scapula ulna" ]
}

@test "the tree of the biceps has three leaves at any resolution: two heads, one distal tendon" {
    for triangles in 1000 4000 26000; do
        "$ARM" --out . --triangles $triangles
        "$BIN/mesh-clean" biceps.ply | "$BIN/root-select" | "$BIN/build-structure" -o biceps.json --report report.json
        [ "$(value report.json leaves)" = 3 ]
    done
}

@test "the dirty copy is repaired: closed, and its volume within 1 % of the clean one's" {
    "$BIN/mesh-clean" "$SAMPLE/biceps-dirty.obj" -o repaired.ply --report dirty.json
    "$BIN/mesh-clean" --check repaired.ply
    "$BIN/mesh-clean" --check "$SAMPLE/biceps.ply" --report clean.json
    run -3 "$BIN/mesh-clean" --check "$SAMPLE/biceps-dirty.obj"
    [ "$(value dirty.json before closed)" = False ]
    [ "$(value dirty.json after closed)" = True ]
    [ "$(value dirty.json after genus)" = 0 ]
    python3 -c 'import sys; a, b = map(float, sys.argv[1:]); sys.exit(not abs(a - b) < 0.01 * b)' \
        "$(value dirty.json after volume)" "$(value clean.json before volume)"
}

@test "the elbow bends: volumes stay within 1 % of the goal and nothing is NaN" {
    cd "$SAMPLE"
    cp "$HERE/arm.scene.json" .
    "$BIN/simulate" arm.scene.json -o "$BATS_TEST_TMPDIR" > "$BATS_TEST_TMPDIR/arm.jsonl"
    [ "$(wc -l < "$BATS_TEST_TMPDIR/arm.jsonl")" -gt 24 ]
}
