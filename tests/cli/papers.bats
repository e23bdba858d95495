# The recipes of the papers' experiments at a small size: they run anywhere, and their figures say what the schemes do.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    PATH=$BIN:$PATH
    RECIPES=$BATS_TEST_DIRNAME/../../share/examples/papers
    export EXAMPLES PATH
}

# chart NAME: OUT/NAME.svg and .png are pictures
chart() {
    grep -q '<svg' "$1.svg"
    [ "$(head -c 8 "$1.png" | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ]
    # curves, not only axes
    [ "$(grep -c '<path' "$1.svg")" -ge 4 ]
}

@test "fig. 7 of K21: iterations move the points less and less" {
    "$RECIPES/k21-displacement.sh" -o out -t 1000 -f 3 -i 12 > said
    chart out/k21-displacement
    [ "$(wc -l < out/k21-displacement.tsv)" -eq 13 ]
    awk -F '\t' 'NR > 1 { for (i = 2; i <= 5; i++) { if (NR == 2) first[i] = $i; if (NR == 11) tenth[i] = $i } ratio = $4 / $2 }
        END { mm = ratio; for (i = 2; i <= 5; i++) if (!(tenth[i] > 0 && tenth[i] < 0.5 * first[i])) exit 1
            exit !(mm > 5 && mm < 12) }' out/k21-displacement.tsv # an edge of about 8 mm
    grep -q 'iteration  10 moves a point by' said
}

@test "table 1 of K21: a time for every number of triangles and iterations" {
    "$RECIPES/k21-time.sh" -o out -t "2500 700" -f 5 -i "1 60" > said
    chart out/k21-time
    # how long, and which of them is the longer, is for the machine to say, and for the table to show; cells are there
    cat out/k21-time.tsv said
    awk -F '\t' 'NF == 5 && NR > 1 { rows++; had[$1 > 1000, $2]++; for (i = 3; i <= 5; i++) if ($i !~ /^[0-9]+[.][0-9]+$/) bad = 1 }
        END { exit !(!bad && rows == 4 && had[1, 1] == 1 && had[1, 60] == 1 && had[0, 1] == 1 && had[0, 60] == 1) }' out/k21-time.tsv
    [ "$(grep -c '^k21-time: .* ms kohout, .* ms guarded, .* ms by default$' said)" -eq 4 ]
}

@test "fig. 11 of K21: the default keeps the volume better than the published scheme, which keeps it within a per cent here" {
    "$RECIPES/k21-volume.sh" -o out -t 1000 -f 10 > said
    chart out/k21-volume
    awk -F '\t' 'NR > 1 { for (i = 3; i <= 5; i++) { e = $i - 1; if (e < 0) e = -e; if (e > worst[i]) worst[i] = e } }
        END { exit !(NR == 12 && worst[3] < 0.01 && worst[3] > 1e-4 && worst[4] < 1e-4 && worst[5] < worst[3] && $2 == 10) }' out/k21-volume.tsv
}

@test "fig. 8 of K21: edges along the fibres yield where anisotropy is on" {
    "$RECIPES/k21-anisotropy.sh" -o out -t 1000 -f 6 -i "3 10" > said
    chart out/k21-anisotropy
    awk -F '\t' '$1 == "kohout" { rows++; if (!($5 > $3 + 1e-3 && $7 > 0.05)) exit 1 }
        $1 == "guarded" { rows++; if (!($7 < 0.05)) exit 1 } # rigid rows: a softer spring is as rigid
        END { exit rows != 4 }' out/k21-anisotropy.tsv
    for scheme in kohout guarded; do [ "$(head -c 4 out/k21-anisotropy-$scheme.png | tail -c 3)" = PNG ]; done
}

@test "a bone that jumps by 15 degrees a frame stretches the muscle, and no scheme blows up" {
    "$RECIPES/k21-anisotropy.sh" -o out -t 4000 -f 8 -i "1 20" -j "radius 0,0,0.3 0,-1,0 15" > said
    refute grep -q 'blew up' said
    for scheme in kohout guarded; do [ "$(head -c 4 out/k21-anisotropy-$scheme.png | tail -c 3)" = PNG ]; done
    awk -F '\t' 'NF == 7 && NR > 1 { rows++; if (!($2 >= 1 && $3 > 1.1 && $3 < 2.5)) exit 1 } END { exit rows != 4 }' out/k21-anisotropy.tsv
    chart out/k21-anisotropy
}

@test "a run that ends with edges off by ten times their length, or not finite, is told as blown up" {
    eval "$(sed -n '/^wild()/,/^}/p' "$RECIPES/common.sh")"
    for rms in 10.5 1e9 null; do
        echo '{"frame":1,"errors":{"mesh":{"rms":'$rms',"max":3},"dihedral":{"rms":1,"max":2}}}' > log.jsonl
        wild log.jsonl
    done
    sed 's/null/0.3/' log.jsonl > tame.jsonl
    run -1 wild tame.jsonl
}

# table CASE ...: the cases of tests/kohout-table, with $HINGES and $ITERATIONS; it exits with 1 where one fails
table() {
    "$BATS_TEST_DIRNAME/../kohout-table" "$BIN" "$BIN/../tests/numerics/hinge_rules" "$EXAMPLES" "$DATA" out "$@" > said
    [ "$(awk -F '\t' '$14 == "passed"' said | wc -l)" -eq $(($(wc -l < said) - 1)) ]
}

@test "kohout at its paper's setting: the arm's muscles stay finite and keep their volume" {
    HINGES="published printed" ITERATIONS="1 3" table arm-4000
    [ "$(wc -l < said)" -eq 13 ]
    [ "${CONFIG:-release}" = release ] || return 0 # the slow builds look at the fewest
    HINGES="published printed" ITERATIONS="1 3 10" table arm-17000
    [ "$(wc -l < said)" -eq 19 ]
    HINGES=published ITERATIONS="10 100" table arm-4000
    [ "$(wc -l < said)" -eq 7 ]
}

@test "kohout at its paper's setting: so do the tibialis anterior and the soleus of a leg" {
    [ -e "$DATA/leg-vhf/meshes/VHF_Left_Muscle_Soleus_smooth.ply" ] || skip "no real anatomy at $DATA"
    HINGES="published printed" ITERATIONS=1 table tibialis-down
    [ "$(wc -l < said)" -eq 3 ]
    [ "${CONFIG:-release}" = release ] || return 0
    HINGES="published printed" ITERATIONS="1 3 10" table tibialis-down soleus-up
    [ "$(wc -l < said)" -eq 13 ]
    HINGES=published ITERATIONS=100 table tibialis-down
    [ "$(wc -l < said)" -eq 2 ]
}

@test "fig. 9 of K21: three resolutions by decimation" {
    "$RECIPES/k21-resolutions.sh" -o out -t "1500 1000 500" -f 4 -i 10 > said
    chart out/k21-resolutions
    awk -F '\t' '/^L0/ { n0 = $2 } /^L1/ { n1 = $2 } /^L2/ { n2 = $2; i[++k] = $3 }
        /^L/ { if (!($8 < 1e-4 && $8 > -1e-4 && $7 > 0)) exit 1 }
        END { exit !(n0 > 1300 && n1 <= 1000 && n1 > 900 && n2 <= 500 && n2 > 400 && i[1] == 100 && i[2] == 10) }' out/k21-resolutions.tsv
    [ "$(head -c 4 out/k21-resolutions-guarded.png | tail -c 3)" = PNG ]
}

@test "figs 7 and 17 of R18: the goal volumes are reached" {
    "$RECIPES/r18-volume-gain.sh" -o out -t 1000 -f 9 > said
    chart out/r18-volume-gain
    awk -F '\t' 'NR > 1 { goal = $1 == "rest" ? 1 : $1; for (i = 2; i <= 4; i += 2) { e = $i / goal - 1; if (e > 0.01 || e < -0.01) exit 1 } rows++ }
        END { exit rows != 5 }' out/r18-volume-gain.tsv
    for picture in romeo-front romeo-right guarded-front guarded-right; do
        [ "$(head -c 4 out/r18-volume-gain-$picture.png | tail -c 3)" = PNG ]
    done
    run -1 cmp -s out/r18-volume-gain-guarded-front.png out/r18-volume-gain-guarded-right.png
}

@test "a muscle of one's own, in millimetres, between a bone and a pin" {
    "$EXAMPLES/arm/arm" --out arm -t 1000 > /dev/null
    "$RECIPES/k21-volume.sh" -o metres -f 4 -j "ulna 0,0,0.3 0,-1,0 1" arm/brachialis.ply --bone humerus=arm/humerus.ply --bone ulna=arm/ulna.ply > said
    grep -q 'by default' said
    # the same in millimetres
    for part in brachialis humerus ulna; do
        mesh-clean -q --units mm --no-manifold --no-outward "arm/$part.ply" -o "$part.obj"
        awk '$1 == "v" { $2 *= 1000; $3 *= 1000; $4 *= 1000 } { print }' "$part.obj" > "arm/$part-mm.obj"
    done
    "$RECIPES/k21-volume.sh" -o mm -u mm -f 4 -j "ulna 0,0,300 0,-1,0 1" arm/brachialis-mm.obj --bone humerus=arm/humerus-mm.obj \
        --bone ulna=arm/ulna-mm.obj > said
    paste metres/k21-volume.tsv mm/k21-volume.tsv | awk -F '\t' 'NR > 1 { e = $3 - $8; if (e < 0) e = -e; if (e > 1e-3) exit 1; n++ } END { exit n != 5 }'
    "$RECIPES/k21-volume.sh" -o pinned -f 2 -j "low 0,0,0.3 0,-1,0 1" arm/brachialis.ply --bone humerus=arm/humerus.ply \
        --pin low=half:0,0,0.02,0,0,-1 > said
    [ -s pinned/k21-volume.tsv ]
}

# collision: OUT/k21-collision.tsv has all cases; voxels and fields keep vertices out; memory is as the paper counts, and less
collision() {
    [ "$(head -c 4 "$1/k21-collision.png" | tail -c 3)" = PNG ]
    awk -F '\t' -v bones="$2" 'NR > 1 { rows++; cells[$1] = $2; kb[$1] = $3; published[$1] = $4; deep[$1] = $6; if (!($5 > 0 && $8 > 0.9 && $8 < 100)) exit 1 }
        END { if (rows != 8 || cells["voxels-64"] != bones * 262144 || published["voxels-64"] != bones * 256 || kb["voxels-64"] != bones * 32) exit 1
            if (!(cells["n-max"] <= bones * 262144 && cells["n-max"] > bones * 240000 && cells["n-max-8"] > 7 * cells["n-max"])) exit 1
            if (deep["none"] != "nan" || deep["voxels-64"] > 0.001 || deep["stop-64"] > 0.001 || deep["default"] > 0.001) exit 1 }' "$1/k21-collision.tsv"
}

@test "fig. 3 of K21: collision by voxels and by fields, on the generated arm" {
    DATA=nowhere "$RECIPES/k21-collision.sh" -o out -t 1000 -f 6 > said
    grep -q 'no real anatomy at nowhere' said
    collision out 4
}

@test "fig. 3 of K21: the same on a leg" {
    [ -e "$DATA/leg-vhf/meshes/VHF_Left_Muscle_PeroneusLongus_smooth.ply" ] || skip "no real anatomy at $DATA"
    [ "${CONFIG:-release}" = release ] || return 0
    DATA=$DATA "$RECIPES/k21-collision.sh" -o out -t 4000 -f 4 > said
    refute grep -q 'no real anatomy' said
    collision out 4
}

# picture FILE ...: they are PNGs, and not of one colour
picture() { for f; do [ "$(head -c 4 "$f" | tail -c 3)" = PNG ] && [ "$(wc -c < "$f")" -gt 4000 ] || { echo "$f"; return 1; }; done; }

@test "fig. 2 of K21: the stages are four pictures, no two alike" {
    "$RECIPES/k21-stages.sh" -o out -t 1000 -f 5 > said
    picture out/k21-stages-a.png out/k21-stages-b.png out/k21-stages-c.png out/k21-stages-d.png
    [ "$(cksum out/k21-stages-?.png | cut -d ' ' -f 1 | sort -u | wc -l)" -eq 4 ]
    [ "$(wc -l < out/k21-stages.tsv)" -eq 7 ]
}

@test "fig. 3 of K21: voxels as meshes that close, as many cells as asked for, and no more than the bone's volume and its surface" {
    "$EXAMPLES/arm/arm" --out arm -t 1000 > /dev/null
    "$EXAMPLES/papers/voxels" arm/humerus.ply 32 v.obj > figures
    mesh-clean -q --check v.obj > checked || true
    IFS='	' read -r x y z cells boundary inside faces published kb < figures
    [ "$x$y$z" = 323232 ] && [ "$cells" -eq 32768 ] && [ "$published" -eq 32 ] && [ "$kb" -eq 4 ]
    [ "$(grep -c '^f ' v.obj)" -eq $((2 * faces)) ]
    # the mesh of the cells encloses what they do: the sum over its triangles is boundary + inside cells, exactly closed
    awk -v n=$((boundary + inside)) '/^v / { x[++k] = $2; y[k] = $3; z[k] = $4; for (c = 2; c <= 4; c++) { if (k == 1 || $c < lo[c]) lo[c] = $c; if (k == 1 || $c > hi[c]) hi[c] = $c } }
        /^f / { a = $2; b = $3; c = $4; v += (x[a] * (y[b] * z[c] - z[b] * y[c]) + y[a] * (z[b] * x[c] - x[b] * z[c]) + z[a] * (x[b] * y[c] - y[b] * x[c])) / 6 }
        END { cell = (hi[2] - lo[2]) * (hi[3] - lo[3]) * (hi[4] - lo[4]) / 32768; e = v / (n * cell) - 1; exit !(e < 1e-4 && e > -1e-4) }' v.obj
    run -1 "$EXAMPLES/papers/voxels" none.ply 32 v.obj
    for n in 0 513 total:0 x; do run -2 "$EXAMPLES/papers/voxels" arm/humerus.ply "$n" v.obj; done
    DATA=nowhere "$RECIPES/k21-voxels.sh" -o out > said
    grep -q 'no real anatomy at nowhere' said
    picture out/k21-voxels-scapula.png out/k21-voxels-humerus.png
    awk -F '\t' 'NR > 1 { rows++; if ($2 == "64" && $6 != 262144 || $6 > 2097152 || $7 < 100 || $10 < 7 * $11) exit 1 } END { exit rows != 6 }' out/k21-voxels.tsv
}

@test "fig. 6 of K21: a hundred fibres" {
    "$RECIPES/k21-fibers.sh" -o out -t 1000 > said
    picture out/k21-fibers.png
    awk -F '\t' 'NR > 1 { exit !($1 == "biceps" && $3 == 100 && $5 > 50 && $5 <= $4 && $4 <= $6 && $6 < 500 && $7 > 0) }' out/k21-fibers.tsv
}

@test "figs 4, 5 and 10 of K21: ways to fix vertices, and what becomes of them" {
    "$RECIPES/k21-attachments.sh" -o out -t 1000 -f 5 > said
    picture out/k21-attachments.png out/k21-attachments-kohout.png out/k21-attachments-default.png
    # a longer reach fixes no fewer; all are held by both bones
    awk -F '\t' 'NR > 1 { rows++; n[$1] = $4; if ($3 != 2 || $4 < 3 || !($6 > 0.5 && $6 < 10 && $9 > 0.5 && $9 < 10)) exit 1 }
        END { exit !(rows == 5 && n["mean-edge"] >= n["1mm"] && n["1mm"] >= n["0.5mm"] && n["mean-edge"] > n["0.5mm"]) }' out/k21-attachments.tsv
    "$RECIPES/k21-variants.sh" -o out -t 1000 -f 5 > said
    picture out/k21-variants.png
    awk -F '\t' 'NR > 1 { rows++; if (!($3 > 0.5 && $3 < 10 && $6 != "nan")) exit 1; deep[$1] = $6 } END { exit !(rows == 4 && deep["default"] <= 0.01 && deep["areas-ignore"] >= deep["areas"]) }' out/k21-variants.tsv
}

@test "figs 12 to 15 of K21: fibre lengths, smoothed, and those of the blend beside them" {
    "$RECIPES/k21-lengths.sh" -o out -t 1000 -f 30 > said
    for kind in kohout default; do
        chart out/k21-lengths-$kind
        picture out/k21-lengths-$kind-shapes.png
    done
    # the forearm swings away from the shoulder's front: half a metre of the arm, lengths in mm, 31 rows each, at rest as the blend
    awk -F '\t' 'NR > 1 { rows[$1]++; if (!($3 > 50 && $3 <= $4 && $4 <= $5 && $5 < 1000 && $8 == 100)) exit 1; if ($2 == 0 && ($4 - $6)^2 > 1e-6) exit 1; end[$1] = $2 }
        END { exit !(rows["kohout"] == 31 && rows["default"] == 31 && end["kohout"] == 30) }' out/k21-lengths.tsv
    # smoothed: as the paper smooths, not as the frames are
    "$BIN/simulate" -q out/muscle.scene.json --lengths raw.tsv --log /dev/null
    run -1 cmp -s raw.tsv out/default.lengths.tsv
    /usr/bin/python3 - << 'END'
read = lambda f: [l.split("\t") for l in open(f).read().splitlines()]
raw, out = read("raw.tsv"), read("out/default.lengths.tsv")
k, j = raw[0].index("muscle.7"), out[0].index("muscle.7")
l = [float(r[k]) for r in raw[1:]]
for _ in range(5): l = [l[0]] + [(a + 4 * b + c) / 6 for a, b, c in zip(l, l[1:], l[2:])] + [l[-1]]
assert max(abs(a - float(r[j])) for a, r in zip(l, out[1:])) < 1e-7
END
}

@test "table 2 of K21: steps a second" {
    "$RECIPES/k21-rates.sh" -o out -t 1000 -f 5 > said
    chart out/k21-rates
    awk -F '\t' 'NR > 1 { exit !($1 == "biceps" && $2 > 800 && $3 ~ /^[0-9.]+$/ && $4 ~ /^[0-9.]+$/) }' out/k21-rates.tsv
}

@test "every recipe tells its line of the table: paper, kohout, default" {
    "$RECIPES/k21-volume.sh" -o out -t 1000 -f 3 > said
    awk -F '\t' 'NF == 4 && $1 ~ /^fig. 11/ && $2 == "< 1" && $3 > 0 && $4 > 0 { n++ } END { exit !(n == 1 && NR == 1) }' out/claims.tsv
    "$RECIPES/k21-volume.sh" -o out -t 1000 -f 3 > said # anew, not a second time
    [ "$(wc -l < out/claims.tsv)" -eq 1 ]
}

@test "a muscle of the dog's hip: bones are obstacles, areas hold it at both" {
    [ -f "$DATA/dog-dmcontrol/dog.xml" ] || skip "no dog-dmcontrol in DATA"
    [ "${CONFIG:-release}" = release ] || return 0
    export HIP=$PWD/hip
    "$RECIPES/../hip/dog.sh" "$DATA/dog-dmcontrol" hip > /dev/null
    "$RECIPES/k21-volume.sh" -o out -m iliacus -f 10 > said
    chart out/k21-volume
    awk -F '\t' 'NR > 1 { for (i = 3; i <= 5; i++) { e = $i - 1; if (e > 0.02 || e < -0.02) exit 1 } } END { exit !(NR == 12 && $2 == 20) }' out/k21-volume.tsv
    grep -q '"contacts":[1-9]' out/default.jsonl
    /usr/bin/python3 -c '
import json
a = json.load(open("out/muscle.muscle.json"))["attachments"]; assert {x["bone"] for x in a} == {"Pelvis", "Femoris_L"} and all(x["method"] == "area" for x in a), a
b = json.load(open("out/muscle.scene.json"))["bones"]; assert [x["name"] for x in b if "joint" in x] == ["Femoris_L"] and len(b) == 11, b'
    # its joint is that of the model: the hinge takes the femur where the motion does
    "$RECIPES/k21-stages.sh" -o s -m iliacus -f 5 > said
    simulate -q s/muscle.scene.json --frames 0:5 --bone-frames hinge --log /dev/null -o f
    simulate -q hip/hip.scene.json --frames 0:5 --bone-frames model --log /dev/null -o g
    /usr/bin/python3 - << 'END'
import struct
def last(f):
    d = open(f, "rb").read(); n, = struct.unpack("<i", d[16:20]); return struct.unpack(f"<{3*n}f", d[-12*n:])
a, b = last("hinge/Femoris_L.pc2"), last("model/Femoris_L.pc2")
assert len(a) == len(b) and max(abs(x - y) for x, y in zip(a, b)) < 1e-6
END
    run -2 "$RECIPES/k21-volume.sh" -o out -m biceps
    [[ "$output" == *"the hip has adductor_longus"* ]]
}

@test "all of them into one folder: index, table, what was not run, and what failed" {
    [ -f "$DATA/dog-dmcontrol/dog.xml" ] && [ -d "$DATA/leg-vhf/meshes" ] || skip "no dog-dmcontrol and leg-vhf in DATA"
    [ "${CONFIG:-release}" = release ] || return 0
    ONLY='k21-volume-iliacus' "$RECIPES/papers.sh" "$DATA" out > said
    tail -n 1 said | grep -q 'out/index.html: 30 experiments, 1 lines in the table, [0-9]* s, [0-9]* s with what was kept'
    [ "$(grep -c '<h3' out/index.html)" -eq 30 ]
    [ "$(grep -c '^<p>Not run.</p>' out/index.html)" -eq 29 ]
    picture out/k21-volume-iliacus/k21-volume.png
    grep -q 'img src="k21-volume-iliacus/k21-volume.png"' out/index.html
    awk -F '\t' 'NR == 2 { exit !(NF == 5 && $1 ~ /^fig. 11/ && $5 == "k21-volume-iliacus") }' out/table.tsv
    # kept; and one that fails is told, in the index too, and with status 1
    mkdir fake
    printf '#!/bin/sh\necho no picture today >&2\nexit 1\n' > fake/rig-view
    chmod +x fake/rig-view
    ONLY='k21-stages' PATH=$PWD/fake:$PATH run -1 "$RECIPES/papers.sh" -k "$DATA" out
    [[ "$output" == *"k21-stages (fig. 2):"*"status 1: no picture today"* ]]
    grep -q 'Ended with status 1' out/index.html
    [ "$(wc -l < out/table.tsv)" -ge 2 ]
}

@test "what is missing or wrong is told" {
    for recipe in "$RECIPES"/k21-*.sh "$RECIPES"/r18-*.sh; do
        "$recipe" -h | grep -q 'RECIPE'
        [ -x "$recipe" ]
    done
    run -2 "$RECIPES/k21-volume.sh" -o out arm.ply --bone humerus=h.ply
    [[ "$output" == *"needs -j"* ]]
    run -2 "$RECIPES/k21-volume.sh" -x
    run -2 "$RECIPES/k21-volume.sh" -o out -u feet
    run -1 "$RECIPES/k21-volume.sh" -o out -j "a 0,0,0 1,0,0 1" none.ply --bone a=none.ply
    [ ! -e out/k21-volume.tsv ]
    HIP='' DATA=nowhere run -1 "$RECIPES/k21-volume.sh" -o out -m iliacus
    [[ "$output" == *"there is no dog at nowhere"* ]]
    run -2 "$RECIPES/k21-volume.sh" -o out -m iliacus arm.ply --bone a=b.ply
    run -1 "$RECIPES/papers.sh" nowhere out
    [[ "$output" == *"there is no dog-dmcontrol/dog.xml in nowhere"* ]]
    run -2 "$RECIPES/papers.sh" nowhere
}

@test "without gnuplot the figures are there, and the status says that the charts are not" {
    mkdir bin
    ln -s /usr/bin/* bin/
    rm -f bin/gnuplot*
    PATH=$BIN:$PWD/bin run -3 "$RECIPES/k21-volume.sh" -o out -t 1000 -f 3
    [[ "$output" == *"there is no gnuplot"* ]]
    [ "$(wc -l < out/k21-volume.tsv)" -eq 5 ]
    [ ! -e out/k21-volume.svg ]
    PATH=$BIN:$PWD/bin run -1 "$RECIPES/papers.sh" "$DATA" all
    [[ "$output" == *"gnuplot"* ]]
}
