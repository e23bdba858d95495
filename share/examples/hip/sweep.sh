#!/bin/sh
# A joint goes there and back (dog.sh, joint.sh, ../leg/ankle.sh): its muscles among the bones by sinew's default, with as many iterations as
# moment arms need, lengths of all fibres, and what is left over: volume, depth in bones, moment arms of both sweeps.
#
#   sweep.sh [-o OUT] [-i ITERATIONS] [-g CACHE] [-s SIGN] [-x OPTIONS] SCENE COLUMN
#
# Leaves in OUT (sweep): lengths.tsv, log.jsonl, arms.tsv (arms.awk; COLUMN is its column, SIGN -1 turns the angle around), sweep.tsv, a line a
# muscle, moment-arm.tsv (moment-arm, of COLUMN as it is), and arms.svg and arms.png by gnuplot. ITERATIONS is at most how many a step (40); CACHE keeps the bones' distance fields; OPTIONS are more of
# simulate's. Where muscles have no fibres they get 100 of 15 pieces, in copies of the folder rigs beside SCENE and of SCENE itself (filled/, -filled).
# Exit status: 0 done; 1 bad input; 2 wrong usage; 3 a muscle has exploded, or there is no gnuplot.
set -eu
LC_ALL=C
export LC_ALL
here=$(cd "$(dirname "$0")" && pwd)
out=sweep iterations=40 cache='' sign=1 more=''
usage() {
    sed -n '2,11s/^#\( \|$\)//p' "$0"
    exit "$1"
}
while getopts o:i:g:s:x:h option; do
    case $option in
    o) out=$OPTARG ;;
    i) iterations=$OPTARG ;;
    g) cache=$OPTARG ;;
    s) sign=$OPTARG ;;
    x) more=$OPTARG ;;
    h) usage 0 ;;
    *) usage 2 ;;
    esac
done
shift $((OPTIND - 1))
[ $# -eq 2 ] || usage 2
scene=$1 column=$2
[ -r "$scene" ] || { echo "sweep.sh: $scene cannot be read" >&2; exit 1; }
mkdir -p "$out"
cache=${cache:-$out/fields}

# rigs without fibres, beside the scene: the same scene with fibres
folder=$(dirname "$scene")
made=$scene
if [ -n "$(grep -L '"polylines"' "$folder"/rigs/*.muscle.json 2> /dev/null)" ]; then
    made=$folder/$(basename "$scene" .scene.json)-filled.scene.json
    mkdir -p "$folder/filled"
    for rig in "$folder"/rigs/*.muscle.json; do
        if grep -q '"polylines"' "$rig"; then cp "$rig" "$folder/filled/"; else
            fiber-fill -q --fibers 100 --segments 15 "$rig" -o "$folder/filled/$(basename "$rig")" || [ $? -eq 3 ]
        fi
    done
fi
[ "$made" = "$scene" ] || sed 's|"rigs/|"filled/|' "$scene" > "$made"

status=0
# shellcheck disable=SC2086
simulate "$made" --contact --grid-cache "$cache" --iterations "$iterations" $more --lengths "$out/lengths.tsv" --log "$out/log.jsonl" \
    --report "$out/report.json" -o "$out/frames" -q || status=$?
[ "$status" -eq 0 ] || { echo "sweep.sh: simulate ended with status $status; there are no moment arms" >&2; exit "$status"; }
awk -f "$here/arms.awk" -v over="$column" -v sign="$sign" -v summary="$out/summary.tsv" "$out/lengths.tsv" > "$out/arms.tsv"
# the same by splines with their noise: 3 where another coordinate moves along with this one
moment-arm -q "$out/lengths.tsv" --coordinate "$column" --report "$out/moment-arm.json" -o "$out/moment-arm.tsv" || [ $? -eq 3 ]
# worst of all frames by muscle: volume error, %; penetration beyond rest, mm; longest edge; frames torn
awk -F '\t' '
    FNR == 1 { file++ }
    function value(name) { return match($0, "\"" name "\":[^,}]*") ? substr($0, RSTART + length(name) + 3, RLENGTH - length(name) - 3) : "nan" }
    file == 1 {
        match($0, /"muscle":"[^"]*"/); m = substr($0, RSTART + 10, RLENGTH - 11)
        v = value("volume_error"); v += 0; if (v < 0) v = -v; if (v > volume[m] + 0) volume[m] = v
        p = value("penetration"); if (p == "nan") deep[m] = p; else if (p + 0 > deep[m] + 0) deep[m] = p
        e = value("largest_edge_ratio"); if (e + 0 > edge[m] + 0) edge[m] = e
        torn[m] += value("torn") == "true" || value("torn") == 1
        next
    }
    FNR == 1 { print $0 "\tvolume_error_%\tdeepest_mm\tlongest_edge\ttorn_frames"; next }
    { print $0 "\t" sprintf("%.3f\t%s\t%.2f\t%d", 100 * volume[$1], deep[$1] == "nan" ? "nan" : sprintf("%.4f", 1000 * deep[$1]), edge[$1], torn[$1]) }' \
    "$out/log.jsonl" "$out/summary.tsv" > "$out/sweep.tsv"
rm -f "$out/summary.tsv"
awk -F '\t' 'NR > 1 { printf "sweep.sh: %s: fibres %.1f mm, %.1f at the turn (least %.1f at %.0f), %d of %d longer; arm %.1f to %.1f mm, sweeps differ by %s %% of its range at %s (rms %s); volume %s %%, %s mm deeper than at rest, longest edge %s\n",
    $1, $3, $4, $5, $6, $7, $2, $8, $9, $11, $12, $13, $14, $15, $16 }' "$out/sweep.tsv"
if ! command -v gnuplot > /dev/null; then
    echo "sweep.sh: there is no gnuplot: $out/arms.tsv has the figures, and there is no chart" >&2
    exit 3
fi
for kind in svg png; do
    gnuplot -e "data = '$out/arms.tsv'; picture = '$out/arms.$kind'; kind = '$kind'; muscles = '$(awk -F '\t' 'NR > 1 { printf "%s ", $1 }' "$out/sweep.tsv")'" \
        "$here/arms.gp"
done
