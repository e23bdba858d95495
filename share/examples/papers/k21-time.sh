#!/bin/sh
# [K21] table 1: the time of a simulation step with 1, 3, 5, 10, 25, 50 and 100 iterations, here at three resolutions (17124, 3000 and 1000
# triangles, or -t "N N ..."), on one thread. A step is a substep, of which a frame has eight here: the statistics at its end then add little.
# By kohout, by guarded, and by the default (qn), which is made to take all of its iterations.
# Usage: k21-time.sh [-o OUT] [-t "TRIANGLES ..."] [-f FRAMES] [-i "ITERATIONS ..."] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-3} iterations=${iterations:-1 3 5 10 25 50 100} triangles=${triangles:-17124 3000 1000}
most=${triangles%% *}
[ "$given" -gt 0 ] || generate "$most"

# step NAME WHAT ITERATIONS OPTION...: median over the frames, ms a substep
step() {
    name=$1 iterating=$3
    shift 3
    run_on "$out/$name.scene.json" "$@" --substeps 8 --iterations "$iterating" --threads 1 --log /dev/null --report "$out/time.json" -q
    awk -F '[:,]' '/"medianFrameSeconds"/ { printf "%.3f", 125 * $2 }' "$out/time.json"
}
printf 'triangles\titerations\tkohout_ms\tguarded_ms\tdefault_ms\n' > "$out/$recipe.tsv"
for n in $triangles; do
    [ "$n" = "$most" ] || printf '\n\n' # gnuplot: another data set
    rig "muscle-$n" "$n" "$@"
    scene "muscle-$n" "$frames" '' "$@"
    for i in $iterations; do
        # by assignments: a run that fails ends the recipe, and leaves no empty cell
        # shellcheck disable=SC2086
        kohout=$(step "muscle-$n" kohout "$i" --scheme kohout $obstacles ${contact:+$voxels})
        # shellcheck disable=SC2086
        guarded=$(step "muscle-$n" guarded "$i" --solver xpbd $obstacles)
        # shellcheck disable=SC2086
        default=$(step "muscle-$n" default "$i" --tolerance 0 $obstacles)
        printf '%s\t%s\t%s\t%s\t%s\n' "$(count "muscle-$n")" "$i" "$kohout" "$guarded" "$default"
    done
done >> "$out/$recipe.tsv"
rm "$out/time.json"
chart "$recipe"
awk -F '\t' -v r="$recipe" 'NF == 5 && NR > 1 { printf "%s: %6d triangles, %3d iterations: %8.2f ms kohout, %8.2f ms guarded, %8.2f ms by default\n", r, $1, $2, $3, $4, $5 }' "$out/$recipe.tsv"
# list COLUMN: of the finest, for the table
list() { awk -F '\t' -v c="$1" 'NF < 5 { exit } NR > 1 { printf "%s%.3g", (NR > 2 ? "; " : ""), $c } ' "$out/$recipe.tsv"; }
claim "table 1: a step of $(awk -F '\t' 'NR == 2 { print $1 }' "$out/$recipe.tsv") triangles with $iterations iterations, ms" \
    "53; 63; 75; 105; 194; 442; 659 with 1 to 100 (17124)" "$(list 3)" "$(list 5)"
