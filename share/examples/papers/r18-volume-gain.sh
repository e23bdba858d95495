#!/bin/sh
# [R18] figures 7 and 17: a biceps at rest, active with its volume kept (1.0), and active with a volume gain of 1.3, 1.5 and 2.0, from two
# sides. The bone follows the muscle: the elbow bends by 120 degrees in the first third of the frames, while activation rises, and is held.
# By the paper's scheme (romeo) and by the default.
# Usage: r18-volume-gain.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
swing='radius 0,0,0 0,-1,0 10'
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-36}
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig muscle "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"

turned=$((frames / 3)) turning=$joint scenes=''
for gain in rest 1.0 1.3 1.5 2.0; do
    members=', "law": "isochoric", "contraction": 0.26'
    rise="{ \"keys\": [[0, 0], { \"frame\": $turned, \"activation\": 1 }], \"interpolation\": \"smooth\" }"
    joint="${turning% *} 0" name=rest
    if [ "$gain" != rest ]; then
        members="$members, \"volumeRatio\": $gain, \"activation\": $rise"
        joint=$turning name=gain-$gain
    fi
    cp "$out/muscle.muscle.json" "$out/$name.muscle.json"
    scene "$name" "$frames" "$members" "$@"
    scenes="$scenes $name"
done
printf 'gain\tromeo\tromeo_error\tdefault\tdefault_error\n' > "$out/$recipe.tsv"
for name in $scenes; do
    figures=''
    for scheme in romeo guarded; do
        mkdir -p "$out/$scheme"
        run_on "$out/$name.scene.json" --solver xpbd --scheme "$scheme" -o "$out/$scheme/$name.pc2" --log "$out/log.jsonl" -q
        figures="$figures	$(tail -n 1 "$out/log.jsonl" | member volume_ratio)	$(tail -n 1 "$out/log.jsonl" | member volume_error)"
    done
    printf '%s%s\n' "${name#gain-}" "$figures" >> "$out/$recipe.tsv"
done
rm "$out/log.jsonl"
set --
for name in $scenes; do set -- "$@" "$out/$name.scene.json"; done
for scheme in romeo guarded; do
    for side in front right; do
        rig-view "$@" --frames "$out/$scheme" --frame "$frames" --show surface --camera "$side" --columns 5 --size 220x480 -q \
            --title "$scheme, from the $side: at rest, and active with volume gain 1.0, 1.3, 1.5, 2.0" -o "$out/$recipe-$scheme-$side.png"
        say "$out/$recipe-$scheme-$side.png"
    done
done
chart "$recipe"
awk -F '\t' -v r="$recipe" 'NR > 1 { printf "%s: %4s: volume %.4f under romeo, %.4f by default\n", r, $1, $2, $4 }' "$out/$recipe.tsv"
at() { awk -F '\t' -v c="$1" 'NR > 1 { x = x (n++ ? "; " : "") sprintf("%.4f", $c) } END { print x }' "$out/$recipe.tsv"; }
claim "R18, figs 7, 17: volume over that at rest for a gain of none; 1.0; 1.3; 1.5; 2.0 (romeo, not kohout)" "pictures" "$(at 2) (romeo)" "$(at 4) (guarded)"
