#!/bin/sh
# [K21] figure 8: anisotropy off and on at a flexion of 40 degrees (40 frames), with 1, 3, 5, 10 and 100 iterations a step.
# Pictures of both, coloured by the error of the edges on one scale, and figures: the mean length of edges along and across the fibres over
# that at rest, and how far the two shapes are apart. The paper: "surprisingly, it is barely observable". Runs that blew up are not drawn.
# Usage: k21-anisotropy.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i "ITERATIONS ..."] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-$(frames_to 40)} iterations=${iterations:-1 3 5 10 100}
lengths=$(program lengths papers)
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig muscle "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
scene muscle "$frames" '' "$@"

on_voxels() { [ "$1" != kohout ] || [ -z "$contact" ] || echo "$voxels"; }
# run SCHEME FORM ITERATIONS: false where it blew up
run() {
    run=$out/$1-$2-$3
    # shellcheck disable=SC2086
    run_on "$out/muscle.scene.json" --solver xpbd --scheme "$1" --anisotropy "$2" --substeps 1 --iterations "$3" $obstacles $(on_voxels "$1") --state "$run.state" -o "$run.pc2" \
        --log "$out/log.jsonl" -q || return 1
    ! wild "$out/log.jsonl" && return 0
    return 1
}
# "ALONG ACROSS APART" at the last frame
last() { "$lengths" "$out/muscle.muscle.json" "$@" | awk -F '\t' 'END { print $2 "\t" $3 "\t" $5 }'; }

printf 'scheme\titerations\talong_off\tacross_off\talong_on\tacross_on\tapart_edges\n' > "$out/$recipe.tsv"
for pair in kohout:pbd guarded:xpbd; do
    scheme=${pair%:*} form=${pair#*:} drawn=''
    for i in $iterations; do
        if run "$scheme" none "$i" && run "$scheme" "$form" "$i"; then
            off=$(last "$out/$scheme-none-$i.pc2") on=$(last "$out/$scheme-$form-$i.pc2" "$out/$scheme-none-$i.pc2")
            drawn="$drawn $i"
        else
            say "$scheme with $i iterations blew up"
            off='nan	nan	nan' on='nan	nan	nan'
        fi
        printf '%s\t%s\t%s\t%s\n' "$scheme" "$i" "$(echo "$off" | cut -f 1,2)" "$on" >> "$out/$recipe.tsv"
    done
    printf '\n\n' >> "$out/$recipe.tsv" # gnuplot: another data set
    [ -n "$drawn" ] || continue
    set --
    for kind in none "$form"; do for i in $drawn; do set -- "$@" --state "$out/$scheme-$kind-$i.state"; done; done
    # shellcheck disable=SC2086
    rig-view "$out/muscle.scene.json" ${contact:+--contact} --solver xpbd --scheme "$scheme" --substeps 1 "$@" --columns $(($# / 4)) --size 300x440 ${muscle:+--camera 60:0} $([ -n "$muscle" ] || echo "--camera front") -q \
        --title "$scheme: anisotropy off (above) and on (below), iterations:$drawn" -o "$out/$recipe-$scheme.png"
    say "$out/$recipe-$scheme.png"
done
rm -f "$out"/*.state "$out"/*.pc2 "$out/log.jsonl"
chart "$recipe"
at() { awk -F '\t' -v s="$1" -v c="$2" '$1 == s { x = x (n++ ? "; " : "") sprintf("%.3f", $c) } END { print x }' "$out/$recipe.tsv"; }
claim "fig. 8: length of edges along the fibres, over that at rest, with $iterations iterations: anisotropy off" "pictures" "$(at kohout 3)" "$(at guarded 3) (guarded)"
claim "the same, on" "\"barely observable\"" "$(at kohout 5)" "$(at guarded 5) (guarded)"
awk -F '\t' -v r="$recipe" 'NF == 7 && NR > 1 {
    printf "%s: %s, %3d iterations: along %.4f, across %.4f off; %.4f, %.4f on; %.3f edges apart\n", r, $1, $2, $3, $4, $5, $6, $7 }' "$out/$recipe.tsv"
