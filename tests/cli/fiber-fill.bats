# fiber-fill: fibres inside, templates, ends, lines, weights, partial results, impossible requests.

bats_require_minimum_version 1.5.0

setup_file() {
    "$EXAMPLES/arm/arm" --out "$BATS_FILE_TMPDIR" --triangles 1000
    "$BIN/root-select" -q "$BATS_FILE_TMPDIR/biceps.ply" | "$BIN/build-structure" | "$BIN/fiber-flow" -o "$BATS_FILE_TMPDIR/built.json"
}

setup() {
    cd "$BATS_FILE_TMPDIR" || exit 1
}

value() { sed -n "s/^ *\"$2\": *\([^,]*\),*\$/\1/p" "$1" | head -n 1; }

@test "a hundred fibres of fifteen segments, none outside, every end reached" {
    "$BIN/fiber-fill" --report r.json built.json -o f.json 2> err
    [ ! -s err ]
    [ "$(value r.json fibers)" -eq 100 ]
    [ "$(value r.json vertices)" -eq 1600 ]
    [ "$(value r.json outsideAfter)" -eq 0 ]
    [ "$(value r.json endLoops)" -ge 3 ]
    [ "$(value r.json endLoopsReached)" -eq "$(value r.json endLoops)" ]
    [ "$(grep -c '"pennation"' f.json)" -eq 100 ]
    grep -q '"directions"' f.json
}

@test "--fibers and --segments are obeyed; filling again replaces" {
    "$BIN/fiber-fill" -n 7 --segments 4 built.json -o few.json
    "$BIN/fiber-fill" -n 9 --segments 4 few.json | "$BIN/fiber-fill" -n 7 --segments 4 --report r.json --no-history -o again.json
    [ "$(value r.json fibers)" -eq 7 ]
    [ "$(value r.json vertices)" -eq 35 ]
    "$BIN/fiber-fill" -n 7 --segments 4 --no-history built.json | cmp - again.json
}

@test "any number of threads, files and pipes give the same bytes" {
    "$BIN/fiber-fill" --threads 1 built.json -o 1.json
    "$BIN/fiber-fill" --threads 3 < built.json > 3.json
    cmp 1.json 3.json
    "$BIN/fiber-fill" --threads 1 -n 5 --embedding 1.embedding built.json -o 1.json
    "$BIN/fiber-fill" --threads 3 -n 5 --embedding 3.embedding built.json -o 3.json
    cmp 1.embedding 3.embedding
}

@test "every template fills; pennate fibres are oblique" {
    for template in parallel pennate bipennate fan curved; do
        "$BIN/fiber-fill" -q --template $template --report $template.report built.json -o $template.json
        [ "$(value $template.report fibers)" -eq 100 ]
        [ "$(value $template.report outsideAfter)" -eq 0 ]
    done
    awk -v a="$(value parallel.report meanPennationDegrees)" -v b="$(value pennate.report meanPennationDegrees)" 'BEGIN { exit !(a + 5 < b) }'
    awk -v a="$(value parallel.report meanLength)" -v b="$(value pennate.report meanLength)" 'BEGIN { exit !(b < a) }'
}

@test "lengths and angles of the document are read again, and bad ones refused" {
    "$BIN/fiber-fill" -n 3 --no-history built.json -o three.json
    "$BIN/fiber-fill" -n 3 built.json -o lines.vtp
    "$BIN/fiber-flow" --no-history three.json -o flowed.json
    [ "$(grep -o '"length": *[0-9.e-]*' flowed.json)" = "$(grep -o '"length": *[0-9.e-]*' three.json)" ]
    [ "$(grep -o '"length": *[0-9.e-]*' three.json | head -n 1 | sed 's/.*: *//')" = \
        "$(sed -n '/Name="length"/{n;p;q}' lines.vtp)" ]
    sed 's/"length": *[0-9.e-]*/"length": -1/' three.json > bad.json
    run -1 "$BIN/fiber-flow" bad.json
    [[ "$output" == *length* ]]
}

@test "VTP and OBJ outputs hold the fibres as lines" {
    "$BIN/fiber-fill" -n 12 built.json -o lines.vtp
    "$BIN/fiber-fill" -n 12 built.json -o lines.obj
    grep -q 'NumberOfPoints="192"' lines.vtp
    grep -q 'NumberOfLines="12"' lines.vtp
    [ "$(grep -c '^v ' lines.obj)" -eq 192 ]
    [ "$(grep -c '^l ' lines.obj)" -eq 12 ]
    grep -q '^l 177 .* 192$' lines.obj
    # the same coordinates
    sed -n '/Name="Points"/,/DataArray>$/p' lines.vtp | grep -v '<' | cmp - <(sed -n 's/^v //p' lines.obj)
}

@test "a VTP file is read by VTK" {
    /usr/bin/python3 -c 'import vtkmodules' 2> /dev/null || skip "no VTK for Python here"
    "$BIN/fiber-fill" -n 12 built.json -o lines.vtp
    /usr/bin/python3 - << 'END'
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
r = vtkXMLPolyDataReader()
r.SetFileName("lines.vtp")
r.Update()
o = r.GetOutput()
assert o.GetNumberOfLines() == 12 and o.GetNumberOfPoints() == 192
assert o.GetCellData().GetArray("length").GetValue(0) > 0
END
}

@test "given ends and given curves" {
    echo '{"format": "sinew-fiber-ends", "version": 1, "origin": [0, 1, 2], "insertion": [400, 401]}' > ends.json
    "$BIN/fiber-fill" --ends ends.json --report r.json built.json > /dev/null
    [ "$(value r.json ends)" = '"given"' ]
    echo '{"format": "sinew-fiber-template", "version": 1, "curves": [{"points": [0.5,0.5,0, 0.9,0.5,0.5, 0.5,0.5,1]}]}' > t.json
    "$BIN/fiber-fill" --template-file t.json --report r.json built.json -o f.json
    [ "$(value r.json fibers)" -eq 100 ]
    grep -q 'sha256:' f.json
}

@test "superficial fibres bend the template, from either kind of file and in either direction" {
    # lines on the surface of a tube 10 cm long and 1 cm thick, a quarter of a turn from end to end
    python3 - << 'END'
import json, math
rings, around = 61, 24
point = lambda r, k: (0.01 * math.cos(2 * math.pi * k / around), 0.01 * math.sin(2 * math.pi * k / around), 0.1 * r / (rings - 1))
with open("tube.obj", "w") as f:
    for r in range(rings):
        for k in range(around): f.write("v %r %r %r\n" % point(r, k))
    f.write("v 0 0 0\nv 0 0 0.1\n")
    v = lambda r, k: r * around + k % around + 1
    for k in range(around):
        for r in range(rings - 1): f.write("f %d %d %d\nf %d %d %d\n" % (v(r, k), v(r, k + 1), v(r + 1, k + 1), v(r, k), v(r + 1, k + 1), v(r + 1, k)))
        f.write("f %d %d %d\nf %d %d %d\n" % (rings * around + 1, v(0, k + 1), v(0, k), rings * around + 2, v(rings - 1, k), v(rings - 1, k + 1)))
lines = [[point(r, k + around / 4 * (r / (rings - 1))) for r in range(2, rings - 2, 2)] for k in range(0, around, 2)]
open("up.json", "w").write(json.dumps({"polylines": [{"points": [x for p in l for x in p]} for l in lines]}))
with open("down.obj", "w") as f:
    for l in lines:
        for p in reversed(l): f.write("v %r %r %r\n" % p)
    for i, l in enumerate(lines): f.write("l " + " ".join(str(i * len(l) + k + 1) for k in range(len(l))) + "\n")
END
    "$BIN/fiber-fill" --report plain.report tube.obj -o plain.json
    "$BIN/fiber-fill" --bend-to up.json --report bent.report --threads 1 tube.obj -o bent.json
    "$BIN/fiber-fill" --bend-to down.obj --no-history --threads 2 tube.obj -o down.json
    "$BIN/fiber-fill" --bend-to up.json --no-history tube.obj | cmp - down.json
    [ "$(value bent.report outsideAfter)" -eq 0 ]
    [ "$(value bent.report superficialFibers)" -eq 12 ]
    grep -q '"--bend-to"' bent.json
    python3 - << 'END'
import json, math
# turn about the axis from a tenth to nine tenths of the length, of the fibres in the outer half
def turns(name):
    out = []
    for line in json.load(open(name))["fibers"]["polylines"]:
        p = [line["points"][i:i + 3] for i in range(0, len(line["points"]), 3)]
        if math.hypot(*p[7][:2]) < 0.005: continue
        a, b = (min(p, key=lambda q: abs(q[2] - z)) for z in (0.01, 0.09))
        turn = math.degrees(math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]))
        out.append(turn / (b[2] - a[2]) * 0.1)
    return sorted(out)
plain, bent = turns("plain.json"), turns("bent.json")
assert len(bent) > 30
sign = 1 if bent[len(bent) // 2] > 0 else -1
assert max(abs(t) for t in plain) < 15, plain
assert abs(sign * bent[len(bent) // 2] - 90) < 12, bent
assert all(60 < sign * t < 120 for t in bent[len(bent) // 10:-len(bent) // 10]), bent
END
}

@test "weights that keep fewer say what they drop" {
    "$BIN/fiber-fill" -n 10 --embedding all.embedding --report all.report built.json > /dev/null
    "$BIN/fiber-fill" -n 10 --embedding few.embedding --mvc-cut 3e-3 --report few.report built.json > /dev/null
    [ "$(stat -c %s few.embedding)" -lt "$(stat -c %s all.embedding)" ]
    awk -v e="$(value few.report error)" 'BEGIN { exit !(e < 1e-12) }'
    awk -v d="$(value few.report droppedMean)" 'BEGIN { exit !(d > 0 && d < 1) }'
    [ "$(head -c 15 all.embedding)" = SINEWEMBEDDING1 ]
}

@test "every --stop-after leaves a valid document" {
    "$BIN/fiber-fill" -n 4 --trace t.jsonl built.json > /dev/null
    steps=$(wc -l < t.jsonl)
    [ "$steps" -gt 40 ]
    grep -q '"level"' t.jsonl
    grep -q '"split"' t.jsonl
    grep -q '"fiber"' t.jsonl
    for n in 0 1 5 20 $((steps - 3)) $((steps - 1)) "$steps"; do
        "$BIN/fiber-fill" -n 4 --stop-after "$n" built.json -o part.json
        "$BIN/fiber-fill" -n 4 --no-history part.json | cmp - <("$BIN/fiber-fill" -n 4 --no-history built.json)
    done
}

@test "impossible requests: one sentence, nothing written" {
    refused() { # MESSAGE ARGUMENT...
        message=$1
        shift
        code=0
        "$BIN/fiber-fill" "$@" -o no.json 2> err || code=$?
        [ "$code" -eq 1 ]
        [ ! -e no.json ]
        [ "$(wc -l < err)" -eq 1 ]
        grep -q "$message" err
    }
    echo '{"format": "sinew-fiber-ends", "version": 1, "origin": [0], "insertion": [0]}' > bad.json
    refused "must each have a vertex" --ends bad.json built.json
    echo '{"format": "sinew-fiber-ends", "version": 1, "origin": [0], "insertion": [123456]}' > bad.json
    refused "insertion" --ends bad.json built.json
    echo '{"format": "sinew-fiber-template", "version": 1, "curves": []}' > bad.json
    refused "at least one curve" --template-file bad.json built.json
    echo '{"format": "sinew-fiber-template", "version": 1, "curves": [{"points": [0,0,0, 2,0,1]}]}' > bad.json
    refused "unit cube" --template-file bad.json built.json
    echo '{"format": "sinew-fiber-template", "version": 1, "curves": [{"points": [0,0,1, 0,0,0]}]}' > bad.json
    refused "does not rise" --template-file bad.json built.json
    refused "cannot be opened" --ends nowhere.json built.json
    refused "holds no fibre" --bend-to biceps.ply built.json
    printf 'v 0 0 0\nv 0 0 0.1\nl 1 2\n' > far.obj
    sed 's/^v 0/v 90/' far.obj > away.obj
    refused "muscle.s unit" --bend-to away.obj built.json
}

@test "options that make no sense are wrong usage" {
    run -2 "$BIN/fiber-fill" --fibers 0 built.json
    run -2 "$BIN/fiber-fill" --template feather built.json
    run -2 "$BIN/fiber-fill" --angle 20 built.json
    run -2 "$BIN/fiber-fill" --template fan --bow 1 built.json
    run -2 "$BIN/fiber-fill" --mvc-cut 1e-3 built.json
    run -2 "$BIN/fiber-fill" --bend-to lines.obj --template pennate built.json
    run -2 "$BIN/fiber-fill" --bend-to lines.obj --template-file t.json built.json
}

@test "a bare mesh has ends too" {
    "$BIN/fiber-fill" --units m --report r.json biceps.ply > /dev/null
    [ "$(value r.json ends)" = '"tips"' ]
    [ "$(value r.json fibers)" -eq 100 ]
}

@test "an open surface is filled with a warning" {
    "$BIN/mesh-clean" -q biceps.ply -o whole.obj
    awk '!/^f/ || ++n > 40' whole.obj > open.obj
    "$BIN/fiber-fill" --report r.json open.obj > /dev/null 2> err
    grep -q 'not closed' err
    [ "$(value r.json outsideAfter)" -eq 0 ]
}

@test "attachments are the ends; --tips leaves them aside" {
    "$BIN/attach-detect" -q --bone a=humerus.ply --bone b=radius.ply --distance 20mm built.json -o attached.json
    "$BIN/fiber-fill" --report r.json attached.json > /dev/null
    [ "$(value r.json ends)" = '"attachments"' ]
    "$BIN/fiber-fill" --tips --report r.json attached.json > /dev/null
    [ "$(value r.json ends)" = '"tips"' ]
}

# A sheet 120 mm wide at the top, 20 at the bottom, 80 high and 10 thick; landmarks of its two areas on one of its faces.
make_fan() {
    awk 'function id(s, i, j) { return s * 1271 + i * 31 + j + 1 }
        BEGIN {
            for (s = 0; s < 2; s++) for (i = 0; i <= 40; i++) for (j = 0; j <= 30; j++) {
                u = i / 40; t = j / 30
                printf "v %.9g %g %.9g\n", 120 * u + (40 + 20 * u - 120 * u) * t, 10 * s, -80 * t
            }
            for (i = 0; i < 40; i++) for (j = 0; j < 30; j++) {
                printf "f %d %d %d\nf %d %d %d\n", id(0,i,j), id(0,i+1,j+1), id(0,i,j+1), id(0,i,j), id(0,i+1,j), id(0,i+1,j+1)
                printf "f %d %d %d\nf %d %d %d\n", id(1,i,j), id(1,i,j+1), id(1,i+1,j+1), id(1,i,j), id(1,i+1,j+1), id(1,i+1,j)
            }
            for (i = 0; i < 40; i++) add(i, 0)
            for (j = 0; j < 30; j++) add(40, j)
            for (i = 40; i > 0; i--) add(i, 30)
            for (j = 30; j > 0; j--) add(0, j)
            for (q = 0; q < n; q++) {
                r = (q + 1) % n
                printf "f %d %d %d\nf %d %d %d\n", id(0,x[q],y[q]), id(1,x[r],y[r]), id(0,x[r],y[r]), id(0,x[q],y[q]), id(1,x[q],y[q]), id(1,x[r],y[r])
            }
        }
        function add(i, j) { x[n + 0] = i; y[n + 0] = j; n++ }' > fan.obj
    printf 'iliac\torigin\t%s\t0\t%s\n' 2 -2 117.5 -2 100.25 -25 13.5 -25 > fan.tsv
    printf 'femur\tinsertion\t%s\t0\t%s\n' 36 -70 66.5 -70 60.5 -78 40 -78 >> fan.tsv
}

fan_is_right() { # report
    [ "$(value "$1" fibers)" -eq 49 ]
    [ "$(value "$1" outsideAfter)" -eq 0 ]
    awk -v mean="$(value "$1" meanLength)" -v most="$(value "$1" greatestLength)" -v off="$(value "$1" lengthDeviation)" \
        -v share="$(value "$1" lengthVariation)" -v a="$(value "$1" originArea)" -v b="$(value "$1" insertionArea)" \
        'BEGIN { exit !(mean > 61 && mean < 69 && most < 96 && off > 3 && off < 12 && share - off / mean < 1e-9 && a > b && b > 100) }'
}

@test "a fan's fibres run from area to area, in both orders of the chain" {
    make_fan
    "$BIN/mesh-clean" -q --units mm fan.obj -o fan.json
    "$BIN/attach-detect" -q --landmarks fan.tsv fan.json | "$BIN/root-select" -q | "$BIN/build-structure" -q | "$BIN/fiber-flow" -q |
        "$BIN/fiber-fill" -n 49 --report first.json -o first.muscle.json
    fan_is_right first.json
    # what the landmarks call origin and insertion the document tells on, and fibres run from the one to the other
    python3 -c 'import json
d = json.load(open("first.muscle.json"))
assert {a["bone"]: a.get("end") for a in d["attachments"]} == {"iliac": "origin", "femur": "insertion"}
assert all(f["points"][2] > -30 and f["points"][-1] < -60 for f in d["fibers"]["polylines"])'
    "$BIN/root-select" -q fan.json | "$BIN/build-structure" -q | "$BIN/fiber-flow" -q | "$BIN/fiber-fill" -q -n 49 |
        "$BIN/attach-detect" -q --landmarks fan.tsv | "$BIN/fiber-flow" -q | "$BIN/fiber-fill" -q -n 49 --report last.json -o last.muscle.json
    fan_is_right last.json
    # both ends of every fibre lie on the face that has the areas
    "$BIN/fiber-fill" -q -n 49 first.muscle.json -o fan-lines.obj
    [ "$(grep -c '^l ' fan-lines.obj)" -eq 49 ]
    [ "$(awk '$1 == "v" && ++n % 16 < 2 && ($3 > 1e-9 || $3 < -1e-9)' fan-lines.obj | wc -l)" -eq 0 ]
}

@test "a template that is asked for is not spread over the areas; its angle comes out or a warning says so" {
    make_fan
    "$BIN/mesh-clean" -q --units mm fan.obj | "$BIN/attach-detect" -q --landmarks fan.tsv -o fan-areas.json
    "$BIN/fiber-fill" -q --template parallel --report r.json fan-areas.json > /dev/null
    [ -z "$(value r.json originArea)" ]
    "$BIN/fiber-fill" --template pennate --angle 80 --report r.json built.json 2> err > /dev/null
    awk -v is="$(value r.json meanPennationDegrees)" 'BEGIN { exit !(is > 78 && is < 82) }' || grep -q 'not the 80.0 asked for' err
    awk -v asked="$(value r.json angleAskedDegrees)" 'BEGIN { exit !(asked > 79.999 && asked < 80.001) }'
}

# is VALUE within SHARE of WANTED?
near() { awk -v a="$1" -v b="$2" -v share="$3" 'BEGIN { exit !(a - b <= share * b && b - a <= share * b) }'; }

@test "the report has the architecture: lengths, pennation, areas, in the document's unit and in metres" {
    "$BIN/fiber-fill" -q -n 40 --report r.json built.json -o f.json
    for key in volume lengthMean lengthDeviation pennationOriginDegrees pennationInsertionDegrees physiologicalArea bellyLengthMean tendonLengthShare; do
        [ -n "$(value r.json $key)" ]
    done
    near "$(value r.json lengthMean)" "$(value r.json meanLength)" 1e-9
    near "$(value r.json lengthLeast)" "$(value r.json leastLength)" 1e-9
    "$BIN/mesh-clean" -q --units m biceps.ply --report c.json -o c.muscle.json
    near "$(value r.json volume)" "$(awk '/"after"/ { on = 1 } on && /"volume"/ { gsub(/[^-0-9.e]/, "", $2); print $2; exit }' c.json)" 1e-6
    # V / l x cos: no more than V / l, no less than with the steeper of the two angles
    awk -v v="$(value r.json volume)" -v l="$(value r.json lengthMean)" -v o="$(value r.json pennationOriginDegrees)" -v i="$(value r.json pennationInsertionDegrees)" \
        -v a="$(value r.json physiologicalArea)" 'BEGIN { w = v / l * cos((o + i) / 2 * atan2(0, -1) / 180); exit !(a / w > 0.999999 && a / w < 1.000001) }'
    "$BIN/root-select" -q --units mm biceps.ply | "$BIN/fiber-fill" -q -n 4 --report mm.json -o mm.muscle.json
    near "$(value mm.json lengthMeanMeters)" "$(awk -v l="$(value mm.json lengthMean)" 'BEGIN { print l / 1000 }')" 1e-5
    [ "$(value mm.json metersPerUnit)" = 0.001 ]
}

@test "without --tendon the document is the same, with a report or without; the figures do not hang on threads" {
    "$BIN/fiber-fill" -q -n 20 built.json -o plain.json
    "$BIN/fiber-fill" -q -n 20 --report 1.json --threads 1 built.json | cmp - plain.json
    "$BIN/fiber-fill" -q -n 20 --report 3.json --threads 3 built.json | cmp - plain.json
    cmp <(grep -v '"seconds"' 1.json) <(grep -v '"seconds"' 3.json)
    refute grep -q '"tendon"' plain.json
}

refute() { if "$@"; then return 1; fi; }

@test "--tendon paints a map on the mesh and leaves the other sections; a painted map is taken up" {
    "$BIN/attach-detect" -q --bone a=humerus.ply --bone b=radius.ply --distance 20mm built.json -o attached.json
    "$BIN/fiber-fill" -q -n 20 --no-history attached.json -o plain.json
    "$BIN/fiber-fill" -q -n 20 --no-history --tendon 10%,20mm --report r.json attached.json -o painted.json
    [ "$(value r.json tendon)" = '"given"' ]
    grep -q '"tendon"' painted.json
    for section in roots structure fibers attachments; do
        cmp <(sed -n "/^  \"$section\"/,/^  []}]/p" plain.json) <(sed -n "/^  \"$section\"/,/^  []}]/p" painted.json)
    done
    length=$(value r.json lengthMean)
    near "$(value r.json bellyLengthMean)" "$(awk -v l="$length" 'BEGIN { print 0.9 * l - 0.02 }')" 0.02
    "$BIN/fiber-fill" -q -n 20 --report again.json painted.json -o again.muscle.json
    [ "$(value again.json tendon)" = '"painted"' ]
    near "$(value again.json bellyLengthMean)" "$(value r.json bellyLengthMean)" 0.05
    grep -q '"tendon"' again.muscle.json
    "$BIN/fiber-fill" -q -n 20 --tendon none --report none.json painted.json -o none.muscle.json
    [ "$(value none.json tendonLengthShare)" = 0 ]
    "$BIN/fiber-fill" -n 20 --tendon thickness --report t.json built.json -o t.vtp 2> err
    grep -q 'the map of tendons is lost' err
}

@test "--tendon: what is wrong is said" {
    for how in thick 10% 1,2,3 5%,x -1,2 120%,0 , nan,1; do
        run -2 "$BIN/fiber-fill" -n 4 --tendon "$how" built.json -o no.json
    done
    run -1 "$BIN/fiber-fill" -n 4 --tendon painted built.json -o no.json
    [[ "$output" == *'no painted map "tendon"'* ]]
    "$BIN/fiber-fill" -q -n 4 --tendon 10%,10% built.json -o painted.json
    awk '/"tendon"/ { on = 1 } on && /"values"/ { sub(/\[[ 0-9.]*/, "[255"); on = 0 } { print }' painted.json > loud.json
    refute cmp -s painted.json loud.json
    run -1 "$BIN/fiber-fill" -n 4 --report r.json loud.json -o no.json
    [[ "$output" == *'"tendon" is 255 at vertex 0'*'divided by 255'* ]]
    [ ! -e no.json ]
}

@test "simulate takes the map where the scene names it, and says so where it does not" {
    "$BIN/attach-detect" -q --bone a=humerus.ply --bone b=radius.ply --distance 20mm built.json -o attached.json
    "$BIN/fiber-fill" -q -n 20 attached.json -o plain.muscle.json
    "$BIN/fiber-fill" -q -n 20 --tendon 30%,30% attached.json -o tendon.muscle.json
    scene() { # RIG MAPS
        printf '{"format": "sinew-scene", "version": 1, "metersPerUnit": 1, "rate": 24, "frames": [0, 4], "bones": [{"name": "a", "mesh": "humerus.ply"}, {"name": "b", "mesh": "radius.ply"}], "muscles": [{"name": "m", "rig": "%s", "activation": 1%s}]}\n' "$1" "$2"
    }
    scene plain.muscle.json '' > plain.scene.json
    scene tendon.muscle.json '' > idle.scene.json
    scene tendon.muscle.json ', "maps": {"tendon": "tendon"}' > used.scene.json
    scene tendon.muscle.json ', "maps": {"tendon": "tendons"}' > wrong.scene.json
    for name in plain idle used; do "$BIN/simulate" $name.scene.json -o $name.pc2 > $name.jsonl 2> $name.err; done
    cmp plain.pc2 idle.pc2
    refute cmp -s plain.pc2 used.pc2
    grep -q 'its tendon map is not used' idle.err
    refute grep -q 'tendon map' used.err plain.err
    run -1 "$BIN/simulate" wrong.scene.json -o wrong.pc2
    [[ "$output" == *'no attribute "tendons"'* ]]
}

# a spindle along z, 200 long, 30 x 16 in its middle
spindle() {
    awk 'function id(i, j) { return i * k + j % k + 1 }
        BEGIN {
            n = 40; k = 16; pi = 3.141592653589793
            for (i = 0; i <= n; i++) for (j = 0; j < k; j++) {
                r = 0.35 + 0.65 * (i % n ? sin(pi * i / n) ^ 0.7 : 0)
                print "v", 15 * r * cos(2 * pi * j / k), 8 * r * sin(2 * pi * j / k), -200 * i / n
            }
            c = (n + 1) * k
            print "v 0 0 0\nv 0 0 -200"
            for (i = 0; i < n; i++) for (j = 0; j < k; j++) { print "f", id(i, j), id(i + 1, j + 1), id(i, j + 1); print "f", id(i, j), id(i + 1, j), id(i + 1, j + 1) }
            for (j = 0; j < k; j++) { print "f", c + 1, id(0, j), id(0, j + 1); print "f", c + 2, id(n, j + 1), id(n, j) }
        }'
}

@test "no fibre runs past its end and returns where an area is long along the muscle" {
    spindle > spindle.obj
    printf 'a\torigin\t%s\t%s\t%s\n' 4 3 -4 -4 3 -4 -4 3 -14 4 3 -14 > long.tsv
    printf 'b\tinsertion\t%s\t%s\t%s\n' 14 0 -60 7 7 -60 7 6 -195 12 0 -195 >> long.tsv
    "$BIN/attach-detect" -q --units mm --landmarks long.tsv spindle.obj | "$BIN/root-select" -q | "$BIN/build-structure" -q | "$BIN/fiber-flow" -q |
        "$BIN/fiber-fill" -n 60 --report r.json -o spindle.json
    [ "$(jq -r .ends r.json)" = areas ]
    [ "$(jq '[.fibers.polylines[].points | [range(2; length; 3) as $i | .[$i]] | select([range(1; length) as $i | .[$i] - .[$i - 1]] | max > 1)] | length' spindle.json)" -eq 0 ]
}

@test "a muscle that fibres leave empty falls short; so does none that they fill" {
    spindle > empty.obj
    "$BIN/fiber-fill" --units mm --report full.json empty.obj 2> err > full.muscle.json
    [ ! -s err ]
    awk -v e="$(value full.json emptyShare)" -v v="$(value full.json volume)" -v l="$(value full.json lengthMean)" -v s="$(value full.json spacing)" \
        'BEGIN { exit !(e < 0.02 && s / sqrt(v / l / 100) > 0.98 && s / sqrt(v / l / 100) < 1.02) }'
    # ends at a third of its length: the rest is empty
    echo '{"format": "sinew-fiber-ends", "version": 1, "origin": [0, 3, 7, 11], "insertion": ['"$(seq -s, 192 207)"']}' > third.json
    code=0
    "$BIN/fiber-fill" --units mm --ends third.json --report r.json empty.obj 2> err > third.muscle.json || code=$?
    [ "$code" -eq 3 ]
    grep -q '% of the muscle is farther than 5 mean spacings' err
    awk -v e="$(value r.json emptyShare)" 'BEGIN { exit !(e > 0.4 && e < 0.75) }'
    [ "$(jq '.fibers.polylines | length' third.muscle.json)" -eq 100 ]
    # a template of one's own may leave out what it likes
    echo '{"format": "sinew-fiber-template", "version": 1, "curves": [{"points": [0.5,0.5,0, 0.5,0.5,0.2]}]}' > part.json
    "$BIN/fiber-fill" --units mm --template-file part.json empty.obj 2> err > /dev/null
    grep -q 'warning: .*farther than 5 mean spacings' err
    cmp <("$BIN/fiber-fill" -q --threads 1 --units mm --ends third.json --report - -o /dev/null empty.obj 2> /dev/null | grep emptyShare) \
        <("$BIN/fiber-fill" -q --threads 3 --units mm --ends third.json --report - -o /dev/null empty.obj 2> /dev/null | grep emptyShare)
}

@test "fibres from an end back to an end beside it are told, and the work falls short where most of them are" {
    spindle > back.obj
    echo '{"format": "sinew-fiber-ends", "version": 1, "origin": [0, 1, 15], "insertion": [7, 8, 9]}' > beside.json
    run -3 --separate-stderr "$BIN/fiber-fill" --units mm --ends beside.json --report r.json -o /dev/null back.obj
    echo "$stderr" > err
    grep -q 'bend more than the muscle does' err
    [ "$(value r.json bentFibers)" -gt 0 ]
    awk -v b="$(value r.json lengthOverChord)" 'BEGIN { exit !(b > 1.5) }'
}

# A sheet of 200 x 100 x 4 along x with a spur of 20 x 80 on one of its long sides, and two ends as wide as it is.
spurred() {
    awk 'function id(s, i, j) { if (!((s, i, j) in n)) { n[s, i, j] = ++c; print "v", 4 * i, 4 * j, 4 * s }; return n[s, i, j] }
        function is(i, j) { return i >= 0 && i < 50 && j >= 0 && (j < 25 || (j < 45 && i >= 22 && i < 28)) }
        function wall(i, j, k, l) { print "f", id(0,i,j), id(0,k,l), id(1,k,l); print "f", id(0,i,j), id(1,k,l), id(1,i,j) }
        BEGIN {
            for (i = 0; i < 50; i++) for (j = 0; j < 45; j++) if (is(i, j)) {
                print "f", id(0,i,j), id(0,i+1,j+1), id(0,i+1,j); print "f", id(0,i,j), id(0,i,j+1), id(0,i+1,j+1)
                print "f", id(1,i,j), id(1,i+1,j), id(1,i+1,j+1); print "f", id(1,i,j), id(1,i+1,j+1), id(1,i,j+1)
                if (!is(i, j - 1)) wall(i, j, i + 1, j)
                if (!is(i + 1, j)) wall(i + 1, j, i + 1, j + 1)
                if (!is(i, j + 1)) wall(i + 1, j + 1, i, j + 1)
                if (!is(i - 1, j)) wall(i, j + 1, i, j)
            }
        }'
}

@test "fibres pass a spur without an end of its own" {
    spurred > spur.obj
    "$BIN/mesh-clean" -q --units mm spur.obj -o spur.json
    awk '$1 == "v" { if ($2 == 0) a = a (a == "" ? "" : ", ") n + 0; if ($2 == 200) b = b (b == "" ? "" : ", ") n + 0; n++ }
        END { printf "{\"format\": \"sinew-fiber-ends\", \"version\": 1, \"origin\": [%s], \"insertion\": [%s]}\n", a, b }' spur.obj > sides.json
    "$BIN/fiber-fill" --units mm -n 60 --ends sides.json --report r.json spur.obj -o spur.muscle.json
    [ "$(value r.json slices)" = '"flux"' ]
    # none goes into it by a quarter of its length: by the rims' lengths a fifth of them go farther, up to 64 of 80
    [ "$(jq '[.fibers.polylines[].points | [range(1; length; 3) as $i | .[$i]] | select(max > 120)] | length' spur.muscle.json)" -eq 0 ]
    awk -v m="$(value r.json meanLength)" -v e="$(value r.json emptyShare)" 'BEGIN { exit !(m > 198 && m < 205 && e > 0.03 && e < 0.1) }'
}

@test "ward-table: rigs of a leg against measured fibre lengths" {
    [ -d "$DATA/leg-vhf" ] || skip "no real anatomy at $DATA"
    "$BATS_TEST_DIRNAME/../ward-table" "$BIN" "$DATA" ward gracilis tibialis_anterior > table.out
    [ "$(wc -l < ward/table.tsv)" -eq 3 ]
    awk -F '\t' 'NR > 1 && (NF != 14 || !($3 > $5)) { exit 1 }' ward/table.tsv # both have a tendon in one mesh with the belly
    awk -F '\t' '$1 == "gracilis" { exit !($14 > 0.05) }' ward/table.tsv
    awk -F '\t' '$1 == "tibialis_anterior" { exit !($11 > 5 && $13 < 3) }' ward/table.tsv # from tip to tip far too long; bipennate not
    run -2 "$BATS_TEST_DIRNAME/../ward-table" "$BIN" "$DATA" ward biceps
}

# A tube that bends by ANGLE about y, its two ends on the vertices of two pins.
bent_tube() {
    python3 - "$1" <<'PY'
import math, sys
angle, rings, sides, radius, thick = float(sys.argv[1]), 60, 16, 0.06, 0.018
out = open("tube.obj", "w")
for i in range(rings + 1):
    a, s = angle * i / rings, thick * max(math.sin(math.pi * (0.06 + 0.88 * i / rings)), 0.3)
    for k in range(sides):
        b = 2 * math.pi * k / sides
        r = radius + s * math.cos(b)
        out.write("v %.9g %.9g %.9g\n" % (r * math.cos(a), s * math.sin(b), r * math.sin(a)))
for end in (0, angle): out.write("v %.9g 0 %.9g\n" % (radius * math.cos(end), radius * math.sin(end)))
first, last = (rings + 1) * sides + 1, (rings + 1) * sides + 2
at = lambda i, k: i * sides + k % sides + 1
for i in range(rings):
    for k in range(sides):
        out.write("f %d %d %d\nf %d %d %d\n" % (at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k), at(i + 1, k + 1), at(i, k + 1)))
for k in range(sides):
    out.write("f %d %d %d\nf %d %d %d\n" % (first, at(0, k), at(0, k + 1), last, at(rings, k + 1), at(rings, k)))
pin = lambda i: "indices:" + ",".join(str(i * sides + k) for k in range(sides))
open("pins", "w").write("a=%s\nb=%s\n" % (pin(0), pin(rings)))
PY
    "$BIN/mesh-clean" -q tube.obj | "$BIN/attach-detect" -q --pin "$(sed -n 1p pins)" --pin "$(sed -n 2p pins)" | "$BIN/root-select" -q |
        "$BIN/build-structure" -q | "$BIN/fiber-flow" -q -o tube.muscle.json
}

@test "fibres that leave the muscle where it bends back are told, and those that stay inside are not" {
    bent_tube 1.2
    "$BIN/fiber-fill" -q -n 40 tube.muscle.json -o a.json --report a.rep
    python3 -c 'import json; r = json.load(open("a.rep")); assert r["outsideShare"] == 0, r["outsideShare"]'
    bent_tube 4.4
    run -3 "$BIN/fiber-fill" -q -n 40 tube.muscle.json -o b.json --report b.rep
    [[ $output == *"% of the fibres' length is outside of the muscle"* ]]
    python3 -c 'import json; r = json.load(open("b.rep")); assert r["outsideShare"] > 0.05 and r["outsideAfter"] == 0, r'
    "$BIN/fiber-fill" -q -n 40 --tips tube.muscle.json -o c.json --report c.rep || [ $? -eq 3 ]
    python3 -c 'import json; r = json.load(open("c.rep")); assert r["outsideShare"] < 0.02, r["outsideShare"]'
}
