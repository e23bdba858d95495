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
    [ $(($(value r.json byField) + $(value r.json byNeighbours) + $(value r.json byConvention))) -eq "$(value r.json vertices)" ]
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

@test "known ends make the field harmonic; automatic without them is the tree" {
    printf '# two heads and a tendon\norigin -0.0014 0.0437 0.3175\norigin 0.0276,0.0366,0.3216\ninsertion\t0.0086 -0.0125 -0.0477\n' > ends.txt
    "$BIN/fiber-flow" --ends ends.txt --report r.json built.json -o h.json 2> err
    [ ! -s err ]
    grep -q '"field": "harmonic"' h.json
    grep -q '"ends": "sites"' r.json
    "$BIN/fiber-flow" --report t.r.json built.json -o t.json
    grep -q '"field": "tree"' t.r.json
    if cmp -s <(directions t.json) <(directions h.json); then false; fi
    directions h.json | awk '{ d = $1 * $1 + $2 * $2 + $3 * $3 - 1; if (!(d < 1e-9 && d > -1e-9)) exit 1 }'
}

@test "a harmonic field needs no structure, but warns where only the tips are known" {
    "$BIN/fiber-flow" --field harmonic --report r.json biceps.ply -o h.json 2> err
    grep -q 'warning.*--ends' err
    grep -q '"ends": "tips"' r.json
}

@test "sites that cannot be are said in a sentence" {
    printf 'origin 5 5 5\ninsertion 0 0 0\n' > far.txt
    run -1 "$BIN/fiber-flow" --ends far.txt built.json
    [[ "$output" == *"site 1 is"*"off the surface"* ]]
    printf 'origin 0.0086 -0.0125 -0.0477\n' > one.txt
    run -1 "$BIN/fiber-flow" --ends one.txt built.json
    [[ "$output" == *"no site is given for the insertion"* ]]
    printf 'beginning 1 2 3\n' > word.txt
    run -1 "$BIN/fiber-flow" --ends word.txt built.json
    [[ "$output" == *"word.txt:1"* || "$output" == *"word.txt"*"line 1"* ]]
    run -2 "$BIN/fiber-flow" --ends one.txt --field tree built.json
}

@test "given fibres decide: lines of an OBJ file, and the same in JSON" {
    printf 'v -1 0 0\nv 1 0 0\nl 1 2\n' > x.obj
    printf '{"polylines":[{"points":[-1,0,0,1,0,0]}]}' > x.json
    "$BIN/fiber-flow" --no-history --smooth 0 --from-fibers x.obj --report r.json built.json -o 1.json
    "$BIN/fiber-flow" --no-history --smooth 0 --from-fibers x.json built.json -o 2.json
    cmp 1.json 2.json
    grep -q '"field": "fibers"' 1.json
    # every direction is x laid into the tangent plane: none but those at a normal along x has less x than the others have to give
    directions 1.json | awk '{ x = $1 < 0 ? -$1 : $1; sum += x; n++ } END { exit !(sum / n > 0.6) }'
    printf 'v 0 0 0\nf 1 1 1\n' > none.obj
    run -1 "$BIN/fiber-flow" --from-fibers none.obj built.json
    [[ "$output" == *"holds no fibre"* ]]
    run -2 "$BIN/fiber-flow" --from-fibers x.obj --field tree built.json
    run -2 "$BIN/fiber-flow" --field fibers built.json
}

@test "fibres are read alike wherever they are written, by every option that takes them" {
    # what fiber-fill makes of this muscle, from end to end, and twenty of them as other programs write such lines
    "$BIN/fiber-flow" built.json | "$BIN/fiber-fill" -n 20 --no-history -o filled.json
    "$BIN/fiber-flow" built.json | "$BIN/fiber-fill" -n 20 -o filled.vtp
    "$BIN/fiber-flow" built.json | "$BIN/fiber-fill" -n 20 -o filled.obj
    python3 -c '
import json
lines = json.load(open("filled.json"))["fibers"]["polylines"]
json.dump([[l["points"][i:i + 3] for i in range(0, len(l["points"]), 3)] for l in lines], open("fibres", "w"))'
    for format in obj obj-segments json muscle vtp vtp-binary vtp-appended vtp-zlib vtp-pieces vtk vtk-binary vtk5 vtk5-binary; do
        "$BATS_TEST_DIRNAME/../write-lines" $format lines.$format fibres
    done
    take() { # COMMAND OPTION FILE: what comes out, without a line of history
        "$BIN/$1" -q --no-history $extra "$2" "$3" built.json -o out.json && mv out.json "$4"
    }
    while read -r tool option extra; do
        take $tool $option lines.obj wanted.json
        for file in filled.json filled.vtp filled.obj lines.*; do
            take $tool $option $file found.json || { echo "$tool $option $file"; false; }
            cmp wanted.json found.json || { echo "$tool $option $file"; false; }
        done
    done << 'END'
fiber-flow --from-fibers
fiber-flow --ends
root-select --ends
fiber-fill --bend-to -n 5
fiber-fill --ends -n 5
END
    # the ends are the fibres': origins where they begin
    python3 -c '
import json
lines = json.load(open("fibres"))
open("sites", "w").writelines("%s %r %r %r\n" % (n, *l[k]) for l in lines for n, k in (("origin", 0), ("insertion", -1)))'
    take fiber-flow --ends sites found.json
    take fiber-flow --ends lines.vtk wanted.json
    cmp wanted.json found.json
}

@test "files of lines that cannot be are said in a sentence" {
    echo '[[[-1, 0, 0], [0, 0, 0], [1, 0, 0]]]' > one
    for format in vtp vtk vtk5 obj json; do
        "$BATS_TEST_DIRNAME/../write-lines" $format bad.$format one
    done
    sed -i 's/^3 0 1 2/3 0 1 7/' bad.vtk
    sed -i 's/0 1 2<\/Da/0 1 7<\/Da/' bad.vtp
    sed -i 's/^0 1 2$/0 1 7/' bad.vtk5
    sed -i 's/^l 1 2 3/l 1/' bad.obj
    sed -i 's/-1, 0, 0, 0, 0, 0, 1, 0, 0/1, 0, 0/' bad.json
    for format in vtp vtk vtk5 obj json; do
        for option in --from-fibers --ends; do
            run -1 "$BIN/fiber-flow" $option bad.$format built.json
            [ "${#lines[@]}" -eq 1 ] || { echo "$format: $output"; false; }
            echo "$output" | grep -Eq "^fiber-flow: bad.$format:.*(names vertex|two vertices|two points)" || { echo "$output"; false; }
        done
    done
    # a line of one point is left out, with a word; a file without lines holds no fibre
    printf '# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n-1 0 0\n1 0 0\n0 0 0\nLINES 2 5\n1 2\n2 0 1\n' > thin.vtk
    "$BIN/fiber-flow" --from-fibers thin.vtk built.json -o thin.json 2> err
    grep -q '^fiber-flow: warning: thin.vtk: 1 lines of fewer than two points are left out' err
    printf '# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n-1 0 0\n1 0 0\n0 0 0\nPOLYGONS 1 4\n3 0 1 2\n' > none.vtk
    run -1 "$BIN/fiber-flow" --from-fibers none.vtk built.json
    [[ "$output" == *"none.vtk: the file holds no fibre"* ]]
}

@test "every direction has a confidence, low at the tips" {
    "$BIN/fiber-flow" --report r.json built.json -o f.json
    grep -o '"confidence": *\[[^]]*\]' f.json | sed 's/.*\[//; s/\]//' | tr , '\n' > c.txt
    [ "$(wc -l < c.txt)" -eq "$(value r.json vertices)" ]
    awk '$1 < 0 || $1 > 1 { exit 1 }' c.txt
    awk -v mean="$(value r.json meanConfidence)" -v low="$(value r.json lowConfidence)" 'BEGIN { exit !(mean > 0.6 && low > 0) }'
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
