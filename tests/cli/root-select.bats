# root-select: the automatic ring, every selection by hand, warnings, partial results, what becomes stale.

bats_require_minimum_version 1.5.0

setup_file() {
    "$EXAMPLES/arm/arm" --out "$BATS_FILE_TMPDIR" --triangles 1000
    "$BIN/root-select" -q "$BATS_FILE_TMPDIR/biceps.ply" -o "$BATS_FILE_TMPDIR/rooted.json"
}

setup() {
    cd "$BATS_FILE_TMPDIR" || exit 1
}

# roots FILE: the vertices of the roots section, in one line
roots() { tr -d '\n' < "$1" | sed -n 's/.*"roots": *{ *"vertices": *\[\([^]]*\)\].*/\1/p'; }

@test "a bare mesh on stdin gets a closed ring that parts it in two, near its centroid" {
    "$BIN/root-select" --report r.json < biceps.ply > a.json 2> err
    [ ! -s err ]
    grep -q '"ring": true' r.json && grep -q '"parts": 2' r.json && grep -q '"fallback": false' r.json
    awk -F '[:,]' '/"centroidOffset"/ { d = $2 } /"length"/ { l = $2 } END { exit !(l > 0 && d < 0.1 * l) }' r.json
    grep -q '"rule": "mid-section"' a.json
}

@test "the ring starts at its lowest vertex and goes towards the lower of its neighbours" {
    roots rooted.json | awk -F , '{ for (i = 2; i <= NF; i++) if ($i < $1) exit 1; exit !($2 < $NF && NF >= 3) }'
}

@test "files, pipes and a second run give the same bytes" {
    "$BIN/mesh-clean" biceps.ply -o clean.json && "$BIN/root-select" clean.json -o 1.json
    "$BIN/mesh-clean" biceps.ply | "$BIN/root-select" > 2.json
    "$BIN/root-select" - < clean.json > 3.json
    cmp 1.json 2.json && cmp 1.json 3.json
}

@test "each selection by hand takes what it says" {
    [ "$("$BIN/root-select" -q --indices 9,3,5 biceps.ply -o i.json && roots i.json)" = 3,5,9 ]
    [ "$("$BIN/root-select" -q --near 0,0,-9,5 biceps.ply -o n.json && roots n.json | tr , '\n' | grep -c .)" -eq 5 ]
    "$BIN/root-select" -q --box=-1,-1,-1,1,1,1 biceps.ply -o b.json
    "$BIN/root-select" -q --sphere 0,0,0,9 biceps.ply -o s.json
    [ "$(roots b.json)" = "$(roots s.json)" ]
    grep -q '"rule": "sphere"' s.json
}

@test "a plane gives a separating ring without a warning" {
    "$BIN/root-select" --plane 0.03,0.01,0.14,0,0,1 --report r.json biceps.ply -o p.json 2> err
    [ "$(grep -c separate err)" -eq 0 ]
    grep -q '"ring": true' r.json && grep -q '"parts": 2' r.json
}

@test "painted vertices are found by their PLY attribute" {
    printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float belly\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0\n.1 0 0 .2\n0 .1 0 .9\n0 0 .1 .6\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' > painted.ply
    [ "$("$BIN/root-select" -q --painted 'belly>0.5' painted.ply -o p.json && roots p.json)" = 2,3 ]
    [ "$("$BIN/root-select" -q --painted belly painted.ply -o p.json && roots p.json)" = 1,2,3 ]
    run -1 "$BIN/root-select" --painted red painted.ply
    [[ "$output" == *'painted.ply'*'"red"'* ]]
}

@test "a patch is allowed with a warning; -q keeps it quiet" {
    "$BIN/root-select" --indices 0 biceps.ply -o x.json 2> err
    grep -q '^root-select: warning: the roots do not separate' err
    "$BIN/root-select" -q --indices 0 biceps.ply -o x.json 2> err
    [ ! -s err ]
}

@test "selections that exclude each other or make no sense are wrong usage" {
    for words in "--indices 1 --near 0,0,0" "--indices one" "--near 1,2" "--sphere 0,0,0,-1" "--plane 0,0,0" "--box 1,2,3"; do
        code=0
        "$BIN/root-select" $words biceps.ply > out 2> err || code=$?
        [ "$code" -eq 2 ] && [ ! -s out ] && [ "$(wc -l < err)" -eq 1 ]
    done
}

@test "a selection that takes nothing, or a vertex that is not there, is an error naming the file" {
    for words in "--sphere 9,9,9,0.1" "--indices 999999" "--plane 9,9,9,0,0,1"; do
        code=0
        "$BIN/root-select" $words biceps.ply -o no.json 2> err || code=$?
        [ "$code" -eq 1 ] && [ ! -e no.json ] && grep -q '^root-select: biceps.ply: ' err
    done
}

@test "--stop-after leaves a valid document, without roots until the ring is found" {
    "$BIN/root-select" --trace t.jsonl --stop-after 3 biceps.ply -o s.json
    [ "$(wc -l < t.jsonl)" -eq 3 ]
    [ -z "$(roots s.json)" ]
    "$BIN/root-select" -q --no-history --stop-after 9999 biceps.ply -o all.json
    [ "$(roots all.json)" = "$(roots rooted.json)" ]
}

@test "new roots drop the structure and the fibres, and say so; attachments stay and are the ends" {
    "$BIN/build-structure" rooted.json | "$BIN/fiber-flow" | "$BIN/attach-detect" -q --method none \
        --pin upper=near:0,0,9,6 --pin lower=near:0,0,-9,6 -o rig.json
    "$BIN/root-select" --report r.json rig.json -o again.json 2> err
    grep -q structure err && grep -q fibers err
    [ "$(grep -c '"structure"' again.json)" -eq 0 ]
    grep -q '"attachments"' again.json && grep -q '"ends": "pins"' r.json
}

@test "known sites are the ends; the tips may be those of the eigenfunction" {
    "$EXAMPLES/arm/arm" --out sites --triangles 1000
    printf 'origin -0.0014 0.0437 0.3175\norigin 0.0276 0.0366 0.3216\ninsertion 0.0086 -0.0125 -0.0477\n' > ends.txt
    "$BIN/root-select" --ends ends.txt --report r.json sites/biceps.ply -o e.json 2> err
    [ ! -s err ]
    grep -q '"ends": "sites"' r.json
    grep -q '"parts": 2' r.json
    "$BIN/root-select" --tips eigenfunction --report r.json --trace t.jsonl sites/biceps.ply -o e.json
    grep -q '"ends": "eigenfunction"' r.json
    grep -q '"stage":"eigenfunction"' t.jsonl
    grep -q '"parts": 2' r.json
    run -2 "$BIN/root-select" --ends ends.txt --near 0,0,0 sites/biceps.ply
}

@test "the history holds the selection; --no-history leaves it out" {
    "$BIN/root-select" -q --near 0,0,0,3 biceps.ply | grep -q '"root-select".*"--near","0,0,0,3"'
    [ "$("$BIN/root-select" -q --no-history biceps.ply | grep -c '"history"')" -eq 0 ]
}

@test "a real leg muscle in millimetres" {
    mesh="$DATA/leg-vhf/meshes/VHF_Left_Muscle_TibialisAnterior_smooth.ply"
    [ -e "$mesh" ] || skip "leg-vhf is not here"
    "$BIN/root-select" --units mm --report r.json "$mesh" > leg.json 2> err
    [ ! -s err ] && grep -q '"parts": 2' r.json
}
