# attach-detect: rules, names, lists, pins, units, culling, steps, messages. A strip of 22 vertices lies between two boxes of bone:
# vertex 2i at (i,0,0), 2i+1 at (i,1,0) for i = 0..10; "left" ends at x = 1.5, "right" begins at x = 8.5, "moon" is far away.

bats_require_minimum_version 1.5.0

box() { # LOW-X HIGH-X [SCALE]: a closed box from y, z = -1 to y = 2, z = 1
    awk -v x0="$1" -v x1="$2" -v s="${3:-1}" 'BEGIN {
        print "OFF\n8 12 0"
        for (i = 0; i < 8; i++) print (i % 2 ? x1 : x0) * s, (int(i / 2) % 2 ? 2 : -1) * s, (int(i / 4) % 2 ? 1 : -1) * s
        split("0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5", v, " ")
        for (t = 0; t < 12; t++) print 3, v[3 * t + 1], v[3 * t + 2], v[3 * t + 3]
    }'
}

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    awk 'BEGIN {
        print "OFF\n22 20 0"
        for (v = 0; v < 22; v++) print int(v / 2), v % 2, 0
        for (i = 0; i < 10; i++) { print 3, 2 * i, 2 * i + 2, 2 * i + 1; print 3, 2 * i + 1, 2 * i + 2, 2 * i + 3 }
    }' > strip.off
    box -1 1.5 > left.off
    box 8.5 11 > right.off
    box 1000 1001 > moon.off
    bones="--bone left.off --bone right.off --bone moon.off"
}

attach() { "$BIN/attach-detect" "$@"; }
# The vertices of bone $1 in the document on standard input.
vertices() { tr -d ' \n' | grep -oE "\"bone\":\"$1\",(\"end\":\"[a-z]*\",)?\"vertices\":\[[0-9,]*\]" | grep -o '\[.*\]'; }

@test "contact, proximity, both" {
    [ "$(attach $bones -m contact strip.off -q | vertices left)" = "[0,1,2,3]" ]
    [ "$(attach $bones -m contact strip.off -q | vertices right)" = "[18,19,20,21]" ]
    [ "$(attach $bones -m proximity -d 1.5 strip.off -q | vertices left)" = "[0,1,2,3,4,5]" ]
    [ "$(attach $bones -d 1500.1mm strip.off -q | vertices left)" = "[0,1,2,3,4,5,6,7]" ]
    [ "$(attach $bones -d 100m strip.off -q | vertices left)" = "[0,1,2,3,4,5,6,7,8,9,10,11]" ]
}

@test "names: the file's base name, NAME=FILE, a list" {
    attach -q --bone femur=left.off --bone right.off strip.off > a.json
    [ "$(vertices femur < a.json)" = "[0,1,2,3]" ]
    [ "$(vertices right < a.json)" = "[18,19,20,21]" ]
    mkdir bones
    cp left.off right.off bones
    printf '# the bones\n\nfemur\tleft.off\r\n  right.off  \n' > bones/list
    attach -q --bones bones/list strip.off > b.json
    [ "$(vertices femur < b.json)" = "[0,1,2,3]" ]
    [ "$(vertices right < b.json)" = "[18,19,20,21]" ]
    printf 'right.off' > bones/short # no newline at its end
    [ "$(attach -q --bones bones/short strip.off | vertices right)" = "[18,19,20,21]" ]
}

@test "pins come first and need no mesh" {
    attach -q $bones --pin tail=indices:0,1,6 --pin moon=box:4.5,-1,-1,5.5,2,1 strip.off > a.json
    [ "$(vertices tail < a.json)" = "[0,1,6]" ]
    [ "$(vertices moon < a.json)" = "[10,11]" ]
    [ "$(vertices left < a.json)" = "[2,3]" ]
    [ "$(attach -q --method none --pin tail=half:9.5,0,0,1,0,0 strip.off | vertices tail)" = "[20,21]" ]
}

@test "bones in another unit and y up are converted" {
    box -1 1.5 1000 > mm.off
    [ "$(attach -q --bone mm.off --bone-units mm strip.off | vertices mm)" = "[0,1,2,3]" ]
    awk 'NR > 2 && NF == 3 { print $1, $3, -$2; next } { print }' left.off > y.off
    [ "$(attach -q --bone y.off --bone-up y strip.off -m contact | vertices y)" = "[0,1,2,3]" ]
    [ "$(attach -q --bone y.off strip.off -m contact | vertices y)" = "[0,1,2,3]" ] # the box is lower this way, but still holds them
}

@test "the report has every pair, culled or not" {
    attach -q $bones --report report.json strip.off -o out.json
    tr -d ' \n' < report.json > report
    grep -q '"attached":8,' report
    grep -q '{"bone":"left","vertices":4,"nearest":-1,"culled":false,"nearby":true,"position":0.[0-9]*,"girth":[0-9.]*,"looksSliding":false,"tip":false,"slid":{"vertices":0,"area":0},"piecesBefore":1,"pieces":1,"holesBefore":0,"holes":0,"filled":{"vertices":0,"area":0},"dropped":{"vertices":0,"area":0},"moved":{"vertices":0,"area":0}}' report
    grep -q '{"bone":"right","vertices":4,"nearest":-1,"culled":false,"nearby":true,"position":0.[0-9]*,"girth":[0-9.]*,"looksSliding":false,"tip":false' report
    attach -q --raw $bones --report raw.json strip.off -o out.json
    tr -d ' \n' < raw.json | grep -q '"looksSliding":false}'
    grep -q '{"bone":"moon","vertices":0,"nearest":990,"culled":true}' report
}

@test "a trace line for each bone, and --stop-after" {
    attach -q $bones --trace trace.jsonl strip.off -o all.json
    [ "$(wc -l < trace.jsonl)" -eq 3 ]
    grep -q '"step":2,.*"bone":"right".*"vertices":\[18,19,20,21\]' trace.jsonl
    attach -q $bones --stop-after 1 --report report.json strip.off -o one.json
    [ "$(vertices left < one.json)" = "[0,1,2,3]" ]
    [ -z "$(vertices right < one.json)" ]
    [ "$(grep -c '"culled"' report.json)" -eq 1 ]
    attach -q $bones --stop-after 0 strip.off -o none.json
    grep -q '"attachments"' none.json
    [ -z "$(vertices left < none.json)" ]
}

@test "the same bytes from a pipe, from a file, and on any number of threads" {
    attach -q --pin tip=indices:21 strip.off -o in.json
    attach -q $bones in.json -o a.json
    attach -q $bones --threads 1 < in.json > b.json
    attach -q $bones --threads 4 - < in.json > c.json
    cmp a.json b.json
    cmp a.json c.json
}

@test "other sections and members pass through; old attachments are replaced" {
    attach -q --bone left.off strip.off -o a.json
    sed 's/^{/{ "note": "kept",/' a.json > noted.json
    attach -q --bone right.off noted.json -o b.json
    grep -q '"kept"' b.json
    [ -z "$(vertices left < b.json)" ]
    [ "$(vertices right < b.json)" = "[18,19,20,21]" ]
    [ "$(grep -o '"tool"' b.json | wc -l)" -eq 2 ]
}

@test "nothing attached is no error; the warning says what would help" {
    box 0 1 | awk 'NR > 2 && NF == 3 { $3 += 5000 } { print }' > sky.off
    attach --bone moon.off --bone sky.off strip.off --method contact -o out.json 2> err
    grep -q 'warning: muscle "strip": nothing attached; the bones lie far from the muscle, but would meet it with --bone-units cm' err
    attach --bone sky.off strip.off -o out.json 2> err
    grep -q 'warning: muscle "strip": nothing attached; the nearest bone, sky, is at least 5e+06 mm away: check --bone-units' err
    box 2000 3000 > mm.off
    attach --bone mm.off strip.off -o out.json 2> err
    grep -q 'would meet it with --bone-units mm' err
    box 1 2 | awk 'NR > 2 && NF == 3 { $3 += 1.4 } { print }' > above.off
    attach --bone above.off strip.off -o out.json 2> err
    grep -q 'nearest bone, above, is .* away' err
    grep -q '"attachments"' out.json
}

@test "wrong usage" {
    run -2 attach strip.off
    run -2 attach --method none --bone left.off strip.off
    run -2 attach --method contact --distance 1 --bone left.off strip.off
    run -2 attach --distance -1 --bone left.off strip.off
    run -2 attach --bone =left.off strip.off
    run -2 attach --pin left strip.off
    for selector in foo:1 indices: indices:1,,2 indices:-1 near:1,2 near:0,0,0,0 sphere:0,0,0,0 box:1,2,3 plane:0,0,0,0,0,0 painted: 'painted:red>x'; do
        run -2 attach --pin "left=$selector" strip.off
        [ "${#lines[@]}" -eq 1 ]
    done
}

@test "bad bones are named" {
    run -1 attach --bone none.off strip.off
    [[ "$output" == *none.off* ]]
    run -1 attach --bone left.off --bone x/left.off --bone left=right.off strip.off
    run -1 attach --bone left.off --bone left=right.off strip.off
    [[ "$output" == *'"left" is given twice'* ]]
    head -c 60 left.off > cut.off
    run -1 attach --bone left.off --bone cut.off strip.off -o out.json
    [[ "$output" == *cut.off:* ]]
    [ ! -e out.json ]
    printf 'a\tb\tleft.off\n' > list
    run -1 attach --bones list strip.off
    [[ "$output" == *list:1:* ]]
    printf '# nothing\n' > list
    run -1 attach --bones list strip.off
    [[ "$output" == *"names no bone"* ]]
    run -1 attach --pin left=indices:99 strip.off
    [[ "$output" == *left* ]]
    run -1 attach --pin left=sphere:0,0,99,1 strip.off
}

@test "the dog's biceps brachii against its whole skeleton" {
    dog="$DATA/dog-dmcontrol/meshes"
    [ -e "$dog/MUSCm.biceps_brachii_L.stl" ] || skip "no dog in DATA"
    ls "$dog"/BONE*.stl > bones.txt
    attach --bones bones.txt --report report.json "$dog/MUSCm.biceps_brachii_L.stl" -o out.json -v 2> err
    # its three true sites, and the humerus that it lies on
    [ "$(grep -c 'vertices by' err)" -eq 4 ]
    for bone in Radius_L Scapula_L Ulna_L humerus_L; do grep -q "BONE$bone: .* vertices by" err; done
    [ "$(grep -c '"culled": true' report.json)" -ge 160 ]
}

# A sheet of 31 x 21 vertices, a unit apart; vertex (i, j) is 31 j + i.
sheet() {
    awk 'BEGIN {
        print "OFF\n651 1200 0"
        for (v = 0; v < 651; v++) print v % 31, int(v / 31), 0
        for (j = 0; j < 20; j++) for (i = 0; i < 30; i++) { a = 31 * j + i; print 3, a, a + 1, a + 32; print 3, a, a + 32, a + 31 }
    }' > sheet.off
}

ring() { # BONE AREA X0 X1 Y0 Y1 [ORDER]
    awk -v b="$1" -v a="$2" -v x0="$3" -v x1="$4" -v y0="$5" -v y1="$6" -v o="${7:-1 2 3 4}" 'BEGIN {
        split(o, order, " ")
        x[1] = x0; y[1] = y0; x[2] = x1; y[2] = y0; x[3] = x1; y[3] = y1; x[4] = x0; y[4] = y1
        for (i = 1; i <= 4; i++) printf "%s\t%s\t%g\t%g\t0.001\n", b, a, x[order[i]], y[order[i]]
    }'
}

@test "areas by landmarks: lines, JSON, reversed, crossing, two on one bone" {
    sheet
    ring ulna insertion 2.5 5.5 2.5 4.5 > a.tsv
    attach -q --landmarks a.tsv sheet.off -o a.json
    [ "$(vertices ulna < a.json)" = "[96,97,98,127,128,129]" ]
    grep -q '"method": "area"' a.json
    grep -q '"reasons": \[2,2,2,2,2,2\], "confidence": \[1,1,1,1,1,1\]' a.json
    { printf 'bone\tarea\tx\ty\tz\n# comment\n\n'; ring ulna insertion 2.5 5.5 2.5 4.5 "4 3 2 1"; } > b.tsv
    [ "$(attach -q --landmarks b.tsv sheet.off | vertices ulna)" = "[96,97,98,127,128,129]" ]
    echo '{ "areas": [ { "bone": "ulna", "landmarks": [[2.5,2.5,0],[5.5,2.5,0],[5.5,4.5,0],[2.5,4.5,0]] } ] }' > a.areas.json
    [ "$(attach -q --landmarks a.areas.json sheet.off | vertices ulna)" = "[96,97,98,127,128,129]" ]
    echo '{ "metersPerUnit": 0.001, "areas": [ { "bone": "ulna", "landmarks": [2500,2500,0,5500,2500,0,5500,4500,0,2500,4500,0] } ] }' > mm.json
    [ "$(attach -q --landmarks mm.json sheet.off | vertices ulna)" = "[96,97,98,127,128,129]" ]
    ring ulna insertion 2.5 5.5 2.5 4.5 "1 3 2 4" > c.tsv
    attach --landmarks c.tsv --report c.report.json sheet.off -o c.json 2> err
    grep -q 'area insertion: its boundary crosses itself in the order given' err
    grep -q '"reordered": true' c.report.json
    [ "$(vertices ulna < c.json)" = "[96,97,98,127,128,129]" ]
    ring ulna most 2.5 27.5 2.5 15.5 > d.tsv
    attach --landmarks d.tsv sheet.off -o d.json 2> err
    grep -q 'area most: it is 5[0-9] % of the muscle' err || grep -q 'area most: it is 4[0-9] % of the muscle' err
    ring ulna origin 10.5 12.5 2.5 3.5 >> a.tsv
    [ "$(attach -q --landmarks a.tsv sheet.off | vertices ulna | tr '\n' ' ')" = "[104,105] [96,97,98,127,128,129] " ]
    sed -i 's/origin/insertion 2/' a.tsv
    [ "$(attach -q --landmarks a.tsv sheet.off | vertices ulna)" = "[96,97,98,104,105,127,128,129]" ]
}

@test "areas and bones: an area's bone holds nothing else" {
    sheet
    ring left origin 2.5 5.5 2.5 4.5 > a.tsv
    attach -q --landmarks a.tsv --bone left.off --bone right.off sheet.off -o a.json
    [ "$(vertices left < a.json)" = "[96,97,98,127,128,129]" ]
    [ "$(vertices right < a.json)" = "[9,10,11,40,41,42,71,72,73]" ]
    grep -q '"method": "area", "distances"' a.json
    [ -z "$(attach -q --method area --landmarks a.tsv --bone left.off --bone right.off sheet.off | vertices right)" ]
}

@test "impossible areas are refused in one sentence" {
    sheet
    head -n 2 < <(ring ulna insertion 2.5 5.5 2.5 4.5) > two.tsv
    run -1 attach -q --area-kind boundary --landmarks two.tsv sheet.off
    [[ "$output" == *'area "insertion" on bone "ulna" has 2 landmarks; a boundary needs at least 3'* ]]
    head -n 1 two.tsv > one.tsv
    run -1 attach -q --landmarks one.tsv sheet.off
    [[ "$output" == *'area "insertion" on bone "ulna" has 1 landmark; a boundary needs at least 3, a line 2'* ]]
    ring ulna insertion 2.5 55 2.5 4.5 > far.tsv
    run -1 attach -q --landmarks far.tsv sheet.off
    [[ "$output" == *'landmark 2 lies 2.5e+04 mm off the muscle, and the limit is 10 mm'* ]]
    [ "${#lines[@]}" -eq 1 ]
    ring ulna insertion 2.5 5.5 2.5 4.5 > a.tsv
    run -1 attach -q --landmarks a.tsv --bone left.off sheet.off
    [[ "$output" == *'the landmarks name bone "ulna", which is not among the bones given'* ]]
    printf 'ulna\tinsertion\t1\t2\n' > torn.tsv
    run -1 attach -q --landmarks torn.tsv sheet.off
    [[ "$output" == *torn.tsv:1:* ]]
    printf '# nothing\n' > none.tsv
    run -1 attach -q --landmarks none.tsv sheet.off
    [[ "$output" == *"names no area"* ]]
    echo '{ "areas": [ { "landmarks": [[1,2,3]] } ] }' > no-bone.json
    run -1 attach -q --landmarks no-bone.json sheet.off
    [[ "$output" == *'areas[0].bone'* ]]
    run -2 attach --method area sheet.off --bone left.off
    run -2 attach --method none --landmarks a.tsv sheet.off
}

@test "landmarks in a row are a line; --area-kind and --line-width; its band in the report" {
    sheet
    for x in 5 8 11 14 17; do printf 'femur\tlinea\t%s.5\t10.5\t0.001\n' $x; done > row.tsv
    attach -v --landmarks row.tsv --report r.json sheet.off -o a.json 2> err
    grep -q 'area linea: a line 1.2e+04 mm long' err
    grep -q '"kind": "line"' r.json
    [ "$(grep -c 'encloses no vertex' err)" -eq 0 ]
    grep -q 'area linea: it is a line 1 mm wide, and its band is .* mm wide on average: the mesh is coarser' err
    attach -q --landmarks row.tsv --line-width 4m sheet.off -o wide.json
    [ "$(vertices femur < wide.json | tr ',' '\n' | wc -l)" -ge 52 ] # rows 9 to 12, columns 5 to 17 and what is beyond the ends
    [ "$(vertices femur < a.json | tr ',' '\n' | wc -l)" -lt 40 ]
    attach --landmarks row.tsv --area-kind boundary sheet.off -o b.json 2> err
    grep -q 'area linea: its boundary encloses no vertex' err
    head -n 2 row.tsv > two.tsv
    attach -q --landmarks two.tsv sheet.off -o two.json
    [ "$(vertices femur < two.json | tr ',' '\n' | wc -l)" -ge 8 ]
    run -2 attach --line-width 4m --pin a=indices:1 sheet.off
    run -2 attach --area-kind line --pin a=indices:1 sheet.off
    run -2 attach --area-kind boundary --line-width 4m --landmarks row.tsv sheet.off
    run -2 attach --area-kind curve --landmarks row.tsv sheet.off
}

@test "an area far off is left out with a warning, and the rest is done, status 3" {
    sheet
    { ring ulna insertion 2.5 5.5 2.5 4.5; ring femur origin 2.5 55 2.5 4.5; } > two.tsv
    run -3 --separate-stderr attach --landmarks two.tsv --report r.json sheet.off -o a.json
    [[ "$stderr" == *'area origin on bone femur is left out, and the bone holds nothing by it: landmark 2 lies 2.5e+04 mm off the muscle'* ]]
    [ "$(vertices ulna < a.json)" = "[96,97,98,127,128,129]" ]
    [ -z "$(vertices femur < a.json)" ]
    grep -q '"leftOut": true' r.json
}

# A bone under the sheet that touches it at all vertices with x <= 12 but for a hole, and at a crumb.
@test "holes are filled and crumbs dropped, and told; --raw keeps what the rules found" {
    sheet
    box -2 40 | awk 'NR > 2 && NF == 3 { print $1, $2 * 20, $3 < 0 ? -9 : 0; next } { print }' > bed.off
    awk 'NR > 2 && NF == 3 { v = NR - 3; x = v % 31; y = int(v / 31); $3 = x <= 12 && !(x == 6 && y == 8) || x == 25 && y == 10 ? 0 : 0.3 } { print }' sheet.off > lifted.off
    attach -q --raw --bone bed.off lifted.off -o raw.json
    attach -v --bone bed.off --report r.json lifted.off -o new.json 2> err
    grep -q 'bed: 2 pieces with 1 holes became 1 with 0: 1 vertices (1.06e+06 mm2) filled, 1 (1.06e+06 mm2) dropped, ' err
    tr -d ' \n' < r.json | grep -q '"piecesBefore":2,"pieces":1,"holesBefore":1,"holes":0,"filled":{"vertices":1,"area":1'
    [ "$(vertices bed < raw.json | tr ',' '\n' | wc -l)" -eq 273 ]
    vertices bed < new.json | grep -q ',254,' # the hole
    [ "$(vertices bed < raw.json | grep -c ',254,')" -eq 0 ]
    [ "$(vertices bed < new.json | grep -c '335')" -eq 0 ] # the crumb
    grep -q '+filled"' new.json
    "$BIN/rig-view" --size 120x90 raw.json new.json -o both.png # reason 7 is known
    run -2 attach --raw --method none --pin a=indices:1 sheet.off
}

@test "every step of an area can be traced and stopped at, and drawn" {
    sheet
    ring ulna insertion 2.5 5.5 2.5 4.5 > a.tsv
    attach -q --landmarks a.tsv --trace steps.jsonl sheet.off -o a.json
    [ "$(grep -c '"stage":"landmark"' steps.jsonl)" -eq 4 ]
    [ "$(grep -c '"stage":"geodesic"' steps.jsonl)" -eq 4 ]
    grep -q '"step":9,"stage":"patch","bone":"ulna","area":"insertion".*"vertices":\[96,97,98,127,128,129\]' steps.jsonl
    for n in 0 3 6; do attach -q --landmarks a.tsv --stop-after $n sheet.off -o $n.json; done
    [ -z "$(vertices ulna < 0.json)" ]
    [ -n "$(vertices ulna < 3.json)" ]
    "$BIN/rig-view" --size 120x90 0.json 3.json 6.json a.json -o steps.png
    [ -s steps.png ]
}

@test "a listed bone must be near; a named one is taken as meant" {
    sheet
    box 40 45 | awk 'NR > 2 && NF == 3 { $1 -= 9.9 } { print }' > beside.off # 0.1 m beside the sheet: near no vertex by the rule's 2 mm
    echo beside.off > list
    [ -z "$(attach -q --bones list --distance 20cm sheet.off | vertices beside)" ]
    [ "$(attach -q --bones list --distance 20cm --pairs all sheet.off | vertices beside)" = "[30,61,92]" ]
    [ "$(attach -q --bones list --distance 20cm --pair-distance 3m sheet.off | vertices beside)" = "[30,61,92]" ]
    [ "$(attach -q --bone beside.off --distance 20cm sheet.off | vertices beside)" = "[30,61,92]" ]
    attach -q --bones list --distance 20cm --trace t.jsonl --report r.json sheet.off -o out.json
    grep -q '"stage":"pair","bone":"beside".*"nearby":0' t.jsonl
    grep -q '"nearby": false' r.json
    run -2 attach --pairs all --bone beside.off sheet.off
}

@test "the history of a list holds the contents of the bones in reach, and only the names of the others" {
    printf 'left.off\nmoon.off\n' > list
    attach -q --bones list strip.off -o a.json
    box 1000 1002 > moon.off
    attach -q --bones list strip.off -o b.json
    cmp a.json b.json
    box -1 1.6 > left.off
    attach -q --bones list strip.off -o c.json
    [ "$(vertices left < c.json)" = "$(vertices left < a.json)" ]
    if [ "$(grep -o '"args": \[[^]]*' a.json)" = "$(grep -o '"args": \[[^]]*' c.json)" ]; then false; fi
    cp left.off elsewhere.off
    printf 'left\telsewhere.off\nmoon.off\n' > other
    attach -q --bones other strip.off -o d.json # the same bone in another file
    cmp c.json d.json
}

@test "voxels widen contact to the cells of the surface" {
    box 4.3 6.7 | awk 'NR > 2 && NF == 3 { $3 += 1.2 } { print }' > above.off # 0.2 above the strip
    [ -z "$(attach -q --method contact --bone above.off strip.off | vertices above)" ]
    box 4.3 6.7 > through.off
    attach -q --method contact --voxels 27 --bone through.off strip.off -o a.json
    [ "$(vertices through < a.json)" = "[10,11,12,13]" ]
    run -2 attach --method proximity --voxels 27 --bone through.off strip.off
    run -2 attach --voxels 0 --bone through.off strip.off
}

@test "neighbours: targets, reach, weights, and the document that holds them" {
    sheet
    awk 'NR > 2 && NF == 3 { $3 = 0.004 } NF == 4 { t = $3; $3 = $4; $4 = t } { print }' sheet.off > above.off # faces the sheet, 4 mm above it
    attach -q --pin ulna=indices:3 sheet.off -o in.json
    attach -v --glue above.off --soft 0.5 --minimum-distance 3mm in.json -o a.json 2> err
    grep -q 'above: 651 vertices by deep fascia' err
    grep -q '651 rows: 651 slide, 0 soft, 0 hard; 0 vertices have none; left out: 0 behind another surface, 0 beyond --targets' err
    grep -q '"target": "above", "fascia": "deep"' a.json
    grep -q '"distances": \[0.004,' a.json
    grep -q '"minimumDistances": \[0.003,' a.json
    grep -q '"weights": \[1,0.5,0,1,0.5,0,' a.json
    [ "$(vertices ulna < a.json)" = "[3]" ] # attachments stay
    attach -q --pin ulna=indices:4 a.json -o b.json
    grep -q '"target": "above"' b.json # and so do externals
    awk 'NR > 2 && NF == 3 { print 1000 * $1, 1000 * $2, 1000 * $3; next } { print }' above.off > mm.off # another unit
    attach -q --units mm --pin ulna=indices:3 mm.off -o mm.muscle.json
    attach -q --glue mm.muscle.json --soft 0.5 --minimum-distance 3mm in.json -o mm.json
    for member in vertices triangles distances; do
        [ "$(grep '"target"' mm.json | grep -o "\"$member\": [^]]*")" = "$(grep '"target"' a.json | grep -o "\"$member\": [^]]*")" ]
    done
    [ "$(attach -q --glue above.off --reach 3mm sheet.off | grep -c '"target"')" -eq 0 ]
    [ "$(attach -q --glue sheet.off=above.off --skeleton env=above.off sheet.off | grep -c '"target"')" -eq 2 ]
    run -1 attach --glue above.off --slide nosuchmap sheet.off
    [[ "$output" == *"no painted map of that name"* ]]
    run -1 attach --glue above.off --glue x/../above.off sheet.off
    run -1 attach --glue none.off sheet.off
    printf 'OFF\n0 0 0\n' > empty.off
    run -1 attach -q --skeleton empty.off sheet.off
    [ "${#lines[@]}" -eq 1 ]
    run -2 attach --slide 1 --pin ulna=indices:3 sheet.off
    run -2 attach --slide 2 --glue above.off sheet.off
    run -2 attach --reach 1 --pin ulna=indices:3 sheet.off
    run -2 attach sheet.off
    attach -q --envelope env=above.off sheet.off -o new.json
    attach -q --skeleton env=above.off sheet.off -o old.json # the old name
    cmp <(sed 's/--skeleton/--envelope/' old.json) new.json
    run -2 attach --skeleton above.off --envelope above.off sheet.off
}

# layer HEIGHT FILE: the sheet, facing down, HEIGHT metres above it
layer() { awk -v z="$1" 'NR > 2 && NF == 3 { $3 = z } NF == 4 { t = $3; $3 = $4; $4 = t } { print }' sheet.off > "$2"; }

@test "neighbours of a whole folder: near by box, the nearest that nothing hides, the muscle itself skipped" {
    sheet
    mkdir rigs
    layer 0.003 near.off
    layer 0.004 far.off
    layer 0.3 away.off
    for name in sheet near far away; do attach -q --pin "ulna=indices:3" "$name.off" -o "rigs/$name.muscle.json"; done
    attach -v --muscles rigs rigs/sheet.muscle.json -o a.json --report r.json 2> err
    grep -q '4 muscles listed: 2 searched, 1 passed over as their boxes are out of reach, 1 the muscle itself' err
    [ "$(grep -c '"target"' a.json)" = 1 ] # far lies behind near
    grep -q '"target": "near", "fascia": "deep"' a.json
    grep -q '"hidden": 651,' r.json
    grep -q '"passedOver": 1,' r.json
    grep -q '"without": 0,' r.json
    grep -Eq '"meanDistance": 0.00(3|2999)' r.json
    attach -q --muscles rigs --hidden rigs/sheet.muscle.json -o b.json
    [ "$(grep -o '"target": "[a-z]*"' b.json | tr '\n' ' ')" = '"target": "far" "target": "near" ' ]
    attach -q --muscles rigs --hidden --targets 1 rigs/sheet.muscle.json -o c.json
    [ "$(grep '"target"' c.json)" = "$(grep '"target"' a.json)" ]
    printf '# two of them\nNEAR\trigs/near.muscle.json\nrigs/sheet.muscle.json\n' > list.txt
    attach --muscles list.txt rigs/sheet.muscle.json -o d.json 2> err
    [ ! -s err ]
    [ "$(grep '"target"' d.json | sed 's/NEAR/near/')" = "$(grep '"target"' a.json)" ]
    sed 's/"name": "sheet"/"name": "twin"/' rigs/sheet.muscle.json > twin.muscle.json
    attach --muscles rigs twin.muscle.json 2>&1 > /dev/null | grep -q '"sheet" of the lists has the same mesh, and was taken for it'
    printf '%s\n' near.off > bones.txt
    attach -q --glue far.off --obstacles bones.txt sheet.off | grep -q '"target"' && return 1
    attach -q --glue far.off --obstacles bones.txt --hidden sheet.off | grep -q '"target": "far"'
}

@test "neighbours: what other muscles' documents hold beside the mesh changes no byte" {
    sheet
    mkdir rigs
    layer 0.003 near.off
    for name in sheet near; do attach -q --pin "ulna=indices:3" "$name.off" -o "rigs/$name.muscle.json"; done
    attach -q --muscles rigs rigs/sheet.muscle.json -o a.json
    attach -q --muscles rigs rigs/near.muscle.json -o near.json
    mv near.json rigs/near.muscle.json # now with externals of its own
    attach -q --muscles rigs --threads 3 rigs/sheet.muscle.json -o b.json
    cmp a.json b.json
}

@test "neighbours: what is wrong with a list is said" {
    sheet
    mkdir rigs empty
    layer 0.003 near.off
    for name in sheet near; do attach -q --pin "ulna=indices:3" "$name.off" -o "rigs/$name.muscle.json"; done
    run -1 attach --muscles empty rigs/sheet.muscle.json
    [[ "$output" == *"no rig (*.muscle.json) is in it"* ]]
    printf '# none\n' > none.txt
    run -1 attach --muscles none.txt rigs/sheet.muscle.json
    [[ "$output" == *"names no muscle"* ]]
    sed -i 's/"name": "near"/"name": "sheet"/' rigs/near.muscle.json # an older state of the same, or two of one name
    run -1 attach --muscles rigs rigs/sheet.muscle.json
    [[ "$output" == *"rigs/near.muscle.json: it has the name of the muscle at hand"* ]]
    layer 0.004 twin.off
    attach -q --pin "ulna=indices:3" near.off -o rigs/near.muscle.json
    attach -q --pin "ulna=indices:3" twin.off | sed 's/"name": "twin"/"name": "near"/' > rigs/twin.muscle.json
    run -1 attach --muscles rigs rigs/sheet.muscle.json
    [[ "$output" == *'"near" is given twice'* ]]
    rm rigs/twin.muscle.json
    echo '{' > rigs/broken.muscle.json
    run -1 attach --muscles rigs rigs/sheet.muscle.json
    [[ "$output" == *"rigs/broken.muscle.json"* ]]
    rm rigs/broken.muscle.json
    awk 'NR > 2 && NF == 3 { print 1000 * $1, 1000 * $2, 1000 * $3 + 3000; next } { print }' sheet.off > rigs/mm.off # a wrong unit: metres
    printf 'rigs/mm.off\n' > mm.txt
    attach --muscles mm.txt rigs/sheet.muscle.json -o a.json 2> err
    grep -q 'none of the 1 muscles listed is within reach' err
    grep -q 'check their units' err
}

@test "neighbours: weights painted, by rule, uniform" {
    sheet
    layer 0.003 near.off
    attach -q --pin "ulna=indices:0" sheet.off -o in.json
    run -1 attach --glue near.off --weights painted in.json
    [[ "$output" == *"none of the painted maps slide, soft and hard"* ]]
    {
        printf 'ply\nformat ascii 1.0\nelement vertex 651\nproperty double x\nproperty double y\nproperty double z\nproperty double slide\n'
        printf 'property double hard\nelement face 1200\nproperty list uchar int vertex_indices\nend_header\n'
        awk 'NR > 2 && NF == 3 { n++; print $0, n == 1 ? 0 : n == 2 ? 7 : 0.5, n == 1 ? 0 : 1 } NF == 4' sheet.off
    } > painted.ply
    attach --glue near.off --weights painted painted.ply -o a.json --report r.json 2> err
    grep -q '"weights": \[0,0,0,1,0,1,0.5,0,1,' a.json
    grep -q '1 painted weights are not within 0 to 1' err
    grep -q '1 of 651 rows have no weight' err
    grep -q '"slide": 650,' r.json
    grep -q '"soft": 0,' r.json
    grep -q '"hard": 649,' r.json # slide takes all of vertex 1
    grep -q '"idle": 1,' r.json
    attach -q --glue near.off --weights rule in.json -o b.json --report r.json
    grep -q '"weights": \[0,1,0,' b.json # held where the bone holds
    grep '"target"' b.json | grep -q ',1,1,0,' # slides far from it
    attach -q --glue near.off --weights rule --tendons hard --tendon-length 1mm in.json -o c.json
    grep -q '"weights": \[0,0,1,' c.json
    run -1 attach --glue near.off --weights rule sheet.off
    [[ "$output" == *"weights by rule need attachments"* ]]
    run -2 attach --glue near.off --weights rule --slide 1 in.json
    run -2 attach --glue near.off --tendons hard in.json
    run -2 attach --weights rule --pin ulna=indices:3 in.json
}

@test "a bone that is open holds what is in it" {
    box -1 1.5 | awk 'NR == 2 { print 8, 10, 0; next } NF == 4 && ++t > 2 || NF < 4 { print }' > open.off # without its bottom
    [ "$(attach -q --method contact --bone open.off strip.off | vertices open)" = "[0,1,2,3]" ]
}

@test "one bone alone, a slight grip and speckles are warned of; the document and the status stay" {
    # a tube of 60 rings of 24 vertices, 1 apart: vertex 24 r + k
    awk 'BEGIN {
        print "OFF\n1440 2832 0"
        for (r = 0; r < 60; r++) for (k = 0; k < 24; k++) print 4 * cos(k * 0.2617993877991494), 4 * sin(k * 0.2617993877991494), r
        for (r = 0; r < 59; r++) for (k = 0; k < 24; k++) {
            a = 24 * r + k; b = 24 * r + (k + 1) % 24
            print 3, a, b, a + 24; print 3, b, b + 24, a + 24
        }
    }' > tube.off
    lower="--pin lower=half:0,0,2.5,0,0,-1" upper="--pin upper=half:0,0,56.5,0,0,1"
    warnings() { attach --units mm --method none "$@" tube.off -o out.json 2>&1 > /dev/null | grep warning || true; }
    [ -z "$(warnings $lower $upper)" ]
    [[ "$(warnings $lower)" == *"is held by one bone only, lower, "*"--bone"* ]]
    [ "$(warnings $lower $upper --pin dot=indices:700 | wc -l)" -eq 1 ]
    [[ "$(warnings $lower $upper --pin dot=indices:700)" == *": dot holds less than 1 % of the end"*"--distance"* ]]
    speckles=$(seq 600 2 622 | tr '\n' ','; seq 672 2 694 | paste -sd,)
    [[ "$(warnings $lower $upper --pin dots=indices:$speckles)" == *": dots holds scattered vertices, not an area; "*"--landmarks"* ]]
    # four fingers are no speckles: rows of eight
    fingers=$(for k in 0 6 12 18; do for r in 20 21 22 23 24 25 26 27; do echo $((24 * r + k)); done; done | sort -n | paste -sd,)
    [ -z "$(warnings $lower $upper --pin hand=indices:$fingers)" ]
    run -0 --separate-stderr attach -q --units mm --method none $lower --pin dots=indices:$speckles tube.off -o quiet.json
    [ -z "$stderr" ]
    attach --units mm --method none $lower --pin dots=indices:$speckles tube.off -o said.json
    cmp quiet.json said.json
}

@test "a bone whose faces stand twice, or are partly flipped, is warned of; a clean one and an open one are not" {
    python3 - << 'END'
import math
def ring(z, r, n=16): return [(r * math.cos(2 * math.pi * k / n), r * math.sin(2 * math.pi * k / n), z) for k in range(n)]
def tube(rings, n=16):
    v = [p for r in rings for p in r]; f = []
    for i in range(len(rings) - 1):
        for k in range(n):
            a, b = i * n + k, i * n + (k + 1) % n
            f += [(a, b, a + n), (b, b + n, a + n)]
    return v, f
def caps(v, f, n=16):
    last = len(v) - n
    v += [(v[0][0] - 10, 0, v[0][2]), (v[0][0] - 10, 0, v[last][2])]
    return v, f + [(len(v) - 2, (k + 1) % n, k) for k in range(n)] + [(len(v) - 1, last + k, last + (k + 1) % n) for k in range(n)]
def write(name, v, f):
    with open(name, "w") as out:
        for p in v: out.write("v %g %g %g\n" % p)
        for t in f: out.write("f %d %d %d\n" % tuple(i + 1 for i in t))
v, f = caps(*tube([ring(2.0 * i, 10) for i in range(20)]))
write("bone.obj", v, f)
write("open.obj", v, f[:-16])
write("twice.obj", v, f + [t[::-1] for t in f[::2]])
write("flipped.obj", v, [t[::-1] if i % 3 == 0 else t for i, t in enumerate(f)])
write("muscle.obj", [(x + 18, y, z) for x, y, z in v], f)
END
    "$BIN/mesh-clean" -q --units mm muscle.obj -o muscle.json
    for bone in bone open twice flipped; do
        "$BIN/attach-detect" muscle.json --bone "b=$bone.obj" -o "$bone.json" 2> "$bone.err"
        case $bone in
        twice | flipped) grep -q 'warning: bone "b": .*mesh-clean mends it' "$bone.err" ;;
        *) ! grep -q 'mesh-clean mends it' "$bone.err" || { cat "$bone.err"; false; } ;;
        esac
    done
    "$BIN/attach-detect" muscle.json --method proximity --bone b=twice.obj -o near.json 2> err # asks for no inside
    ! grep -q 'mesh-clean mends it' err
    cat > s.scene.json << 'END'
{"format": "sinew-scene", "version": 1, "rate": 24, "frames": [0, 1], "metersPerUnit": 0.001, "bones": [{"name": "b", "mesh": "flipped.obj"}],
 "muscles": [{"name": "m", "rig": "bone.json"}]}
END
    "$BIN/simulate" s.scene.json --contact --log log 2> err
    grep -q 'warning: bone "b": .*mesh-clean mends it' err
}

@test "a muscle and bones whose headers say different spaces are refused, in every format that says it, and in scenes; what says nothing is taken" {
    python3 - << 'END'
import struct
corners = [(x, y, z) for x in (0, .02) for y in (0, .02) for z in (0, .2)]
faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
for space in ("RAS", "LPS", ""):
    word, name = "SPACE=" + space if space else "nothing", space or "none"
    with open(name + ".ply", "w") as out:
        out.write("ply\nformat ascii 1.0\ncomment %s\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\nelement face 12\n"
                  "property list uchar int vertex_indices\nend_header\n" % word)
        for c in corners: out.write("%g %g %g\n" % c)
        for f in faces: out.write("3 %d %d %d\n" % f)
    with open(name + ".obj", "w") as out:
        out.write("# by a scanner; %s\n" % word)
        for c in corners: out.write("v %g %g %g\n" % c)
        for f in faces: out.write("f %d %d %d\n" % tuple(i + 1 for i in f))
    with open(name + ".off", "w") as out:
        out.write("OFF\n# %s\n8 12 0\n" % word)
        for c in corners: out.write("%g %g %g\n" % c)
        for f in faces: out.write("3 %d %d %d\n" % f)
    with open(name + ".vtk", "w") as out:
        out.write("# vtk DataFile Version 3.0\n3D Slicer output. %s\nASCII\nDATASET POLYDATA\nPOINTS 8 double\n" % word)
        for c in corners: out.write("%g %g %g\n" % c)
        out.write("POLYGONS 12 48\n")
        for f in faces: out.write("3 %d %d %d\n" % f)
    with open(name + ".stl", "wb") as out:
        out.write(("3D Slicer output. " + word).encode().ljust(80, b"\0") + struct.pack("<I", 12))
        for f in faces: out.write(struct.pack("<12fH", 0, 0, 0, *(v for i in f for v in corners[i]), 0))
END
    for ending in ply obj off vtk stl; do
        "$BIN/mesh-clean" -q --units m RAS.$ending > muscle.json
        grep -q '"space": "RAS"' muscle.json
        for other in ply obj off vtk stl; do
            run -1 "$BIN/attach-detect" muscle.json --bone a=none.$other --bone b=LPS.$other -o x.json
            [[ "$output" == *'in the space RAS'*'"b" in LPS'* ]] || { echo "$ending $other $output"; false; }
            [ ! -e x.json ]
        done
    done
    for bone in RAS none; do "$BIN/attach-detect" -q muscle.json --bone a=$bone.stl -o $bone.json; done
    "$BIN/mesh-clean" -q --units m none.ply -o plain.json
    ! grep -q '"space"' plain.json
    run -1 "$BIN/attach-detect" plain.json --bone a=RAS.stl --bone b=LPS.ply -o x.json
    [[ "$output" == *'"a" is in the space RAS, and "b" in LPS'* ]]
    "$BIN/mesh-clean" -q --units m LPS.ply -o lps.json
    run -1 "$BIN/attach-detect" muscle.json --glue lps.json -o x.json
    [[ "$output" == *'in the space RAS'*LPS* ]]
    mkdir obstacles
    cp LPS.stl obstacles
    run -1 "$BIN/attach-detect" muscle.json --glue plain.json --obstacles obstacles -o x.json
    [[ "$output" == *'in the space RAS'*LPS* ]]
    run -1 "$BIN/scene-build" none.json -b a=LPS.obj -o s.scene.json
    [[ "$output" == *'in the space RAS'*LPS* ]]
    sed 's/"space": "RAS"/"space": "ARS"/' muscle.json > wrong.json
    run -1 "$BIN/attach-detect" wrong.json --bone a=none.ply
    [[ "$output" == *wrong.json*LPS*RAS* ]]
}

# real KIND: the muscles of a body whose names have KIND, each cleaned and beside all bones of that body: DIR/NAME.json, DIR/NAME.report
real() {
    set=$DATA/body-bp3d-low
    [ -f "$set/manifest.tsv" ] || skip "no real anatomy at $set"
    awk -F '\t' -v d="$set/meshes" '$2 == "bone" { print $3 "\t" d "/" $1 }' "$set/manifest.tsv" > bones.tsv
    awk -F '\t' -v k="$1" '$2 == "muscle" && $3 ~ k { print $1 }' "$set/manifest.tsv" | while read -r file; do
        "$BIN/mesh-clean" -q --repair full --units mm "$set/meshes/$file" -o clean.json
        "$BIN/attach-detect" -q --bones bones.tsv --bone-units mm clean.json --report "${file%.obj}.report" -o "${file%.obj}.json"
    done
}
# BONE PATTERN: how many vertices the bones of that name hold in a document; let go: how many of a report
holds() { jq --arg b "$2" '[.attachments[] | select(.bone | test($b)) | .vertices[]] | length' "$1.json"; }
slid() { jq --arg b "$2" '[.pairs[] | select(.bone | test($b)) | .slid.vertices // 0] | add' "$1.report"; }

@test "the long head of a real biceps slides along its groove and ends on the scapula and the radius" {
    real 'Long head of (left|right) biceps brachii'
    for m in FJ443_Long_head_of_left_biceps_brachii FJ128_Long_head_of_right_biceps_brachii; do
        [ "$(slid $m humerus)" -ge 10 ]
        [ "$(holds $m humerus)" -lt "$(slid $m humerus)" ]
        [ "$(holds $m scapula)" -gt 0 ]
        [ "$(holds $m radius)" -gt 0 ]
        # with fibres from tip to tip what is left of the humerus is known to be passed
        "$BIN/root-select" -q $m.json | "$BIN/build-structure" -q | "$BIN/fiber-flow" -q | "$BIN/fiber-fill" -q -n 10 --tips > rigged.json
        "$BIN/attach-detect" -q --bones bones.tsv --bone-units mm rigged.json -o again.json
        [ "$(holds again humerus)" -eq 0 ]
        [ "$(holds again scapula)" -gt 0 ]
    done
}

@test "real radial extensors of the wrist slide on the radius and end on the metacarpals that their meshes reach" {
    real 'extensor carpi radialis'
    for m in FJ205_Right_extensor_carpi_radialis_brevis FJ262_Left_extensor_carpi_radialis_longus FJ799_Right_extensor_carpi_radialis_longus; do
        [ "$(holds $m radius)" -eq 0 ]
        [ "$(slid $m radius)" -ge 7 ]
        [ "$(holds $m metacarpal)" -gt 0 ]
        [ "$(holds $m humerus)" -gt 0 ]
    done
    # this mesh ends at the wrist: its radius keeps the end of the bed
    [ "$(slid FJ601_Left_extensor_carpi_radialis_brevis radius)" -gt 0 ]
    [ "$(holds FJ601_Left_extensor_carpi_radialis_brevis radius)" -gt 0 ]
}
