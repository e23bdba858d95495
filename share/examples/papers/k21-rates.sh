#!/bin/sh
# [K21] table 2: simulation steps a second with 64 voxels along each axis and 3 iterations, on one thread; beside it the default.
# The paper: 33.9, 35.9, 47.2 and 57.1 for 19752, 17124, 13858 and 10622 triangles. Bones are obstacles.
# Usage: k21-rates.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-20} iterations=${iterations:-3}
obstacles=$fields
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig muscle "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
scene muscle "$frames" '' "$@"
rate() { # OPTION...: steps a second, by the median step
    run_on "$out/muscle.scene.json" "$@" --threads 1 --log "$out/log.jsonl" --report "$out/time.json" -q
    if wild "$out/log.jsonl"; then echo nan; else awk -F '[:,]' '/"medianFrameSeconds"/ { printf "%.2f", 1 / $2 }' "$out/time.json"; fi
}
# shellcheck disable=SC2086
kohout=$(rate --scheme kohout --substeps 1 --iterations "$iterations" $obstacles --voxels 64)
# shellcheck disable=SC2086
default=$(rate $obstacles)
{
    printf 'muscle\ttriangles\tkohout_fps\tdefault_fps\n'
    printf '%s\t%s\t%s\t%s\n' "${muscle:-$(basename "${surface%.*}")}" "$(count muscle)" "$kohout" "$default"
} > "$out/$recipe.tsv"
rm -f "$out/time.json" "$out/log.jsonl"
chart "$recipe"
published=$(awk -F '\t' 'NR > 1 { split("19752 17124 13858 10622", n, " "); split("33.9 35.9 47.2 57.1", f, " "); for (i = 1; i <= 4; i++) if ($2 > 0.97 * n[i] && $2 < 1.03 * n[i]) x = f[i] } END { print x == "" ? "-" : x }' "$out/$recipe.tsv")
claim "table 2: steps of ${muscle:-$(basename "${surface%.*}")} a second, $(awk -F '\t' 'NR > 1 { print $2 }' "$out/$recipe.tsv") triangles" "$published" "$kohout" "$default"
awk -F '\t' -v r="$recipe" 'NR > 1 { printf "%s: %s, %d triangles: %s steps a second under kohout, %s by default\n", r, $1, $2, $3, $4 }' "$out/$recipe.tsv"
