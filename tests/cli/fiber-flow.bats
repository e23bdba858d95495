# fiber-flow: directions everywhere, the choices, what stays, partial results.

bats_require_minimum_version 1.5.0

setup_file() {
    "$EXAMPLES/arm/arm" --out "$BATS_FILE_TMPDIR" --triangles 1000
    "$BIN/root-select" -q "$BATS_FILE_TMPDIR/biceps.ply" | "$BIN/build-structure" -o "$BATS_FILE_TMPDIR/built.json"
}

setup() {
    cd "$BATS_FILE_TMPDIR" || exit 1
}

value() { sed -n "s/^ *\"$2\": *\([^,]*\),*\$/\1/p" "$1"; }

# directions FILE: one vector a line
directions() { grep -o '"directions": *\[[^]]*\]' "$1" | sed 's/.*\[//; s/\]//' | tr , '\n' | paste -d ' ' - - -; }

@test "every vertex gets a unit direction, tangent to the surface" {
    "$BIN/fiber-flow" --report r.json built.json -o f.json 2> err
    [ ! -s err ]
    [ "$(directions f.json | wc -l)" -eq "$(value r.json vertices)" ]
    directions f.json | awk '{ d = $1 * $1 + $2 * $2 + $3 * $3 - 1; if (!(d < 1e-9 && d > -1e-9)) exit 1 }'
    awk -v dot="$(value r.json maxNormalDot)" 'BEGIN { exit !(dot < 1e-6) }'
    [ $(($(value r.json byTree) + $(value r.json byNeighbours) + $(value r.json byConvention))) -eq "$(value r.json vertices)" ]
}

@test "alignment and smoothing bring neighbours together" {
    "$BIN/fiber-flow" --report default.json built.json > /dev/null
    "$BIN/fiber-flow" --smooth 0 --report plain.json built.json > /dev/null
    "$BIN/fiber-flow" --smooth 0 --no-align --weights paper --report paper.json built.json > /dev/null
    awk -v a="$(value default.json percentile95AngleDegrees)" -v b="$(value plain.json percentile95AngleDegrees)" \
        -v c="$(value paper.json percentile95AngleDegrees)" 'BEGIN { exit !(a < b && b < c) }'
}

@test "the defaults can be spelled out" {
    "$BIN/fiber-flow" --no-history built.json -o 1.json
    "$BIN/fiber-flow" --no-history --field tree --weights inverse-square --smooth 3 built.json -o 2.json
    cmp 1.json 2.json
    grep -q '"field": "tree"' 1.json
}

@test "files, pipes and a second run give the same bytes" {
    "$BIN/fiber-flow" built.json -o 1.json
    "$BIN/fiber-flow" < built.json > 2.json
    cmp 1.json 2.json
}

@test "every --stop-after leaves a valid document" {
    "$BIN/fiber-flow" --trace t.jsonl built.json > /dev/null
    [ "$(wc -l < t.jsonl)" -eq 5 ] # tree, neighbours, three of smoothing
    for n in 0 1 2 3 4 5; do
        "$BIN/fiber-flow" --no-history --stop-after $n built.json -o part.json
        "$BIN/fiber-flow" --no-history part.json | cmp - <("$BIN/fiber-flow" --no-history built.json)
        directions part.json | awk '{ d = $1 * $1 + $2 * $2 + $3 * $3 - 1; if (!(d < 1e-9 && d > -1e-9)) exit 1 }'
    done
}

@test "a muscle without a structure, or with a partial one, is told what to run" {
    code=0
    "$BIN/fiber-flow" biceps.ply -o no.json 2> err || code=$?
    [ "$code" -eq 1 ] && [ ! -e no.json ] && grep -q '^fiber-flow: biceps.ply: .*build-structure' err
    "$BIN/root-select" -q biceps.ply | "$BIN/build-structure" --stop-after 3 -o part.json
    run -1 "$BIN/fiber-flow" part.json
    [[ "$output" == *build-structure* ]]
}

@test "a field or a weight that is not there is wrong usage" {
    run -2 "$BIN/fiber-flow" --field magnetic built.json
    run -2 "$BIN/fiber-flow" --weights none built.json
    run -2 "$BIN/fiber-flow" --smooth -1 built.json
}

@test "a real leg muscle flows smoothly" {
    mesh="$DATA/leg-vhf/meshes/VHF_Left_Muscle_TibialisAnterior_smooth.ply"
    [ -e "$mesh" ] || skip "leg-vhf is not here"
    "$BIN/root-select" --units mm "$mesh" | "$BIN/build-structure" | "$BIN/fiber-flow" --report r.json > leg.json 2> err
    [ ! -s err ]
    awk -v p="$(value r.json percentile95AngleDegrees)" 'BEGIN { exit !(p < 11) }'
}
