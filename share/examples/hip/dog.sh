#!/bin/sh
# The dog's left hip: gluteus superficialis, medius and profundus, iliacus, psoas major, adductor longus and magnus, with attachment areas
# around the sites of dm_control's model, among pelvis, sacrum, the first tail vertebra, the lumbar spine and the femur; the hip flexes on
# the model's own joint and goes back.
#
#   dog.sh [-d DEGREES] [-p STEP] [-R RATE] DOG OUT [JOINT-OPTION ...]
#
# DOG is the folder of dog.xml, attachments.tsv and meshes/; the hip goes to DEGREES (90) of flexion by STEP (2) a frame, RATE (10) frames a
# second. JOINT-OPTIONs are those of joint.sh; before them it has -e 3mm -s *.stiffness.volume=16000 (volumes four times as stiff
# as by default, which keeps them within 1 %). The scene is OUT/hip.scene.json, the coordinate hip_L_extend, in which flexion is negative.
set -eu
LC_ALL=C
export LC_ALL
here=$(cd "$(dirname "$0")" && pwd)
step=2 rate=10 degrees=90
usage() {
    sed -n '2,10s/^#\( \|$\)//p' "$0"
    exit "$1"
}
while getopts d:p:R:h option; do
    case $option in
    d) degrees=$OPTARG ;;
    p) step=$OPTARG ;;
    R) rate=$OPTARG ;;
    h) usage 0 ;;
    *) usage 2 ;;
    esac
done
shift $((OPTIND - 1))
[ $# -ge 2 ] || usage 2
[ -e "$1/dog.xml" ] || { echo "dog.sh: there is no dog.xml in $1" >&2; exit 1; }
dog=$(cd "$1" && pwd) out=$2
shift 2
rm -rf "$out/near"
mkdir -p "$out/near"
awk -f "$here/flexion.awk" -v coordinate=hip_L_extend -v to="-$degrees" -v step="$step" -v rate="$rate" > "$out/flexion.sto"
# the model's bones in their places; the scene has those that are near, on joints of its own motion
motion-import -q "$out/flexion.sto" --skeleton "$dog/dog.xml" --bones "$out/bones" --bone-path "$dog/meshes" -o "$out/all.motion.json"
motion-import -q "$out/flexion.sto" --skeleton "$dog/dog.xml" -o "$out/hip.motion.json"
for bone in Pelvis Sacrum Ca_1 Femoris_L L_1 L_2 L_3 L_4 L_5 L_6 L_7; do
    [ -e "$out/bones/$bone.ply" ] || { echo "dog.sh: $dog has no bone $bone" >&2; exit 1; }
    mv "$out/bones/$bone.ply" "$out/near/"
done
rm -rf "$out/bones" "$out/all.motion.json"
printf '' > "$out/muscles.tsv"
for muscle in gluteus_superficialis_major gluteus_medius gluteus_profundus_minor iliacus psoas_major adductor_longus adductor_magnus; do
    printf '%s\t%s\n' "$muscle" "$dog/meshes/MUSCm.${muscle}_L.stl" >> "$out/muscles.tsv"
done
# Sites of bones that are here; what is on the femur is an insertion, what stands an origin.
awk -F '\t' '
    FNR == 1 { file++ }
    file == 1 { wanted[$1]; next }
    { muscle = $1; bone = $8; sub(/_L$/, "", muscle); gsub(/^BONE|\.stl$/, "", bone) }
    FNR > 1 && muscle in wanted && bone != "" {
        end = bone == "Femoris_L" ? "insertion" : "origin"
        printf "%s\t%s\t%s\t%s\t%s\t%s\n", muscle, bone, end (n[muscle, end]++ ? " " n[muscle, end] : ""), $3, $4, $5
    }' "$out/muscles.tsv" "$dog/attachments.tsv" > "$out/sites.tsv"
"$here/joint.sh" -n hip -e 3mm -j Femoris_L=upper_leg_L -s "*.stiffness.volume=16000" "$@" "$out" "$out/muscles.tsv" "$out/sites.tsv" "$out/near" "$out/hip.motion.json"
# the hinge of the papers' recipes: "BONE point axis degrees-a-frame", flexion positive
awk -v step="$step" '
    /"name": *"upper_leg_L"/ { on = 1 }
    on && match($0, /"rest": *\[[^]]*\]/) { rest = substr($0, RSTART, RLENGTH); gsub(/.*\[| |\].*/, "", rest); print "Femoris_L " rest " 0,-1,0 " step; found = 1; exit }
    END { exit !found }' "$out/hip.motion.json" > "$out/joint.txt" || { echo "dog.sh: the motion has no joint upper_leg_L" >&2; exit 1; }
