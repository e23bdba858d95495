#!/bin/sh
# [K21] figures 4 and 5: which vertices are fixed to bones by contact with the voxels of the bones (64 along each axis); by proximity, within the
# mean edge, 0.5 mm and 1 mm; and by the attachment areas that are given (without landmarks: the patches of attach-detect). Pictures of
# all five side by side, and of what 40 degrees of flexion make of them with 5 iterations a step by kohout; counts for each bone and figures.
# Usage: k21-attachments.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-$(frames_to 40)} iterations=${iterations:-5}
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
n=$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)
touching=$(bones_of "$@")
[ -n "$touching" ] || { say "this compares ways to find what bones hold: give their surfaces by --bone" >&2; exit 2; }
mkdir -p "$out/kohout" "$out/default"
# shellcheck disable=SC2086
{
    rig contact "$n" --raw --method contact --voxels 262144 $touching
    rig mean-edge "$n" --raw --method proximity $touching
    rig 0.5mm "$n" --raw --method proximity --distance 0.5mm $touching
    rig 1mm "$n" --raw --method proximity --distance 1mm $touching
    rig areas "$n" "$@"
}
# held NAME: "BONE VERTICES, ..." and how many bones and vertices
held() { holds_of "$out/$1.muscle.json"; }
holds_of() {
    awk 'BEGIN { RS = "[{}]" } /"bone":/ && /"vertices":/ {
        match($0, /"bone": *"[^"]*"/); b = substr($0, RSTART, RLENGTH); gsub(/.*: *"|"$/, "", b)
        match($0, /"vertices": *\[[^]]*\]/); v = substr($0, RSTART, RLENGTH); n = gsub(/,/, ",", v) + 1
        text = text (bones++ ? ", " : "") b " " n; all += n }
        END { printf "%s\t%d\t%d", bones ? text : "nothing", bones, all }' "$1"
}
# outcome KIND NAME OPTION...: volume error in %, longest edge, deepest beyond rest in mm; nan where it blew up or has nothing to hold on
outcome() {
    kind=$1 name=$2
    shift 2
    if run_on "$out/$name.scene.json" "$@" --log "$out/log.jsonl" -o "$out/$kind/$name.pc2" -q && ! wild "$out/log.jsonl"; then
        deepest=$(member penetration < "$out/log.jsonl" | awk '$1 > most { most = $1 } END { if (NR) printf "%.3f", 1000 * most; else printf "nan" }')
        tail -n 1 "$out/log.jsonl" | sed 's/.*"volume_error":\([^,]*\).*"largest_edge_ratio":\([^,]*\).*/\1 \2/' |
            awk -v d="$deepest" '{ printf "%.3f\t%.2f\t%s", 100 * $1, $2, d }'
    else
        rm -f "$out/$kind/$name.pc2"
        printf 'nan\tnan\tnan'
    fi
}
printf 'way\theld\tbones\tvertices\tkohout_volume_%%\tkohout_longest_edge\tkohout_deepest_mm\tdefault_volume_%%\tdefault_longest_edge\tdefault_deepest_mm\n' > "$out/$recipe.tsv"
ways='contact mean-edge 0.5mm 1mm areas'
for way in $ways; do
    scene "$way" "$frames" '' "$@"
    # shellcheck disable=SC2086
    printf '%s\t%s\t%s\t%s\n' "$way" "$(held "$way")" \
        "$(outcome kohout "$way" --scheme kohout --substeps 1 --iterations "$iterations" $obstacles ${contact:+$voxels})" \
        "$(outcome default "$way" $obstacles)" >> "$out/$recipe.tsv"
done
rm -f "$out/log.jsonl"
set --
for way in $ways; do set -- "$@" "$out/$way.muscle.json"; done
rig-view "$@" --views 2 --columns 5 --size 380x300 --show surface,attachments,wire --title "fixed to bones: by voxels, within the mean edge, 0.5 mm, 1 mm, areas; from two sides" -q -o "$out/$recipe.png"
say "$out/$recipe.png"
for kind in kohout default; do
    set --
    for way in $ways; do if [ -e "$out/$kind/$way.pc2" ]; then set -- "$@" "$out/$way.scene.json"; else say "$way blew up under $kind"; fi; done
    [ $# -gt 0 ] || continue
    # shellcheck disable=SC2046
    rig-view "$@" --frames "$out/$kind" --frame "$frames" --show surface,attachments,bones $(focus_on) --columns 5 --size 380x380 --title "$kind, frame $frames" \
        -q -o "$out/$recipe-$kind.png"
    say "$out/$recipe-$kind.png"
done
at() { awk -F '\t' -v c="$1" 'NR > 1 { printf "%s%s", (NR > 2 ? "; " : ""), $c }' "$out/$recipe.tsv"; }
claim "figs 4, 5: vertices of ${muscle:-$(basename "${surface%.*}")} fixed by voxels; mean edge; 0.5 mm; 1 mm; areas" "pictures: areas the best" "$(at 4)" "the same"
claim "the same: longest edge over that at rest at the end, $iterations iterations" "-" "$(at 6)" "$(at 9)"
awk -F '\t' -v r="$recipe" 'NR > 1 { printf "%s: %-9s fixes %s; longest edge %s under kohout, %s by default\n", r, $1, $2, $6, $9 }' "$out/$recipe.tsv"
awk -F '\t' -v r="$recipe" 'NR > 1 && $3 < 2 { printf "%s: %s holds the muscle by %s bone alone: it only moves along\n", r, $1, $3 }' "$out/$recipe.tsv"
