#!/bin/sh
# attach-pairs.sh -- which bone does a muscle attach to? attach-detect on every muscle of the dog against all of its bones, compared with
# the 1,088 sites that its modeller placed. Prints precision and recall of the pairs. For information: geometry cannot tell an attachment
# from a tendon that slides over a bone. Options are handed to attach-detect.
#   BIN=build/release/bin DATA=../shared/data tests/bench/attach-pairs.sh [--method proximity ...]
set -eu
export LC_ALL=C
dog=${DATA:?the folder of test data}/dog-dmcontrol
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for bone in "$dog"/meshes/BONE*.stl; do
    printf '%s\t%s\n' "$(basename "$bone" .stl)" "$bone"
done > "$work/bones"
# Sites name single ribs, vertebrae, skull bones; the meshes hold the rib cage with its vertebrae, the skull and the jaw in one piece each.
awk -F'\t' 'NR > 1 && $7 != "" {
    bone = $8
    if (bone == "" && $2 ~ /^(Rib_|Sternum|T[-_][0-9])/) bone = "BONERibcage"
    else if (bone == "" && $2 ~ /^Skull/) bone = "BONEMergedSkull"
    else if (bone == "" && $2 == "Mandible") bone = "BONEJaw"
    else if (bone == "" && $2 ~ /^ibula_/) bone = "BONEF" $2
    else if (bone == "" && $2 ~ /_[LR][12]$/) bone = "BONE" substr($2, 1, length($2) - 1)
    sub(/\.stl$/, "", $7)
    sub(/\.stl$/, "", bone)
    if (bone != "") print $7 "\t" bone
}' "$dog/attachments.tsv" | sort -u > "$work/true"
cut -f 1 "$work/true" | sort -u > "$work/muscles" # muscles with a site: 213 of 253

for muscle in "$dog"/meshes/MUSC*.stl; do
    "${BIN:?the folder of the tools}/attach-detect" -v --bones "$work/bones" "$@" -o "$work/muscle.json" "$muscle" 2>&1 |
        awk -v muscle="$(basename "$muscle" .stl)" '/ vertices by / { sub(/:$/, "", $2); print muscle "\t" $2 }'
done | sort -u | join -t "$(printf '\t')" "$work/muscles" - > "$work/found"

both=$(comm -12 "$work/true" "$work/found" | wc -l)
awk -v both="$both" -v true="$(wc -l < "$work/true")" -v found="$(wc -l < "$work/found")" 'BEGIN {
    precision = both / found; recall = both / true
    printf "true pairs %d, found %d, both %d: precision %.3f, recall %.3f, F1 %.3f\n", true, found, both, precision, recall,
           2 * precision * recall / (precision + recall)
}'
