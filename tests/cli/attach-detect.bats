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
vertices() { tr -d ' \n' | grep -o "\"bone\":\"$1\",\"vertices\":\[[0-9,]*\]" | grep -o '\[.*\]'; }

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
    grep -q '{"bone":"left","vertices":4,"nearest":-1,"culled":false,"nearby":true,"position":0.[0-9]*,"girth":[0-9.]*,"looksSliding":false}' report
    grep -q '{"bone":"right","vertices":4,"nearest":-1,"culled":false,"nearby":true,"position":0.[0-9]*,"girth":[0-9.]*,"looksSliding":false}' report
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
    grep -q 'warning: nothing attached; the bones lie far from the muscle, but would meet it with --bone-units cm' err
    attach --bone sky.off strip.off -o out.json 2> err
    grep -q 'warning: nothing attached; the nearest bone, sky, is at least 5e+06 mm away: check --bone-units' err
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
