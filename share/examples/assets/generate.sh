#!/bin/sh
# Make muscles/ and bones/ for the example: the sample arm at several resolutions, in several formats, with file names as they come.
# Usage: generate.sh FOLDER. ARM=PROGRAM is the generator, TOOLS=DIR the folder of sinew's tools; without TOOLS they are on the PATH.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
arm=${ARM:-$here/../../../../libexec/sinew/arm}
clean=${TOOLS:+$TOOLS/}mesh-clean
mkdir -p "$1/muscles" "$1/bones"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for size in coarse:1000 medium:4000 fine:16000; do
    "$arm" --out "$work/${size%:*}" --triangles "${size#*:}" --dirty
    for muscle in biceps brachialis triceps; do
        cp "$work/${size%:*}/$muscle.ply" "$1/muscles/$muscle ${size%:*}.ply"
    done
done
cp "$work/coarse/biceps-dirty.obj" "$1/muscles/biceps (dirty).obj"
"$clean" "$work/coarse/brachialis.ply" -o "$1/muscles/Armbeuger über #1.stl"
for bone in scapula humerus ulna radius; do cp "$work/medium/$bone.ply" "$1/bones"; done
