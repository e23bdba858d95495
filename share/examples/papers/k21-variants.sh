#!/bin/sh
# [K21] figure 10: a muscle at a flexion of 40 degrees with 5 iterations a step by kohout: points fixed by collision with voxels (n_max = 8 x 262144);
# by areas; by areas without the handling of bones that hit the muscle; and the default. Bones are obstacles in all of them.
# Usage: k21-variants.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-$(frames_to 40)} iterations=${iterations:-5}
obstacles=$fields
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
n=$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)
touching=$(bones_of "$@")
[ -n "$touching" ] || { say "give the bones' surfaces by --bone" >&2; exit 2; }
mkdir -p "$out/frames"
# shellcheck disable=SC2086
rig collision "$n" --raw --method contact --voxels 2097152 $touching
rig areas "$n" "$@"
for name in areas-ignore default; do cp "$out/areas.muscle.json" "$out/$name.muscle.json"; done
row() { # NAME OPTION...
    name=$1
    shift
    scene "$name" "$frames" '' $scene_options
    if run_on "$out/$name.scene.json" "$@" --log "$out/log.jsonl" -o "$out/frames/$name.pc2" -q && ! wild "$out/log.jsonl"; then
        deepest=$(member penetration < "$out/log.jsonl" | awk '$1 > most { most = $1 } END { if (NR) printf "%.3f", 1000 * most; else printf "nan" }')
        tail -n 1 "$out/log.jsonl" | awk -v name="$name" -v d="$deepest" '{
            match($0, /"volume_error":[^,]*/); v = substr($0, RSTART + 15, RLENGTH - 15)
            match($0, /"largest_edge_ratio":[^,]*/); e = substr($0, RSTART + 21, RLENGTH - 21)
            match($0, /"mesh":{"rms":[^,]*/); m = substr($0, RSTART + 14, RLENGTH - 14)
            match($0, /"dihedral":{"rms":[^,]*/); a = substr($0, RSTART + 18, RLENGTH - 18)
            printf "%s\t%.3f\t%.2f\t%.3f\t%.3f\t%s\n", name, 100 * v, e, m, a, d }'
    else
        rm -f "$out/frames/$name.pc2"
        printf '%s\tnan\tnan\tnan\tnan\tnan\n' "$name"
    fi
}
scene_options=$*
{
    printf 'variant\tvolume_error_%%\tlongest_edge\tedge_rms\tangle_rms\tdeepest_mm\n'
    # shellcheck disable=SC2086
    {
        row collision --scheme kohout --substeps 1 --iterations "$iterations" $obstacles $voxels
        row areas --scheme kohout --substeps 1 --iterations "$iterations" $obstacles $voxels
        row areas-ignore --scheme kohout --substeps 1 --iterations "$iterations" $obstacles $voxels --bone-hits ignore
        row default $obstacles
    }
} > "$out/$recipe.tsv"
rm -f "$out/log.jsonl"
set --
for name in collision areas areas-ignore default; do
    if [ -e "$out/frames/$name.pc2" ]; then set -- "$@" "$out/$name.scene.json"; else say "$name blew up"; fi
done
# shellcheck disable=SC2046
rig-view "$@" --frames "$out/frames" --frame "$frames" --show surface,wire,bones $(focus_on) --columns 4 --size 420x420 \
    --title "points by collision; areas; areas, bones that hit the muscle ignored; the default" -q -o "$out/$recipe.png"
say "$out/$recipe.png, $out/$recipe.tsv"
at() { awk -F '\t' -v n="$1" -v c="$2" '$1 == n { print $c }' "$out/$recipe.tsv"; }
claim "fig. 10: ${muscle:-$(basename "${surface%.*}")}, longest edge; angles' rms, rad; deepest in bone beyond rest, mm: points by collision" "unrealistic" "$(at collision 3); $(at collision 5); $(at collision 6)" "-"
claim "the same: areas" "slightly better" "$(at areas 3); $(at areas 5); $(at areas 6)" "$(at default 3); $(at default 5); $(at default 6)"
claim "the same: areas, bones that hit ignored" "acceptable, a small penetration" "$(at areas-ignore 3); $(at areas-ignore 5); $(at areas-ignore 6)" "-"
awk -F '\t' -v r="$recipe" 'NR > 1 { printf "%s: %-12s volume error %s %%, longest edge %s, angles %s rad rms, %s mm deeper than at rest\n", r, $1, $2, $3, $5, $6 }' "$out/$recipe.tsv"
