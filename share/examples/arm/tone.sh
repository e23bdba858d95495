#!/bin/sh
# tone.sh -- how far a passive muscle folds as its bones come nearer, and what tone and restLength do about it.   simulate(1), "Tone"
# Usage: tone.sh OUT RIG SCENE-BUILD-OPTION...
# RIG is a muscle document; the options are those of scene-build that make its scene: --motion, -b, --bind, --frames, ...
# Prints a line for each setting, under both solvers: the largest change of an angle between neighbouring triangles from rest to the last frame,
# the change that 99 % stay below, their root mean square (degrees), and the largest over that of the passive muscle. Leaves them as OUT/tone.tsv,
# OUT/tone.png (without, and with a restLength of 0.8), and scenes, logs and last shapes.
# The tools are on the PATH; FOLDS is the program folds where it is not the installed one.
set -eu
LC_ALL=C
export LC_ALL
if [ $# -lt 3 ]; then
    sed -n '2,8s/^# //p' "$0" >&2
    exit 2
fi
folds=${FOLDS:-$(cd "$(dirname "$0")" && pwd)/../../../../libexec/sinew/folds}
command -v "$folds" > /dev/null || { echo "tone.sh: there is no program '$folds', which measures folds; name it by FOLDS" >&2; exit 1; }
out=$1 rig=$2
shift

# NAME: what it sets of the muscle
settings='passive tone-0.2 restLength-0.9 restLength-0.8 restLength-0.7 both'
members() {
    case $1 in
    passive) ;;
    both) echo '--set *.tone=0.2 --set *.restLength=0.9' ;;
    *) echo "--set *.${1%-*}=${1#*-}" ;;
    esac
}

# last FOLDER: its files of the last frame
last() { find "$1" -name '*.ply' | sed 's|.*/||' | sort | awk -F . '{ number = $(NF - 1) + 0; name[NR] = $0; of[NR] = number; if (number > most) most = number }
    END { for (i = 1; i <= NR; i++) if (of[i] == most) print name[i] }'; }

# run SOLVER SETTING SCENE-BUILD-ARGUMENT...: OUT/SETTING.SOLVER.ply, the muscle in the last frame; the first run leaves OUT/bones, too
run() {
    name=$2.$1 solver=$1
    set -f # words, but no patterns
    # shellcheck disable=SC2046
    set -- "$@" $(members "$2")
    set +f
    shift 2
    scene-build -q "$@" --set '*.law=isochoric' --solver "$solver" -o "$out/$name.scene.json"
    set -- "$out/$name.scene.json" --format ply -o "$out/frames" --log "$out/$name.jsonl"
    [ -d "$out/bones" ] || set -- "$@" --bone-frames "$out/bones"
    # a muscle that explodes (3) has figures, too
    simulate -q "$@" || [ $? -eq 3 ]
    mv "$out/frames/$(last "$out/frames")" "$out/$name.ply"
    rm -r "$out/frames"
}

mkdir -p "$out"
rm -rf "$out/bones" "$out/frames"
for solver in qn xpbd; do
    for setting in $settings; do run $solver "$setting" "$@"; done
done
# passive stands first of its solver: the others are over it
for solver in qn xpbd; do
    for setting in $settings; do "$folds" "$rig" "$out/$setting.$solver.ply" | sed -n "2s/^[^\t]*/$solver\t$setting/p"; done
done | awk -F '\t' -v OFS='\t' 'BEGIN { print "solver", "setting", "largest", "p99", "rms", "over passive" }
    $2 == "passive" { passive = $3 } { print $1, $2, $3, $4, $5, (passive > 0 ? sprintf("%.2f", $3 / passive) : "-") }
    END { exit NR != 12 }' > "$out/tone.tsv" || { echo "tone.sh: not every shape could be measured" >&2; exit 1; }
cat "$out/tone.tsv"
(last "$out/bones") > "$out/last"
mv "$out/last" "$out/bones/last.txt"
rig-view -q "$out/passive.qn.ply" "$out/restLength-0.8.qn.ply" "$out/passive.xpbd.ply" "$out/restLength-0.8.xpbd.ply" --bones "$out/bones/last.txt" \
    --camera front --columns 4 --size 240x300 --title "A passive muscle without and with restLength 0.8, under qn and xpbd" -o "$out/tone.png"
