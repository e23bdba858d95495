#!/bin/sh
# [K21] figure 7: how far an iteration moves the points, on average over the frames of a motion, for 1 to 100 iterations (-i).
# The paper: below 0.1 mm after a few iterations, below 0.01 mm after 10.
# Usage: k21-displacement.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-u UNIT] [-j JOINT] [SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-10} iterations=${iterations:-100}
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig muscle "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
scene muscle "$frames" '' "$@"

# mean over all frames of what each iteration moves, in mean edges: "ITERATION MOVE"
moves() {
    run_on "$out/muscle.scene.json" --solver xpbd --scheme "$1" --substeps 1 --iterations "$iterations" --trace "$out/$1.trace" --log "$out/$1.jsonl" -q
    awk '{ i = $0; sub(/.*"iteration":/, "", i); m = $0; sub(/.*"mean_move":/, "", m); sum[i + 0] += m + 0; n[i + 0]++ }
        END { for (i = 1; i in n; i++) print i "\t" sum[i] / n[i] }' "$out/$1.trace" > "$out/$1.moves"
    rm "$out/$1.trace"
}
moves kohout
moves guarded
paste "$out/kohout.moves" "$out/guarded.moves" | awk -v mm="$(millimetres muscle)" '
    BEGIN { print "iteration\tkohout_edges\tguarded_edges\tkohout_mm\tguarded_mm" }
    { print $1 "\t" $2 "\t" $4 "\t" $2 * mm "\t" $4 * mm }' > "$out/$recipe.tsv"
rm "$out/kohout.moves" "$out/guarded.moves"
chart "$recipe"
awk -F '\t' -v r="$recipe" 'NR > 1 && ($1 == 1 || $1 == 3 || $1 == 10 || $1 == 100) {
    printf "%s: iteration %3d moves a point by %.4f mm under kohout, %.4f mm under guarded\n", r, $1, $4, $5 }' "$out/$recipe.tsv"
