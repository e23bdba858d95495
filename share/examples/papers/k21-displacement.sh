#!/bin/sh
# [K21] figure 7: how far an iteration moves the points, on average over the frames of a motion, for 1 to 100 iterations (-i).
# The paper: below 0.1 mm after a few iterations, below 0.01 mm after 10.
# Usage: k21-displacement.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-10} iterations=${iterations:-100}
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig muscle "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
scene muscle "$frames" '' "$@"

# mean over all frames of what each iteration moves, in mean edges: "ITERATION MOVE"
moves() {
    scheme=$1
    shift
    run_on "$out/muscle.scene.json" --solver xpbd --scheme "$scheme" "$@" --substeps 1 --iterations "$iterations" --trace "$out/$scheme.trace" --log "$out/$scheme.jsonl" -q
    awk '{ i = $0; sub(/.*"iteration":/, "", i); m = $0; sub(/.*"mean_move":/, "", m); sum[i + 0] += m + 0; n[i + 0]++ }
        END { for (i = 1; i in n; i++) print i "\t" sum[i] / n[i] }' "$out/$scheme.trace" > "$out/$scheme.moves"
    rm "$out/$scheme.trace"
}
# shellcheck disable=SC2086
moves kohout $obstacles ${contact:+$voxels}
# shellcheck disable=SC2086
moves guarded $obstacles
paste "$out/kohout.moves" "$out/guarded.moves" | awk -v mm="$(millimetres muscle)" '
    BEGIN { print "iteration\tkohout_edges\tguarded_edges\tkohout_mm\tguarded_mm" }
    { print $1 "\t" $2 "\t" $4 "\t" $2 * mm "\t" $4 * mm }' > "$out/$recipe.tsv"
rm "$out/kohout.moves" "$out/guarded.moves"
chart "$recipe"
at() { awk -F '\t' -v i="$1" -v c="$2" 'NR > 1 && $1 == i { printf "%.4f", $c }' "$out/$recipe.tsv"; }
[ "$iterations" -lt 10 ] || claim "fig. 7: mean displacement in iteration 3; 10; $iterations, mm (default: guarded, the scheme of xpbd; qn has no sweeps)" \
    "< 0.1 in a few; < 0.01; -" "$(at 3 4); $(at 10 4); $(at "$iterations" 4)" "$(at 3 5); $(at 10 5); $(at "$iterations" 5)"
awk -F '\t' -v r="$recipe" 'NR > 1 && ($1 == 1 || $1 == 3 || $1 == 10 || $1 == 100) {
    printf "%s: iteration %3d moves a point by %.4f mm under kohout, %.4f mm under guarded\n", r, $1, $4, $5 }' "$out/$recipe.tsv"
