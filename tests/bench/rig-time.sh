#!/bin/sh
# How long the five rig tools take on the leg muscle nearest to 26k triangles, beside the bones of the leg: the best of five.
# Usage: BIN=... DATA=... tests/bench/rig-time.sh (make rig-time).
set -eu
: "${BIN:?set BIN to the folder of the tools}" "${DATA:?set DATA to the folder of real anatomy}"
data=$(cd "$DATA" && pwd) out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
meshes=$data/leg-vhf/meshes
name=$(awk -F '\t' '$2 == "muscle" { d = $4 - 26000; if (d < 0) d = -d; if (best == "" || d < least) { least = d; best = $1 } } END { print best }' \
    "$data/leg-vhf/manifest.tsv")
awk -F '\t' -v dir="$meshes/" '$2 == "bone" { n = $1; sub(/\.[a-z]+$/, "", n); print n "\t" dir $1 }' "$data/leg-vhf/manifest.tsv" > "$out/bones"
chain() {
    "$BIN/mesh-clean" --units mm "$meshes/$name" -o "$out/m.json"
    "$BIN/attach-detect" --bones "$out/bones" "$out/m.json" -o "$out/m.json" 2> /dev/null
    "$BIN/root-select" "$out/m.json" -o "$out/m.json"
    "$BIN/build-structure" "$out/m.json" -o "$out/m.json"
    "$BIN/fiber-flow" "$out/m.json" -o "$out/m.json"
}
for i in 1 2 3 4 5; do
    start=$(date +%s.%N)
    chain
    awk -v a="$start" -v b="$(date +%s.%N)" 'BEGIN { print b - a }'
done | sort -n | awk -v name="$name" 'NR == 1 { printf "five rig tools on %s: best of five %.2f s\n", name, $1 }'
