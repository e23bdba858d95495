#!/bin/sh
# [K21] figure 11: the volume over the motion with 3 iterations a step. The paper: the error is below 1 % in all cases.
# Beside it the default: guarded, 16 substeps of 2 iterations, and guarded with no more work than kohout: 1 substep of 3 iterations.
# Usage: k21-volume.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-$(frames_to 90)} iterations=${iterations:-3}
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig muscle "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
scene muscle "$frames" '' "$@"
run() { # NAME OPTION...
    name=$1
    shift
    run_on "$out/muscle.scene.json" "$@" --log "$out/$name.jsonl" -q
    member volume_ratio < "$out/$name.jsonl" > "$out/$name.ratios"
}
# shellcheck disable=SC2086
{
    run kohout --scheme kohout --substeps 1 --iterations "$iterations" $obstacles ${contact:+$voxels}
    run guarded --solver xpbd --substeps 1 --iterations "$iterations" $obstacles
    run default $obstacles
}
{
    printf 'frame\tdegrees\tkohout\tguarded\tdefault\n'
    paste "$out/kohout.ratios" "$out/guarded.ratios" "$out/default.ratios" |
        awk -v d="${joint##* }" '{ print NR - 1 "\t" (NR - 1) * (d < 0 ? -d : d) "\t" $1 "\t" $2 "\t" $3 }'
} > "$out/$recipe.tsv"
rm "$out"/*.ratios
chart "$recipe"
worst() { awk -F '\t' -v c="$1" 'NR > 1 { e = $c - 1; if (e < 0) e = -e; if (e > worst) worst = e } END { printf "%.3f", 100 * worst }' "$out/$recipe.tsv"; }
claim "fig. 11: worst volume error of ${muscle:-$(basename "${surface%.*}")} over the motion, $iterations iterations, %" "< 1" "$(worst 3)" "$(worst 5)"
awk -F '\t' -v r="$recipe" 'NR > 1 { for (i = 3; i <= 5; i++) { e = $i - 1; if (e < 0) e = -e; if (e > worst[i]) worst[i] = e } }
    END { printf "%s: worst volume error %.3f %% under kohout, %.3f %% under guarded, %.3f %% by default\n", r, 100 * worst[3], 100 * worst[4], 100 * worst[5] }' "$out/$recipe.tsv"
