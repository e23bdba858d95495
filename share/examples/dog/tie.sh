#!/bin/sh
# The muscles of a leg (hind-leg.sh, fore-leg.sh) tied to each other: what faces each other within REACH, two targets a vertex, in OUT/tied, and
# OUT/tied.scene.json, at 60 frames a second, in which they act. Usage: tie.sh TOOLS OUT MOTION [REACH]: MOTION hip or shoulder; 6mm.
set -eu
tools=$(cd "$1" && pwd) reach=${4:-6mm}
PATH=$tools:$PATH
cd "$2"
mkdir -p tied
for rig in rigs/*.muscle.json; do
    attach-detect -q "$rig" --muscles rigs --reach "$reach" -o "tied/${rig#rigs/}"
done
scene-build -q tied --motion "$3.motion.json" --rate 60 --frames 0:90 --externals -o tied.scene.json
