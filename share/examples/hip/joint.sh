#!/bin/sh
# The muscles of a joint among its bones, for the experiments of Kohout and Cervenka (2021): surfaces of one resolution, attachment areas
# (landmarks as they are, or grown around single sites), rigs with fibres, and a scene with contact.
#
#   joint.sh [OPTION ...] OUT MUSCLES.tsv LANDMARKS.tsv BONES MOTION.motion.json
#
# MUSCLES.tsv: name, surface. LANDMARKS.tsv: muscle, bone, area, x, y, z: several lines of one area go around it, a single one is a site, and
# an area is grown around it. Areas called origin or insertion, with or without a number behind that, are at that end; fibres run from
# origins to insertions. BONES is a folder or list, as for attach-detect --bones; they are on the joints of MOTION that -j says.
#   -e EDGE       what surfaces are remeshed to (2mm); 0: they are left as they are
#   -t TRIANGLES  what each of them is decimated to after that
#   -r RADIUS     of the areas that are grown: a length in UNIT, or a share of the muscle's length, or both (8%,0.01: the lesser)
#   -f FIBERS     in each muscle, of 15 pieces (100)
#   -u UNIT       of surfaces, landmarks and bones: m (default), cm or mm
#   -j BONE=JOINT as scene-build --bind; again and again. Without it a bone is on the joint of its name, or stands
#   -s SETTING    as scene-build --set, such as psoas*.restLength=0.8; again and again
#   -n NAME       of the scene, OUT/NAME.scene.json (joint)
# The tools are on the PATH; EXAMPLES is the folder of the built examples where they are not installed.
set -eu
LC_ALL=C
export LC_ALL
here=$(cd "$(dirname "$0")" && pwd)
edge=2mm triangles='' radius=8%,0.01 fibers=100 unit=m name=joint scene=''
usage() {
    sed -n '2,20s/^#\( \|$\)//p' "$0"
    exit "$1"
}
while getopts e:t:r:f:u:n:j:s:h option; do
    case $option in
    e) edge=$OPTARG ;;
    t) triangles=$OPTARG ;;
    r) radius=$OPTARG ;;
    f) fibers=$OPTARG ;;
    u) unit=$OPTARG ;;
    n) name=$OPTARG ;;
    j) scene="$scene --bind $OPTARG" ;;
    s) scene="$scene --set $OPTARG" ;;
    h) usage 0 ;;
    *) usage 2 ;;
    esac
done
shift $((OPTIND - 1))
[ $# -eq 5 ] || usage 2
out=$1 muscles=$2 landmarks=$3 bones=$4 motion=$5
if [ -n "${EXAMPLES:-}" ] && [ -x "$EXAMPLES/hip/areas" ]; then areas=$EXAMPLES/hip/areas; else areas=$here/../../../../libexec/sinew/areas; fi
rm -rf "$out/surfaces" "$out/areas" "$out/rigs"
mkdir -p "$out/surfaces" "$out/areas" "$out/rigs"
trap 'rm -f "$out/sites" "$out/said"' EXIT

# areas_of MUSCLE: OUT/areas/MUSCLE.tsv, landmarks for attach-detect
areas_of() {
    awk -F '\t' -v muscle="$1" -v sites="$out/sites" '
        $1 == muscle { key = $2 FS $3; if (!(key in lines)) order[++count] = key; lines[key] = lines[key] key FS $4 FS $5 FS $6 "\n"; n[key]++ }
        END {
            printf "" > sites
            for (i = 1; i <= count; i++) printf "%s", lines[order[i]] > (n[order[i]] > 1 ? "/dev/stdout" : sites)
            if (!count) { print "joint.sh: " muscle " has no landmarks" > "/dev/stderr"; exit 1 }
        }' "$landmarks" > "$out/areas/$1.tsv"
    [ -s "$out/sites" ] || return 0
    if ! "$areas" "$out/surfaces/$1.ply" "$out/sites" "$radius" >> "$out/areas/$1.tsv" 2> "$out/said"; then
        sed "s/^areas:/joint.sh: $1:/" "$out/said" >&2
        exit 1
    fi
    sed "s/^areas:/joint.sh: $1:/" "$out/said"
}

count=0
while IFS='	' read -r muscle surface; do
    case $muscle in '' | \#*) continue ;; esac
    remesh=''
    [ "$edge" = 0 ] || remesh="--edge-length $edge"
    # shellcheck disable=SC2086
    mesh-clean -q --units "$unit" $remesh ${triangles:+--triangles "$triangles"} "$surface" -o "$out/surfaces/$muscle.ply"
    areas_of "$muscle"
    [ "$(cut -f 1 "$out/areas/$muscle.tsv" | sort -u | wc -l)" -gt 1 ] || {
        echo "joint.sh: $muscle has areas on one bone alone: it would only move along with it" >&2
        exit 1
    }
    attach-detect --units "$unit" --method area --landmarks "$out/areas/$muscle.tsv" --bones "$bones" "$out/surfaces/$muscle.ply" \
        -o "$out/attached.muscle.json"
    root-select -q "$out/attached.muscle.json" | build-structure -q | fiber-flow -q |
        fiber-fill -q --fibers "$fibers" --segments 15 -o "$out/rigs/$muscle.muscle.json" || [ $? -eq 3 ]
    count=$((count + 1))
done < "$muscles"
rm -f "$out/attached.muscle.json"
[ "$count" -gt 0 ] || { echo "joint.sh: $muscles names no muscle" >&2; exit 1; }
set -f # patterns are scene-build's
# shellcheck disable=SC2086
scene-build -q "$out/rigs" --motion "$motion" --bones "$bones" --units "$unit" $scene --contact -o "$out/$name.scene.json"
echo "joint.sh: $count muscles in $out/$name.scene.json"
