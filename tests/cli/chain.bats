# The chain as a whole: what the ends of a muscle are taken from, in any order of the tools and of the bones.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then return 1; fi; }

setup() { cd "$BATS_TEST_TMPDIR"; fan > fan.obj; areas > areas.tsv; "$BIN/mesh-clean" -q --units mm fan.obj -o clean.json; }

# a sheet 120 wide at the top and 20 at the bottom, 80 high and 10 thick, in mm
fan() {
    awk 'function id(s, i, j) { return s * (n + 1) * (k + 1) + i * (k + 1) + j + 1 }
        function face(a, b, c) { print "f", a, b, c }
        function side(i, j, p, q) { face(id(0, i, j), id(0, p, q), id(1, p, q)); face(id(0, i, j), id(1, p, q), id(1, i, j)) }
        BEGIN {
            n = 24; k = 16
            for (s = 0; s < 2; s++) for (i = 0; i <= n; i++) for (j = 0; j <= k; j++)
                print "v", 120 * i / n + (40 - 100 * i / n) * j / k, 10 * s, -80 * j / k
            for (i = 0; i < n; i++) for (j = 0; j < k; j++) {
                face(id(0, i, j), id(0, i + 1, j + 1), id(0, i, j + 1)); face(id(0, i, j), id(0, i + 1, j), id(0, i + 1, j + 1))
                face(id(1, i, j), id(1, i, j + 1), id(1, i + 1, j + 1)); face(id(1, i, j), id(1, i + 1, j + 1), id(1, i + 1, j))
            }
            for (i = 0; i < n; i++) { side(i + 1, 0, i, 0); side(i, k, i + 1, k) }
            for (j = 0; j < k; j++) { side(0, j, 0, j + 1); side(n, j + 1, n, j) }
        }'
}

# landmarks around areas on the sheet's face y = 0: two heads on two bones at the top, one insertion at the bottom
areas() {
    awk 'function row(bone, t, f) { printf "%s\tarea\t%g\t0\t%g\n", bone, 40 * t + (120 - 100 * t) * f, -80 * t }
        function quad(bone, f, g, t, u) { row(bone, t, f); row(bone, t, g); row(bone, u, g); row(bone, u, f) }
        BEGIN { quad("iliac", 0.02, 0.4, 0.03, 0.3); quad("sacrum", 0.6, 0.98, 0.03, 0.3); quad("femur", 0.05, 0.95, 0.85, 0.97) }'
}

attach() { "$BIN/attach-detect" -q --method area --landmarks "$@"; }
rig() { "$BIN/root-select" -q "$@" | "$BIN/build-structure" -q | "$BIN/fiber-flow" -q | "$BIN/fiber-fill" -n 20; }
section() { jq -c ".$2" "$1"; }

@test "the fibres are the same whether attachments come first or last, once the later tools have run again" {
    attach areas.tsv clean.json > attached.json
    rig attached.json > first.json
    rig clean.json | "$BIN/attach-detect" --method area --landmarks areas.tsv --report r.json -o last.json 2> err
    grep -q 'warning: roots, structure, fiber directions and fibers were made without these attachments.*run root-select, build-structure, fiber-flow and fiber-fill again' err
    [ "$(jq -c .runAgain r.json)" = '["root-select","build-structure","fiber-flow","fiber-fill"]' ]
    refute [ "$(section first.json fibers)" = "$(section last.json fibers)" ]
    rig last.json > again.json
    [ "$(section first.json attachments)" = "$(section again.json attachments)" ]
    section first.json fibers > a; section again.json fibers > b
    cmp a b
}

@test "nothing is said where the attachments are those that were there, or nothing hangs on them" {
    attach areas.tsv clean.json > attached.json
    rig attached.json > first.json
    "$BIN/attach-detect" --method area --landmarks areas.tsv --report r.json first.json -o same.json 2> err
    refute grep -q 'run .* again' err
    [ "$(jq .stale r.json)" = null ]
    "$BIN/root-select" -q --near 40,0,-40,6 clean.json -o hand.json
    "$BIN/attach-detect" --method area --landmarks areas.tsv hand.json -o out.json 2> err
    refute grep -q 'run .* again' err
}

@test "areas that are the same but called other ends are other attachments: what to run again is said" {
    sed '/femur/s/area/insertion/; s/\tarea/\torigin/' areas.tsv > told.tsv
    sed '/femur/s/area/origin/; s/\tarea/\tinsertion/' areas.tsv > turned.tsv
    attach told.tsv clean.json | rig > told.json
    "$BIN/attach-detect" --method area --landmarks turned.tsv --report r.json told.json -o turned.json 2> err
    grep -q 'run root-select, build-structure, fiber-flow and fiber-fill again' err
    [ "$(jq -c '.stale | length' r.json)" = 4 ]
    "$BIN/attach-detect" --method area --landmarks told.tsv told.json -o same.json 2> err
    refute grep -q 'run .* again' err
}

@test "the order and the names of the bones change nothing: two heads are one end" {
    attach areas.tsv clean.json | rig > first.json
    for bones in "femur sacrum iliac" "sacrum iliac femur" "sacrum femur iliac"; do
        for bone in $bones; do grep "^$bone" areas.tsv; done > other.tsv
        attach other.tsv clean.json > other.json
        rig other.json > second.json
        [ "$(section first.json roots)" = "$(section second.json roots)" ]
        section first.json fibers > a; section second.json fibers > b
        cmp a b
    done
    "$BIN/root-select" --report r.json other.json > /dev/null
    [ "$(jq -c '[.ends, .endsKnown, .right]' r.json)" = '["areas",2,true]' ]
}

@test "areas at one end are that end; the tip is the other, and a warning says so, of every tool" {
    grep -v femur areas.tsv > heads.tsv
    grep femur areas.tsv > one.tsv
    for file in heads.tsv one.tsv; do
        attach $file clean.json > attached.json
        "$BIN/root-select" attached.json -o rooted.json --report r.json 2> err
        grep -q 'warning: the ends are taken from areas and a tip: areas: ' err
        [ "$(jq -c '[.ends, .endsKnown]' r.json)" = '["areas",1]' ]
        "$BIN/build-structure" -q rooted.json -o built.json
        "$BIN/fiber-flow" --field harmonic built.json --report r.json -o flow.json 2> err
        grep -q 'warning: the ends are taken from areas and a tip' err
        "$BIN/fiber-fill" -n 4 flow.json --report r.json -o filled.json 2> err || [ $? -eq 3 ]
        grep -q 'warning: the ends are taken from areas and a tip' err
        [ "$(jq -r .ends r.json)" = areas ]
    done
    [ "$("$BIN/fiber-flow" -v built.json 2>&1 > /dev/null | grep -c 'by the field tree')" -eq 1 ]
}

# named FILE TOP1 TOP2 BOTTOM: the three areas by these names; ends of the fibres: mean z of their first points, of their last
named() { awk -F '\t' -v OFS='\t' -v a="$2" -v b="$3" -v c="$4" '{ $2 = $1 == "iliac" ? a : $1 == "sacrum" ? b : c; print }' areas.tsv > "$1"; }
mean_ends() { jq -r '.fibers.polylines | [(map(.points[2]) | add / length), (map(.points[-1]) | add / length)] | map(round | tostring) | join(" ")' "$1"; }

@test "a name of one end alone is obeyed: origins are where fibres begin, insertions where they end, and two origins are one end" {
    named a.tsv "origin 1" "origin 2" other
    attach a.tsv clean.json | rig > a.json
    read -r first last < <(mean_ends a.json)
    [ "$first" -gt -25 ] && [ "$last" -lt -65 ]
    named b.tsv insertion insertion other
    attach b.tsv clean.json | rig > b.json
    read -r first last < <(mean_ends b.json)
    [ "$first" -lt -65 ] && [ "$last" -gt -25 ]
    # the same where that is all there is, and where nothing but a pin is at the other end
    grep -v femur b.tsv > c.tsv
    attach c.tsv clean.json | { rig 2> err || [ $? -eq 3 ]; } > c.json
    grep -q 'warning: the ends are taken from areas and a tip: areas: no origin is among them' err
    read -r first last < <(mean_ends c.json)
    [ "$first" -lt -65 ] && [ "$last" -gt -25 ]
    attach c.tsv --pin p=box:0,-1,-80,120,11,-74 clean.json | rig > d.json
    read -r first last < <(mean_ends d.json)
    [ "$first" -lt -65 ] && [ "$last" -gt -25 ]
    # two small heads wide apart are farther from each other than from the insertion
    awk 'function quad(bone, name, x) { for (i = 0; i < 4; i++)
            printf "%s\t%s\t%g\t0\t%g\n", bone, name, x + (i % 3 ? 18 : 0), i < 2 ? -2 : -12 }
        BEGIN { quad("iliac", "origin 1", 6); quad("sacrum", "origin 2", 94) }' > wide.tsv
    grep femur a.tsv >> wide.tsv
    attach wide.tsv clean.json | rig > wide.json
    read -r first last < <(mean_ends wide.json)
    [ "$first" -gt -20 ] && [ "$last" -lt -65 ]
}

@test "the areas of one bone may be at both ends, and fibres run from the one to the other; names in doubt are told" {
    named a.tsv "deep origin" Origin_2 insertions
    sed 's/^[a-z]*/one/' a.tsv > one.tsv
    "$BIN/attach-detect" --method area --landmarks one.tsv clean.json --report r.json -o one.json 2> err
    refute grep -q 'end of the muscle' err
    [ "$(jq -r '[.attachments[] | .bone + " " + .end] | join(", ")' one.json)" = "one origin, one insertion" ]
    [ "$(jq -c '[.areas[].end]' r.json)" = '["origin","origin","insertion"]' ]
    rig one.json > rigged.json
    read -r first last < <(mean_ends rigged.json)
    [ "$first" -gt -25 ] && [ "$last" -lt -65 ]
    attach a.tsv clean.json | rig > a.json
    [ "$(section a.json fibers)" = "$(section rigged.json fibers)" ]
    # the other way round they run the other way
    named b.tsv insertion insertion origin
    sed 's/^[a-z]*/one/' b.tsv > one.tsv
    attach one.tsv clean.json | rig > rigged.json
    read -r first last < <(mean_ends rigged.json)
    [ "$first" -lt -65 ] && [ "$last" -gt -25 ]
    named c.tsv orgin "no origin" "origin to insertion"
    "$BIN/attach-detect" --method area --landmarks c.tsv clean.json --report r.json -o c.json 2> err
    [ "$(grep -c 'warning: area .* its name is taken for no end of the muscle' err)" -eq 3 ]
    [ "$(jq -c '[.areas[].endDoubtful]' r.json)" = '[true,true,true]' ]
    [ "$(jq -c '[.attachments[].end]' c.json)" = '[null,null,null]' ]
}

@test "an end written into the document is obeyed, whatever the attachment came by" {
    "$BIN/attach-detect" -q --method none --pin top=box:0,-1,-12,120,11,0 --pin bottom=box:0,-1,-80,120,11,-70 clean.json -o pins.json
    for reason in 1 3; do
        for origin in top bottom; do
            jq -c --arg o $origin --argjson r $reason '.attachments[] |= (.end = (if .bone == $o then "origin" else "insertion" end)
                | .reasons |= map($r))' pins.json | rig > told.json
            read -r first last < <(mean_ends told.json)
            if [ $origin = top ]; then [ "$first" -gt -15 ] && [ "$last" -lt -65 ]; else [ "$first" -lt -65 ] && [ "$last" -gt -15 ]; fi
        done
    done
}

@test "an area that overlaps one before it says what it loses, and to whom" {
    { cat areas.tsv; printf 'tibia\tlow\t%s\t0\t%s\n' 44 -64 76 -64 70 -72 46 -72; } > more.tsv
    "$BIN/attach-detect" --method area --landmarks more.tsv clean.json --report r.json -o more.json 2> err || [ $? -eq 3 ]
    grep -q 'area low on bone tibia: [0-9]* of its [0-9]* vertices stay with area area on bone femur, which comes first' err
    lost=$(jq '.areas[3].lost.vertices' r.json)
    [ "$lost" -gt 0 ]
    [ "$(jq '.areas[3].vertices' r.json)" -eq $((lost + $(jq '[.attachments[] | select(.bone == "tibia") | .vertices] | add' r.json))) ]
    sed 's/^femur/tibia/' areas.tsv | grep tibia > same.tsv
    cat areas.tsv same.tsv > all.tsv
    run -3 "$BIN/attach-detect" --method area --landmarks all.tsv clean.json -o all.json
    [[ $output == *"area area on bone tibia holds nothing: all of its "*"vertices stay with area area on bone femur, which comes first"* ]]
    "$BIN/attach-detect" --method area --landmarks areas.tsv clean.json -o plain.json 2> err
    refute grep -q 'stay with' err
}

@test "attachments that have changed are told by their bones" {
    grep -v sacrum areas.tsv > two.tsv
    attach two.tsv clean.json | rig 2> /dev/null > two.json
    { grep -v iliac areas.tsv | sed '/femur/s/-77.6/-75/'; } > other.tsv
    "$BIN/attach-detect" --method area --landmarks other.tsv two.json -o out.json 2> err
    grep -q 'warning: roots, .* were made with other attachments (new: sacrum; changed: femur; gone: iliac): run root-select' err
    "$BIN/attach-detect" --method area --landmarks areas.tsv two.json -o out.json 2> err
    grep -q 'were made with other attachments (new: sacrum): run root-select' err
}

@test "sites come before areas, areas before pins, pins before contact; auto is none of them by hand" {
    "$BIN/attach-detect" -q --method none --pin a=box:0,-1,-12,120,11,0 --pin b=box:0,-1,-80,120,11,-74 clean.json -o pins.json
    printf 'origin 60 0 0\ninsertion 50 0 -80\n' > sites.txt
    ends() { "$BIN/root-select" "$@" --report r.json > /dev/null; jq -r .ends r.json; }
    [ "$(ends pins.json)" = pins ]
    attach areas.tsv clean.json > attached.json
    [ "$(ends attached.json)" = areas ]
    attach areas.tsv --pin p=near:60,0,-40,3 clean.json > both.json
    [ "$(ends both.json)" = areas ]
    [ "$(ends --ends sites.txt attached.json)" = sites ]
    [ "$(ends --ends auto attached.json)" = areas ]
    [ "$(ends clean.json)" = tips ]
    [ "$(jq -r .endsWhy r.json)" = "no attachments are known" ]
}

@test "contact is trusted where it holds compact ends, else the tips are taken and -v says why" {
    box() { # X1 X2 Y1 Y2 Z1 Z2
        awk -v b="$*" 'BEGIN { split(b, c, " "); for (i = 0; i < 8; i++) print "v", c[1 + i % 2], c[3 + int(i / 2) % 2], c[5 + int(i / 4)]
            n = split("1 3 4 1 4 2 5 6 8 5 8 7 1 2 6 1 6 5 3 7 8 3 8 4 1 5 7 1 7 3 2 4 8 2 8 6", f, " ")
            for (i = 1; i <= n; i += 3) print "f", f[i], f[i + 1], f[i + 2] }'
    }
    box -5 125 -5 15 -12 5 > top.obj
    box 30 70 -5 15 -90 -70 > bottom.obj
    "$BIN/attach-detect" -q --bone-units mm --bone top=top.obj --bone bottom=bottom.obj clean.json -o held.json
    "$BIN/root-select" held.json --report r.json > /dev/null
    [ "$(jq -c '[.ends, .right]' r.json)" = '["attachments",true]' ]
    box 30 70 -5 15 -50 -30 > middle.obj
    "$BIN/attach-detect" -q --bone-units mm --bone top=top.obj --bone middle=middle.obj clean.json -o belly.json
    "$BIN/root-select" -v belly.json --report r.json > /dev/null 2> err
    [ "$(jq -r .ends r.json)" = tips ]
    grep -q 'the ends are taken from tips: attachments: all lie at one end or along the belly' err
    refute grep -q 'warning: the ends' err
    # where one bone alone holds both places the muscle lies on it
    { cat top.obj; sed 's/^f.*//' bottom.obj; awk '/^f/ { print "f", $2 + 8, $3 + 8, $4 + 8 }' bottom.obj; } > both.obj
    "$BIN/attach-detect" -q --bone-units mm --bone both=both.obj clean.json -o one.json
    "$BIN/root-select" -v one.json --report r.json > /dev/null 2> err
    [ "$(jq -r .ends r.json)" = tips ]
    grep -q 'the ends are taken from tips: attachments: all are on one bone, both' err
}

# a ring of 60 x 40 mm, 5 thick: whatever parts it in two must cut both of its arms
torus() {
    awk 'function id(i, j) { return (i % n) * k + j % k + 1 }
        BEGIN {
            n = 36; k = 8
            for (i = 0; i < n; i++) for (j = 0; j < k; j++) {
                a = 6.283185307179586 * i / n; b = 6.283185307179586 * j / k
                print "v", (60 + 5 * cos(b)) * cos(a), (40 + 5 * cos(b)) * sin(a), 5 * sin(b)
            }
            for (i = 0; i < n; i++) for (j = 0; j < k; j++) {
                print "f", id(i, j), id(i + 1, j), id(i + 1, j + 1)
                print "f", id(i, j), id(i + 1, j + 1), id(i, j + 1)
            }
        }'
}

@test "where no ring runs around the muscle between its ends, as on a handle, a warning and the report say so" {
    torus > torus.obj
    "$BIN/root-select" --units mm torus.obj --report r.json -o rooted.json 2> err
    grep -q 'warning: the surface has handles (genus 1)' err
    grep -q 'warning: no ring runs around the muscle between its ends' err
    [ "$(jq -c '[.right, .fallback]' r.json)" = '[false,true]' ]
    "$BIN/root-select" clean.json --report r.json -o rooted.json 2> err # the fan has one
    [ "$(jq -c '[.right, .fallback]' r.json)" = '[true,false]' ]
    refute grep -q 'no ring runs' err
}
