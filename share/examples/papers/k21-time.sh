#!/bin/sh
# [K21] table 1: the time of a simulation step with 1, 3, 5, 10, 25, 50 and 100 iterations, here at three resolutions (17124, 3000 and 1000
# triangles, or -t "N N ..."), on one thread. A step is a substep, of which a frame has eight here: the statistics at its end then add little.
# Usage: k21-time.sh [-o OUT] [-t "TRIANGLES ..."] [-f FRAMES] [-i "ITERATIONS ..."] [-u UNIT] [-j JOINT] [SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-3} iterations=${iterations:-1 3 5 10 25 50 100} triangles=${triangles:-17124 3000 1000}
most=${triangles%% *}
[ "$given" -gt 0 ] || generate "$most"

# median over the frames, ms a substep
step() {
    run_on "$out/$1.scene.json" --solver xpbd --scheme "$2" --substeps 8 --iterations "$3" --threads 1 --log /dev/null --report "$out/time.json" -q
    awk -F '[:,]' '/"medianFrameSeconds"/ { printf "%.3f", 125 * $2 }' "$out/time.json"
}
printf 'triangles\titerations\tkohout_ms\tguarded_ms\n' > "$out/$recipe.tsv"
for n in $triangles; do
    [ "$n" = "$most" ] || printf '\n\n' # gnuplot: another data set
    rig "muscle-$n" "$n" "$@"
    scene "muscle-$n" "$frames" '' "$@"
    for i in $iterations; do
        # by assignments: a run that fails ends the recipe, and leaves no empty cell
        kohout=$(step "muscle-$n" kohout "$i")
        guarded=$(step "muscle-$n" guarded "$i")
        printf '%s\t%s\t%s\t%s\n' "$(count "muscle-$n")" "$i" "$kohout" "$guarded"
    done
done >> "$out/$recipe.tsv"
rm "$out/time.json"
chart "$recipe"
awk -F '\t' -v r="$recipe" 'NF == 4 && NR > 1 { printf "%s: %6d triangles, %3d iterations: %8.2f ms kohout, %8.2f ms guarded\n", r, $1, $2, $3, $4 }' "$out/$recipe.tsv"
