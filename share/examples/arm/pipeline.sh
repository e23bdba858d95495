#!/bin/sh
# The chain of the Makefile through pipes: NAME.muscle.json of every muscle, the same bytes.
# Usage: pipeline.sh [FROM [TO]]: the folder with the meshes and the folder for the documents (default: the current one).
# TOOLS=DIR names the folder of sinew's tools; without it they are on the PATH.
set -eu
from=${1:-.} to=${2:-.}
PATH=${TOOLS:+$(cd "$TOOLS" && pwd):}$PATH
for muscle in biceps brachialis triceps; do
    mesh-clean "$from/$muscle.ply" |
        attach-detect --bone scapula="$from/scapula.ply" --bone humerus="$from/humerus.ply" \
            --bone ulna="$from/ulna.ply" --bone radius="$from/radius.ply" |
        root-select | build-structure | fiber-flow | fiber-fill -o "$to/$muscle.muscle.json"
done
