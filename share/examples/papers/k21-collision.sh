#!/bin/sh
# [K21] 3.2 and figures 3 and 10: a muscle beside bones under the scheme kohout, with 3 iterations a step: without collision; with the paper's
# voxels, 64 along each axis, and about n_max = 262144 and 2097152 in all; with 64 where vertices that a bone hits stop, and are ignored
# (5, fig. 10); with distance fields in place of the voxels; and the default (qn, distance fields). Pictures of four of these side by side; memory,
# time of a step, how much deeper than at rest a vertex gets into a bone, and how the edges fare.
# Without SURFACE: the peroneus longus of the leg in $DATA, between fibula and tibia, which turn by a degree a frame about the ankle, and the
# foot, which stands; or where that is not to be had, the triceps of the generated arm at the bending elbow.
# Usage: k21-collision.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
swing='ulna 0,0,0 0,-1,0 4'
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
leg=${DATA:-}/leg-vhf/meshes/VHF_Left
if [ "$given" -eq 0 ] && [ -e "${leg}_Muscle_PeroneusLongus_smooth.ply" ]; then
    exec "$0" -o "$out" ${triangles:+-t "$triangles"} ${frames:+-f "$frames"} ${iterations:+-i "$iterations"} -u mm \
        -j "tibia 510.8,425.2,143.2 1,0,0 -1" \
        -b "tibia=${leg}_Bone_Tibia_smooth.ply+ fibula=${leg}_Bone_Fibula_smooth.ply+ foot=${leg}_Bone_Talus_smooth.ply calcaneus=${leg}_Bone_Calcaneous_smooth.ply" \
        "${leg}_Muscle_PeroneusLongus_smooth.ply" --distance 1mm --bone "tibia=${leg}_Bone_Tibia_smooth.ply" \
        --bone "fibula=${leg}_Bone_Fibula_smooth.ply" --pin foot=half:0,0,162.104,0,0,-1
fi
frames=${frames:-30} iterations=${iterations:-3}
if [ "$given" -eq 0 ]; then
    say "no real anatomy at ${DATA:-\$DATA}: this is the triceps of the generated arm"
    generate "${triangles:-4000}"
    surface=$out/arm/triceps.ply more="radius=$out/arm/radius.ply+"
    set -- --bone "scapula=$out/arm/scapula.ply" --bone "humerus=$out/arm/humerus.ply" --bone "ulna=$out/arm/ulna.ply"
fi
rig muscle "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
mkdir -p "$out/frames"

# whole NAME REPORT: the sum of its values
whole() { sed -n 's/.*"'"$1"'": \([0-9.e+-]*\),*$/\1/p' "$2" | awk '{ x += $1 } END { print x + 0 }'; }

# memory REPORT KIND: what voxels, or fields, take: KB, and KB with a byte for each cell, as the paper counts
memory() {
    case $2 in
    voxel) sed -n '/"voxels": \[$/,/^ *\]/p' "$1" > "$out/part" && echo "$(whole cells "$out/part") $(whole bytes "$out/part") $(whole bytesPublished "$out/part")" ;;
    field) sed -n '/"fields": \[$/,/^ *\]/p' "$1" > "$out/part" && echo "nan $(whole bytes "$out/part") nan" ;;
    none) echo '0 0 0' ;;
    esac | awk '{ printf "%s\t%s\t%s", $1, $2 == "nan" ? $2 : sprintf("%.0f", $2 / 1024), $3 == "nan" ? $3 : sprintf("%.0f", $3 / 1024) }'
}

# run NAME KIND OPTION...: a row of the table
run() {
    case=$1 kind=$2
    shift 2
    cp "$out/muscle.muscle.json" "$out/$case.muscle.json"
    [ "$kind" = none ] || set -- "$@" --grid-cache "$out/fields"
    run_on "$out/$case.scene.json" "$@" --threads 1 --log "$out/log.jsonl" --report "$out/time.json" -o "$out/frames/$case.pc2" -q
    printf '%s\t%s\t%s\t' "$case" "$(memory "$out/time.json" "$kind")" "$(awk -F '[:,]' '/"medianFrameSeconds"/ { printf "%.2f", 1000 * $2 }' "$out/time.json")"
    member penetration < "$out/log.jsonl" | awk 'BEGIN { most = 0 } $1 > most { most = $1 } END { if (NR) printf "%.3f\t", 1000 * most; else printf "nan\t" }'
    tail -n 1 "$out/log.jsonl" | awk '{
        match($0, /"volume_error":[^,]*/); v = substr($0, RSTART + 15, RLENGTH - 15)
        match($0, /"largest_edge_ratio":[^,]*/); e = substr($0, RSTART + 21, RLENGTH - 21)
        match($0, /"dihedral":{"rms":[^,]*/); d = substr($0, RSTART + 18, RLENGTH - 18)
        printf "%.3f\t%.2f\t%.3f\n", 100 * v, e, d }'
}
kohout="--scheme kohout --substeps 1 --iterations $iterations"
cases='none voxels-64 n-max n-max-8 stop-64 ignore-64 field default'
for name in $cases; do scene "$name" "$frames" '' "$@"; done
{
    printf 'case\tcells\tkb\tpublished_kb\tstep_ms\tdeepest_mm\tvolume_error_%%\tlongest_edge\tangle_rms\n'
    # shellcheck disable=SC2086
    {
        run none none $kohout
        run voxels-64 voxel $kohout --contact
        run n-max voxel $kohout --contact --voxels total:262144
        run n-max-8 voxel $kohout --contact --voxels total:2097152
        run stop-64 voxel $kohout --contact --bone-hits stop
        run ignore-64 voxel $kohout --contact --bone-hits ignore
        run field field $kohout --contact --collision field
        run default field --contact
    }
} > "$out/$recipe.tsv"
rm -rf "$out/log.jsonl" "$out/time.json" "$out/part" "$out/fields"
set --
for name in none voxels-64 n-max-8 default; do set -- "$@" "$out/$name.scene.json"; done
rig-view "$@" --frames "$out/frames" --frame "$frames" --show surface,bones,wire --columns $# --size 300x700 -q \
    --title "kohout without collision, with 64 voxels along an axis, with 2097152; the default" -o "$out/$recipe.png"
say "$out/$recipe.tsv, $out/$recipe.png"
awk -F '\t' -v r="$recipe" 'NR > 1 { printf "%s: %-9s %7s cells in %5s KB (a byte each: %5s), %7s ms a step, %s mm deeper than at rest, longest edge %s\n",
    r, $1, $2, $3, $4, $5, $6, $8 }' "$out/$recipe.tsv"
at() { awk -F '\t' -v n="$1" -v c="$2" '$1 == n { print $c }' "$out/$recipe.tsv"; }
claim "section 3.2: longest edge with 64 voxels along an axis; n_max = 2097152; with hits ignored, $iterations iterations" "-" "$(at voxels-64 8); $(at n-max-8 8); $(at ignore-64 8)" "$(at default 8)"
claim "the same: deepest in bone beyond rest, mm" "0; 0; -" "$(at voxels-64 6); $(at n-max-8 6); $(at ignore-64 6)" "$(at default 6)"
