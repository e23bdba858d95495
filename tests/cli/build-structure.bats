# build-structure: leaves, spacing with units, pruning, partial results, and input that cannot work.

bats_require_minimum_version 1.5.0

setup_file() {
    "$EXAMPLES/arm/arm" --out "$BATS_FILE_TMPDIR" --triangles 1000
    "$BIN/root-select" -q "$BATS_FILE_TMPDIR/biceps.ply" -o "$BATS_FILE_TMPDIR/rooted.json"
}

setup() {
    cd "$BATS_FILE_TMPDIR" || exit 1
}

value() { sed -n "s/^ *\"$2\": *\([^,]*\),*\$/\1/p" "$1"; }

@test "the two-headed biceps has three leaves, every vertex is connected, no link is too long" {
    "$BIN/build-structure" --report r.json rooted.json -o s.json 2> err
    [ ! -s err ]
    [ "$(value r.json leaves)" -eq 3 ] && [ "$(value r.json unconnected)" -eq 0 ]
    awk -v link="$(value r.json longestLink)" -v spacing="$(value r.json spacing)" 'BEGIN { exit !(link > 0 && link <= spacing * (1 + 1e-9)) }'
}

@test "triceps and brachialis have heads of their own number" {
    for muscle in brachialis triceps; do
        "$BIN/root-select" -q $muscle.ply | "$BIN/build-structure" --report $muscle.r.json > $muscle.s.json
        [ "$(value $muscle.r.json unconnected)" -eq 0 ] && [ "$(value $muscle.r.json leaves)" -ge 2 ]
    done
}

@test "--spacing takes a unit, and less of it gives more samples" {
    "$BIN/build-structure" --no-history --spacing 6mm --report a.json rooted.json -o 1.json
    "$BIN/build-structure" --no-history --spacing 0.6cm rooted.json -o 2.json
    "$BIN/build-structure" --no-history --spacing 0.006 rooted.json -o 3.json
    cmp 1.json 2.json && cmp 1.json 3.json
    "$BIN/build-structure" --spacing 3mm --report b.json rooted.json > /dev/null
    [ "$(value b.json samples)" -gt "$(value a.json samples)" ]
}

@test "--prune 0 keeps every branch, --prune 1 leaves one on each side" {
    "$BIN/build-structure" --prune 0 --report r.json rooted.json > /dev/null
    [ "$(value r.json pruned)" -eq 0 ]
    "$BIN/build-structure" --prune 1 --report r.json rooted.json > /dev/null
    [ "$(value r.json leaves)" -eq 2 ]
}

@test "hops are the paper's traversal, slabs the default" {
    "$BIN/build-structure" --no-history rooted.json -o 1.json
    "$BIN/build-structure" --no-history --metric slabs rooted.json -o 2.json
    cmp 1.json 2.json
    "$BIN/build-structure" --metric hops --trace t.jsonl --report r.json rooted.json > /dev/null
    grep -q '"stage":"front"' t.jsonl
    [ "$(value r.json leaves)" -eq 3 ]
    [ "$(value r.json unconnected)" -eq 0 ]
    run -2 "$BIN/build-structure" --metric miles rooted.json
}

@test "the biceps has three leaves at any density of its mesh" {
    for n in 20000 4000 1000; do
        "$EXAMPLES/arm/arm" --out "d$n" --triangles $n
        "$BIN/root-select" -q "d$n/biceps.ply" | "$BIN/build-structure" --report "d$n/r.json" > /dev/null
        [ "$(value "d$n/r.json" leaves)" -eq 3 ]
        [ "$(value "d$n/r.json" outside)" -eq 0 ]
    done
}

@test "an arched sheet has no sample outside, unless it is asked to keep them" {
    mesh="$DATA/dog-dmcontrol/meshes/MUSCdiaphragma.stl"
    [ -e "$mesh" ] || skip "dog-dmcontrol is not here"
    "$BIN/root-select" -q "$mesh" -o arched.json
    "$BIN/build-structure" --trace t.jsonl --report in.json arched.json > /dev/null
    [ "$(value in.json outside)" -eq 0 ]
    [ "$(value in.json moved)" -gt 0 ]
    grep -q '"stage":"inside"' t.jsonl
    "$BIN/build-structure" --no-inside --report out.json arched.json > /dev/null
    [ "$(value out.json outside)" -gt 0 ]
    [ "$(value out.json moved)" -eq 0 ]
}

@test "files, pipes and a second run give the same bytes" {
    "$BIN/build-structure" rooted.json -o 1.json
    "$BIN/build-structure" < rooted.json > 2.json
    cmp 1.json 2.json
}

@test "every --stop-after leaves a document that the tool reads again" {
    "$BIN/build-structure" --trace t.jsonl rooted.json > /dev/null
    last=$(wc -l < t.jsonl)
    for stage in slab branch resample connect; do grep -q "\"stage\":\"$stage\"" t.jsonl; done
    for n in 0 1 2 7 $((last - 9)) $((last - 5)) $((last - 1)) "$last"; do
        "$BIN/build-structure" --no-history --stop-after "$n" --report r.json rooted.json -o part.json
        "$BIN/build-structure" --no-history part.json -o whole.json 2> /dev/null
        "$BIN/build-structure" --no-history rooted.json | cmp - whole.json
        [ "$n" -ne 1 ] || [ "$(value r.json samples)" -eq 1 ]
        [ "$n" -lt "$last" ] || [ "$(value r.json unconnected)" -eq 0 ]
    done
}

@test "a muscle without roots is told what to run" {
    code=0
    "$BIN/build-structure" biceps.ply -o no.json 2> err || code=$?
    [ "$code" -eq 1 ] && [ ! -e no.json ]
    grep -q '^build-structure: biceps.ply: .*root-select' err
}

@test "two components: the error names a vertex and the cure" {
    printf 'OFF\n8 8 0\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n1 0 0\n1.1 0 0\n1 .1 0\n1 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n3 4 6 5\n3 4 5 7\n3 5 6 7\n3 6 4 7\n' > two.off
    "$BIN/root-select" -q --indices 0 two.off -o two.json
    run -1 "$BIN/build-structure" two.json
    [[ "$output" == *"vertex 4 "*"mesh-clean --keep largest"* ]]
}

@test "a spacing of nothing or in the wrong unit is caught" {
    run -2 "$BIN/build-structure" --spacing 0 rooted.json
    run -2 "$BIN/build-structure" --spacing 6miles rooted.json
    code=0
    "$BIN/build-structure" --spacing 0.000000001mm rooted.json > out 2> err || code=$?
    [ "$code" -ne 0 ] && [ ! -s out ] && grep -q spacing err
}

@test "the dog's gastrocnemius has two heads on one side of its roots" {
    mesh="$DATA/dog-dmcontrol/meshes/MUSCm.gastrocnemius_L.stl"
    [ -e "$mesh" ] || skip "dog-dmcontrol is not here"
    "$BIN/root-select" "$mesh" | "$BIN/build-structure" --report r.json > /dev/null
    [ "$(value r.json leaves)" -eq 3 ]
}
