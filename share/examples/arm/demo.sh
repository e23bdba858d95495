#!/bin/sh
# Generate the sample arm, rig it, bend its elbow, curl it by a motion file and sensors, draw every stage and both motions, and say what was
# measured on the way.
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
# frames LOG: how many it tells of
frames() { awk -F '[:,]' '/"frame":/ && !seen[$2]++ { n++ } END { print n }' "$1"; }
row() { printf '  %-16s %8s s   %s\n' "$1" "$2" "$3"; }

stage clean
began=$(now)
start=$(now); stage meshes; arm_seconds=$(since "$start")
stage rigs
start=$(now); stage simulation; simulate_seconds=$(since "$start")
stage curl.scene.json
start=$(now); stage curl; curl_seconds=$(since "$start")
start=$(now); stage pictures; view_seconds=$(since "$start")

set -- ./*.stages.png ./arm*.png ./curl.png
echo "The sample arm, $triangles triangles in the biceps:"
row arm "$arm_seconds" "7 surfaces and the dirty biceps"
row mesh-clean "$(seconds clean)" "3 muscles"
row attach-detect "$(seconds attached)" "to 4 bones"
row root-select "$(seconds roots)" ""
row build-structure "$(seconds structure)" ""
row fiber-flow "$(seconds fibers)" ""
row fiber-fill "$(seconds muscle)" ""
row simulate "$simulate_seconds" "$(frames arm.jsonl) frames"
row motion-import "$(seconds motion)" "a curl, 3 s at 60 Hz"
row motion-sense "$(seconds activation)" "4 sensors, with their chart"
row scene-build "$(seconds scene)" ""
row simulate "$curl_seconds" "$(frames curl.jsonl) frames of the curl"
row rig-view "$view_seconds" "$# pictures"
row "in all" "$(since "$began")" ""
awk -f "$here/worst.awk" arm.jsonl
echo "The curl:"
awk -f "$here/worst.awk" curl.jsonl
echo "Documents, frames, log and pictures are in $PWD"
