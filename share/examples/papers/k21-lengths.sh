#!/bin/sh
# [K21] figures 12 to 15: the length of each of 100 fibres over a flexion of 90 degrees, smoothed five times as the paper does, by kohout with
# 10 iterations a step and by the default, and beside them those of the skinning blend of Modenese and Kohout; pictures at 20, 50 and 70 degrees.
# Usage: k21-lengths.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-$(frames_to 90)} iterations=${iterations:-10}
plots=${SINEW_PLOTS:-$here/../../plots}
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig bare "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
fiber-fill -q --fibers 100 --segments 15 "$out/bare.muscle.json" -o "$out/muscle.muscle.json" || [ $? -eq 3 ]
scene muscle "$frames" '' "$@"
command -v gnuplot > /dev/null || { say "there is no gnuplot: there are no charts" >&2; missing=chart; }
# the frames of the pictures, of those that are run
shown=$(for d in 20 50 70; do frames_to "$d"; done | awk -v last="$frames" '$1 <= last { x = x (n++ ? "," : "") $1 } END { print n ? x : last }')
title=${muscle:-$(basename "${surface%.*}")}
run() { # KIND OPTION...
    kind=$1
    shift
    mkdir -p "$out/$kind"
    run_on "$out/muscle.scene.json" "$@" --fibers --lengths "$out/$kind.lengths.tsv" --smooth-lengths --blend 1 --log "$out/log.jsonl" -o "$out/$kind" -q
    if wild "$out/log.jsonl"; then
        say "$kind blew up: it is not drawn"
        rm -f "$out/$kind.lengths.tsv"
        return
    fi
    # shellcheck disable=SC2046
    rig-view "$out/muscle.scene.json" --frames "$out/$kind" --frame "$shown" --show surface,fibers,bones $(focus_on) --columns 3 --size 420x420 \
        --title "$title, $kind" -q -o "$out/$recipe-$kind-shapes.png"
    say "$out/$recipe-$kind-shapes.png"
    [ -n "$missing" ] || "$plots/fiber-lengths" --over joint --title "$title, $kind" "$out/$kind.lengths.tsv" "$out/$recipe-$kind.svg" "$out/$recipe-$kind.png"
    awk -F '\t' -v kind="$kind" '
        NR == 1 { for (i = 1; i <= NF; i++) { if ($i == "joint.angle") x = i; else if ($i ~ /^muscle\.[0-9]+$/) own[++n] = i; else if ($i ~ /^muscle\.blend\.[0-9]+$/) other[++b] = i } next }
        { least = 1e9; most = sum = blend = 0
          for (k = 1; k <= n; k++) { v = 1000 * $own[k]; if (NR == 2) first[k] = v; last[k] = v; sum += v; if (v < least) least = v; if (v > most) most = v }
          for (k = 1; k <= b; k++) blend += 1000 * $other[k]
          line[NR] = kind "\t" sprintf("%.6g", $x) "\t" least "\t" sum / n "\t" most "\t" blend / b }
        END { for (k = 1; k <= n; k++) grew += last[k] > first[k]; for (i = 2; i <= NR; i++) print line[i] "\t" grew "\t" n }' "$out/$kind.lengths.tsv" >> "$out/$recipe.tsv"
}
printf 'scheme\tdegrees\tleast_mm\tmean_mm\tgreatest_mm\tblend_mean_mm\tgrew_over_all\tfibres\n' > "$out/$recipe.tsv"
# shellcheck disable=SC2086
{
    run kohout --scheme kohout --substeps 1 --iterations "$iterations" $obstacles ${contact:+$voxels}
    run default $obstacles
}
rm -f "$out/log.jsonl"
at() { awk -F '\t' -v s="$1" '$1 == s { if (!n++) first = $4; last = $4; l = $3; g = $5; grew = $7 " of " $8; b = $6 }
    END { if (n) printf "%.1f to %.1f (%.1f-%.1f), %s grew, blend %.1f", first, last, l, g, grew, b; else print "blew up" }' "$out/$recipe.tsv"; }
claim "figs 12-15: mean fibre length of $title over the flexion (range at the end), mm" "charts" "$(at kohout)" "$(at default)"
say "$out/$recipe-kohout.svg, $out/$recipe-default.svg, $out/$recipe.tsv"
for kind in kohout default; do say "$title, $kind: $(at "$kind")"; done
