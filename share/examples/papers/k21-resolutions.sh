#!/bin/sh
# [K21] figure 9: one muscle with 17124 (L0), 3000 (L1) and 1000 (L2) triangles at a flexion of 40 degrees (40 frames), 100 iterations a step,
# anisotropy on. mesh-clean --triangles decimates. The paper: the coarser ones look better in less time; L2 with 1000 iterations takes less
# than L0 with 100. Runs that blew up are told and not drawn.
# Usage: k21-resolutions.sh [-o OUT] [-t "L0 L1 L2"] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-$(frames_to 40)} iterations=${iterations:-100} triangles=${triangles:-17124 3000 1000}
[ "$given" -gt 0 ] || generate "${triangles%% *}"
mkdir -p "$out/kohout" "$out/guarded" "$out/default"

# run KIND NAME OPTION...: "MS VOLUME_ERROR MESH_RMS" of the last frame, its frames as OUT/KIND/NAME.pc2; nan where it blew up
run() {
    kind=$1 name=$2
    shift 2
    if run_on "$out/$name.scene.json" "$@" --threads 1 --log "$out/log.jsonl" --report "$out/time.json" -o "$out/$kind/$name.pc2" -q &&
        ! wild "$out/log.jsonl"; then
        awk -F '[:,]' '/"medianFrameSeconds"/ { printf "%.3f\t", 1000 * $2 }' "$out/time.json"
        tail -n 1 "$out/log.jsonl" | sed 's/.*"volume_error":\([^,]*\).*"mesh":{"rms":\([^,}]*\).*/\1\t\2/'
    else
        rm -f "$out/$kind/$name.pc2"
        printf 'nan\tnan\tnan\n'
    fi
}
printf 'level\ttriangles\titerations\tkohout_ms\tkohout_volume_error\tkohout_mesh_rms\tguarded_ms\tguarded_volume_error\tguarded_mesh_rms\tdefault_ms\tdefault_volume_error\tdefault_mesh_rms\n' > "$out/$recipe.tsv"
level=0
for n in $triangles; do
    rig "L$level" "$n" "$@"
    scene "L$level" "$frames" '' "$@"
    # the picture is that with the same iterations at all levels: the last to be run
    for i in $([ "$level" -lt 2 ] || echo $((10 * iterations))) $iterations; do
        # shellcheck disable=SC2086
        printf 'L%s\t%s\t%s\t%s\t%s\t%s\n' "$level" "$(count "L$level")" "$i" "$(run kohout "L$level" --scheme kohout --substeps 1 --iterations "$i" $obstacles ${contact:+$voxels})" \
            "$(run guarded "L$level" --solver xpbd --substeps 1 --iterations "$i" $obstacles)" "$(run default "L$level" $obstacles)" >> "$out/$recipe.tsv"
    done
    level=$((level + 1))
done
rm -f "$out/log.jsonl" "$out/time.json"
for kind in kohout guarded default; do
    set --
    for scene in "$out"/L?.scene.json; do
        name=$(basename "$scene" .scene.json)
        if [ -e "$out/$kind/$name.pc2" ]; then set -- "$@" "$scene"; else say "$name blew up under $kind with $iterations iterations"; fi
    done
    [ $# -gt 0 ] || continue
    # shellcheck disable=SC2086,SC2046
    rig-view "$@" --frames "$out/$kind" --frame "$frames" --show surface,wire --columns $# --size 300x600 ${muscle:+--camera 60:0} $([ -n "$muscle" ] || echo "--camera front") -q \
        --title "$kind$([ "$kind" = default ] || echo ", $iterations iterations a step")" -o "$out/$recipe-$kind.png"
    say "$out/$recipe-$kind.png"
done
chart "$recipe"
awk -F '\t' -v r="$recipe" 'NR > 1 { printf "%s: %s, %5d triangles, %4d iterations: kohout %8.2f ms a step, volume error %9.2e; guarded %8.2f ms, %9.2e; default %8.2f ms, %9.2e\n",
    r, $1, $2, $3, $4, $5, $7, $8, $10, $11 }' "$out/$recipe.tsv"
list() { awk -F '\t' -v c="$1" -v f="$2" 'NR > 1 { printf "%s" f, (NR > 2 ? "; " : ""), $c }' "$out/$recipe.tsv"; }
claim "fig. 9: a step of $(list 2 %d) triangles with $(list 3 %d) iterations, ms (default: its own)" "659; -; 350 (1000, 1000 iterations); -" "$(list 4 %.3g)" "$(list 10 %.3g)"
claim "the same: volume error at the end, of the volume" "< 0.01" "$(list 5 %.1e)" "$(list 11 %.1e)"
