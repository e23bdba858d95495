#!/bin/sh
# [K21] figure 6: a muscle decomposed into 100 fibres of 15 line segments: a picture, the lengths, and the time of the decomposition alone, the
# least of five. The paper: less than 50 ms for 10622 to 19752 triangles.
# Usage: k21-fibers.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig muscle "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
for _ in 1 2 3 4 5; do
    fiber-fill -q --fibers 100 --segments 15 --report "$out/fill.json" --threads 1 "$out/muscle.muscle.json" -o "$out/filled.muscle.json" || [ $? -eq 3 ]
    awk -F '[:,]' '/^  "seconds"/ { print 1000 * $2; exit }' "$out/fill.json"
done | sort -n | head -n 1 > "$out/ms"
number() { awk -F '[:,]' -v n="\"$1\"" '{ gsub(/ /, "", $1) } $1 == n { print $2; exit }' "$out/fill.json"; }
{
    printf 'muscle\ttriangles\tfibres\tmean_mm\tleast_mm\tgreatest_mm\tms\n'
    printf '%s\t%s\t%s\t%s\t%s\n' "${muscle:-$(basename "${surface%.*}")}" "$(count muscle)" "$(number fibers)" \
        "$(for n in meanLength leastLength greatestLength; do number $n; done | awk -v m="$meters" '{ printf "%s%.1f", (NR > 1 ? "\t" : ""), 1000 * m * $1 }')" "$(cat "$out/ms")"
} > "$out/$recipe.tsv"
awk -F '\t' 'NR > 1 && NF == 7 && $3 + 0 > 0 && $4 + 0 > 0 && $7 + 0 > 0 { ok = 1 } END { exit !ok }' "$out/$recipe.tsv" || { say "the report has no figures" >&2; exit 1; }
rm -f "$out/ms" "$out/fill.json"
rig-view "$out/filled.muscle.json" --size 700x420 --show surface,fibers --title "${muscle:-$(basename "${surface%.*}")}: 100 fibres of 15 segments" -q -o "$out/$recipe.png"
say "$out/$recipe.png, $out/$recipe.tsv"
claim "fig. 6: decomposition of ${muscle:-$(basename "${surface%.*}")} ($(awk -F '\t' 'NR > 1 { print $2 }' "$out/$recipe.tsv") triangles) into 100 fibres, ms" "< 50" "$(awk -F '\t' 'NR > 1 { printf "%.0f", $7 }' "$out/$recipe.tsv")" "the same"
awk -F '\t' -v r="$recipe" 'NR > 1 { printf "%s: %s, %d triangles: %d fibres of %s to %s mm in %.0f ms\n", r, $1, $2, $3, $5, $6, $7 }' "$out/$recipe.tsv"
