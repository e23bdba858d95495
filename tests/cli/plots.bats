# share/plots/fiber-lengths: charts of fibre lengths as SVG and PNG, from both kinds of file; refusals.

bats_require_minimum_version 1.5.0

plot=$BATS_TEST_DIRNAME/../../share/plots/fiber-lengths

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    # two muscles of 2 and 1 fibres, the first with a blend, over a joint that turns
    awk 'BEGIN { OFS = "\t"; print "time", "el_bow.angle", "a_b.1", "a_b.2", "a_b.blend.1", "a_b.blend.2", "c.1"
        for (i = 0; i <= 10; i++) print i / 24, 3 * i, 0.1 + i / 1e3, 0.12, 0.1, 0.11 + i / 2e3, 0.05 }' > two.tsv
    cut -f 1-4 two.tsv > one.tsv
    { printf 'x\nversion=1\nnRows=11\nnColumns=4\ninDegrees=yes\n\nUnits\n\nendheader\n'; cat one.tsv; } > one.sto
}

needs_gnuplot() { command -v gnuplot > /dev/null || skip "gnuplot is not here"; }

@test "SVG and PNG, over time and over an angle" {
    needs_gnuplot
    "$plot" one.tsv one.svg one.png
    python3 - <<'END'
import struct, xml.etree.ElementTree as tree
svg = tree.parse("one.svg").getroot()
text = "".join(svg.itertext())
for word in ("a_b", "time, s", "fibre length, mm", "2 fibres: shortest to longest", "mean"): assert word in text, word
assert "blend" not in text
# a line of eleven points for each fibre, and the mean with its sample in the legend
lines = [e.get("d") for e in svg.iter("{http://www.w3.org/2000/svg}path") if e.get("d", "").replace("\n", " ").count("L") in (10, 11) and "Z" not in e.get("d")]
assert len(lines) == 3, len(lines)
png = open("one.png", "rb").read()
assert png[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", png[16:24]) == (900, 560)
END
    "$plot" --over el_bow --muscle 'a b' --title 'the "one" & $HOME' --size 400x300 two.tsv angle.svg angle.png
    python3 - <<'END'
import struct, xml.etree.ElementTree as tree
text = "".join(tree.parse("angle.svg").getroot().itertext())
for word in ('the "one" & $HOME', "el_bow, degrees", "blend: mean", "30"): assert word in text, word
assert struct.unpack(">II", open("angle.png", "rb").read()[16:24]) == (400, 300)
END
}

@test "a storage file gives the same chart, twice the same" {
    needs_gnuplot
    "$plot" one.tsv a.svg
    "$plot" one.sto b.svg
    "$plot" one.sto c.svg
    cmp a.svg b.svg
    cmp b.svg c.svg
}

@test "what simulate writes is drawn" {
    needs_gnuplot
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" arm
    cd arm || exit 1
    "$BIN/fiber-fill" -n 10 biceps.muscle.json -o filled.muscle.json
    python3 -c 'import json; s = json.load(open("arm.scene.json")); s["muscles"][0]["rig"] = "filled.muscle.json"; json.dump(s, open("filled.scene.json", "w"))'
    "$BIN/simulate" -q filled.scene.json --frames 0:12 --lengths l.sto --blend 1 > log.jsonl
    "$plot" --muscle biceps --over elbow l.sto biceps.svg
    grep -q '10 fibres' biceps.svg
}

@test "what cannot be drawn: one sentence, no chart, an old one stays" {
    needs_gnuplot
    refused() { # STATUS MESSAGE ARGUMENT...
        status=$1 message=$2
        shift 2
        echo old > old.svg
        code=0
        "$plot" "$@" 2> err || code=$?
        [ "$code" -eq "$status" ]
        [ "$(wc -l < err)" -eq 1 ]
        grep -q -e "$message" err
        [ "$(cat old.svg)" = old ]
    }
    refused 1 "several muscles" two.tsv old.svg
    refused 1 "no muscle d, but a_b, c" --muscle d two.tsv old.svg
    refused 1 "no column knee.angle" --over knee one.tsv old.svg
    refused 1 "cannot be opened" nowhere.tsv old.svg
    : > empty.tsv
    refused 1 "no table" empty.tsv old.svg
    head -n 1 one.tsv > short.tsv
    refused 1 "fewer than two rows" short.tsv old.svg
    sed '4s/\t[^\t]*$//' one.tsv > torn.tsv
    refused 1 "line 4" torn.tsv old.svg
    cut -f 1-2 one.tsv > none.tsv
    refused 1 "no length" none.tsv old.svg
    refused 2 "ends in .svg or .png" one.tsv old.pdf
    refused 2 "usage" one.tsv
    refused 2 "unknown option" --what one.tsv old.svg
    refused 2 "pixels" --size big one.tsv old.svg
}

@test "--help tells the options" {
    "$plot" --help > help
    for option in --over --muscle --title --size; do grep -q -e "$option" help; done
}
