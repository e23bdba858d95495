#!/bin/sh
# assets.sh -- a whole body with sinew.mk: the dog's 253 muscles and 172 bones. Prints the seconds of the first build, of a second one
# with nothing to do, and of one after each kind of change, the seconds of processor time, and how many stages ran; then the lint.
#   BIN=build/release/bin DATA=../shared/data tests/bench/assets.sh [JOBS]
# Reach: the first build in 60 s with two jobs; a second one runs no stage; a change runs the stages of one muscle.
set -eu
export LC_ALL=C
unset MAKEFLAGS MFLAGS MAKELEVEL
here=$(cd "$(dirname "$0")/../.." && pwd)
bin=$(cd "${BIN:?the folder of the tools}" && pwd)
dog=$(cd "${DATA:?the folder of test data}/dog-dmcontrol" && pwd)
jobs=${1:-2}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
failed=0

awk -F '\t' -v from="$dog/meshes/" '$2 == "muscle" { print from $1 }' "$dog/manifest.tsv" > muscles.txt
first=$(head -n 1 muscles.txt)
cp "$first" one.stl
chmod u+w one.stl
sed -i '1s/.*/one.stl/' muscles.txt
printf 'muscle\ttool\toptions\n' > options.tsv
printf 'SINEW_SURFACES = muscles.txt\nSINEW_BONES = %s/meshes/BONE*.stl\nSINEW_TABLE = options.tsv\nSINEW_BIN = %s\ninclude %s/share/make/sinew.mk\n' \
    "$dog" "$bin" "$here" > Makefile

# processor seconds of all children that have ended, as the shell's times wrote them
spent() { awk 'NR == 2 { split($1, user, /[ms]/); split($2, kernel, /[ms]/); print 60 * (user[1] + kernel[1]) + user[2] + kernel[2] }' "$1"; }

# build WORDS STAGES [TARGET]: time it; it must run that many stages
build() {
    start=$(date +%s.%N)
    times > before
    make -j"$jobs" "${3:-assets}" > said 2>&1 || true
    seconds=$(awk -v a="$start" -v b="$(date +%s.%N)" 'BEGIN { printf "%.1f", b - a }')
    times > after
    processor=$(awk -v a="$(spent before)" -v b="$(spent after)" 'BEGIN { printf "%.1f", b - a }')
    ran=$(grep -cE ': (mesh-clean|root-select|build-structure|fiber-flow|attach-detect)$' said || true)
    verdict=
    [ "$ran" -eq "$2" ] || { verdict="  NOT $2"; failed=1; }
    printf '%-24s %6s s (processor %5s s) %5d stages%s   %s\n' "$1" "$seconds" "$processor" "$ran" "$verdict" "$(tail -n 1 said | cut -c 1-90)"
}

build "first build" 1265
awk -v t="$seconds" 'BEGIN { exit !(t > 60) }' && echo "  slower than 60 s"
build "nothing to do" 0
touch one.stl
build "one surface touched" 1
"$bin/mesh-clean" -q one.stl --triangles 150 -o new.stl
mv new.stl one.stl
build "one surface changed" 5
printf 'one\tbuild-structure\t--prune 0.2\n' >> options.tsv
build "one line of options" 3
printf 'broken' > one.stl
build "one surface broken" 1
"$bin/mesh-clean" -q "$first" -o one.stl
build "and mended" 5
build "lint of 425 surfaces" 0 lint
exit "$failed"
