#!/bin/sh
# Generate the sample arm, rig it, bend its elbow, draw every stage and the motion, and say what was measured on the way.
# Usage: demo.sh BIN EXAMPLES OUT: the folder of the tools, that of the built examples, and the folder to leave everything in.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "$1" && pwd)
arm=$(cd "$2" && pwd)/arm/arm
mkdir -p "$3"
cd "$3"
triangles=${TRIANGLES:-4000}

stage() { make -s --no-print-directory -f "$here/Makefile" TOOLS="$bin" ARM="$arm" TRIANGLES="$triangles" "$@"; }
now() { date +%s%N; }
since() { awk "BEGIN { printf \"%.2f\", ($(now) - $1) / 1e9 }"; }

# seconds STAGE: what the tool of that stage took for all muscles, from its reports
seconds() { cat ./*."$1".report.json | awk -F '[:,]' '/"seconds"/ { s += $2 } END { printf "%.2f", s }'; }
row() { printf '  %-16s %8s s   %s\n' "$1" "$2" "$3"; }

stage clean
began=$(now)
start=$(now); stage meshes; arm_seconds=$(since "$start")
stage rigs
start=$(now); stage simulation; simulate_seconds=$(since "$start")
start=$(now); stage pictures; view_seconds=$(since "$start")

set -- ./*.png
echo "The sample arm, $triangles triangles in the biceps:"
row arm "$arm_seconds" "7 surfaces and the dirty biceps"
row mesh-clean "$(seconds clean)" "3 muscles"
row root-select "$(seconds roots)" ""
row build-structure "$(seconds structure)" ""
row fiber-flow "$(seconds fibers)" ""
row attach-detect "$(seconds muscle)" "to 4 bones"
row simulate "$simulate_seconds" "$(awk -F '[:,]' '/"frame":/ && !seen[$2]++ { n++ } END { print n }' arm.jsonl) frames"
row rig-view "$view_seconds" "$# pictures"
row "in all" "$(since "$began")" ""
awk -f "$here/worst.awk" arm.jsonl
echo "Documents, frames, log and pictures are in $PWD"
