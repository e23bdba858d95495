#!/bin/sh
# Every chart of error against run time: the moving tip at 1k, 4k and 17k triangles, moving, fast, at rest and with a bone in its way, the
# tibialis anterior, and twelve muscles each of a dog's hind and fore leg, tied to each other.
# Usage: charts.sh BIN TIP DATA OUT [CASE...]: the tools, the generator, the real anatomy ("" = leave it out), and a folder for the results;
# without CASE all of them: tip-1000 tip-4000 tip-17000 contact-1000 contact-4000 static-1000 static-4000 static-17000 fast-1000 fast-4000 tibialis tibialis-static
# hind-leg fore-leg.
# The bigger the muscle, the fewer settings, and the coarser the reference.
# OUT/CASE gets what error-time writes, OUT/CASE.png the chart. A setting is measured RUNS (3) times. Run it on a machine that does
# nothing else.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "$1" && pwd) tip=$(cd "$(dirname "$2")" && pwd)/$(basename "$2") data=$3 out=$4
shift 4
mkdir -p "$out"
out=$(cd "$out" && pwd)
[ -z "$data" ] || data=$(cd "$data" && pwd)
PATH=$bin:$PATH
runs=${RUNS:-3}
[ $# -gt 0 ] || set -- tip-1000 contact-1000 contact-4000 static-1000 fast-1000 tip-4000 static-4000 fast-4000 tip-17000 static-17000 tibialis tibialis-static hind-leg fore-leg

measure() { # NAME SCENE TITLE OPTION...
    name=$1 scene=$2 title=$3
    shift 3
    echo "== $name"
    error-time -v "$scene" --title "$title" --runs "$runs" -o "$out/$name" "$@"
    cp "$out/$name/error-time.png" "$out/$name.png"
}

# The moving tip of a case: edges, angles and volume alone, so that both solvers have the same energy.
moving_tip() { # CASE OPTION...
    folder=$out/$1.scene size=${1##*-}
    shift
    "$tip" --triangles "$size" "$@" "$folder"
}

# The muscle of tests/stability, its ankle turning by 30 degrees in a second. With least areas: without
# them its triangles fold, and there are many equilibria. So both solvers differ by the barrier of qn, and xpbd by no less than that.
tibialis() {
    leg=$data/leg-vhf/meshes/VHF_Left
    mkdir -p "$out/rig"
    mesh-clean -q --units mm "${leg}_Muscle_TibialisAnterior_smooth.ply" |
        attach-detect -q --bone tibia="${leg}_Bone_Tibia_smooth.ply" --pin talus=half:0,0,221.415,0,0,-1 |
        root-select -q | build-structure -q | fiber-flow -q -o "$out/rig/tibialis.muscle.json"
    cat > "$out/rig/tibialis.scene.json" <<END
{"format": "sinew-scene", "version": 1, "name": "tibialis anterior", "metersPerUnit": 0.001, "rate": 24, "frames": [0, 24],
 "motion": {"joints": [{"name": "ankle", "type": "hinge", "axis": [1, 0, 0], "point": [510.8, 425.2, 143.2],
   "keys": [[0, 0], [1, -30]], "interpolation": "smooth"}]},
 "bones": [{"name": "tibia", "mesh": "tibia.ply"}, {"name": "talus", "mesh": "talus.ply", "joint": "ankle"}],
 "muscles": [{"name": "tibialis", "rig": "tibialis.muscle.json"}]}
END
}

# Rigs, candidates and a scene of a leg of the dog; its first 40 frames, in which it moves.
tied_leg() { # CASE MOTION
    "$here/../dog/$1.sh" "$bin" "$data/dog-dmcontrol" "$out/$1.scene" 2> "$out/$1.said"
    "$here/../dog/tie.sh" "$bin" "$out/$1.scene" "$2" 2>> "$out/$1.said"
    printf 'qn iterations=%d\n' 3 5 10 20 40 > "$out/$1.settings"
    printf 'qn substeps=2 iterations=%d\n' 5 10 20 >> "$out/$1.settings"
    printf 'qn substeps=4 iterations=%d\n' 5 10 >> "$out/$1.settings"
    printf 'qn iterations=%d preconditioner=two-level\n' 3 5 10 20 >> "$out/$1.settings"
    printf 'xpbd substeps=%d iterations=%d\n' 1 16 4 4 16 1 16 4 64 1 256 1 >> "$out/$1.settings"
    measure "$1" "$out/$1.scene/tied.scene.json" "twelve muscles of a dog's ${1%-leg} leg, tied to each other" \
        --settings "$out/$1.settings" --frames 0:40 --reference 8 --most-seconds 30
}

for case in "$@"; do
    scene=$out/$case.scene/tip.scene.json size=${case##*-}
    case $case in
    tip-1000)
        moving_tip "$case" --least-area 0
        measure "$case" "$scene" "moving tip, $size triangles" --sweep full --reference 256
        ;;
    tip-4000)
        moving_tip "$case" --least-area 0
        measure "$case" "$scene" "moving tip, $size triangles" --sweep full --reference 128 --most-seconds 30
        ;;
    tip-*)
        moving_tip "$case" --least-area 0
        measure "$case" "$scene" "moving tip, $size triangles" --reference 32
        ;;
    contact-1000)
        moving_tip "$case" --bone --least-area 0
        measure "$case" "$scene" "moving tip with a bone in its way, $size triangles" --sweep full --reference 256 --most-seconds 30
        ;;
    contact-*)
        moving_tip "$case" --bone --least-area 0
        measure "$case" "$scene" "moving tip with a bone in its way, $size triangles" --reference 64 --most-seconds 30
        ;;
    static-*)
        moving_tip "$case" --static --least-area 0
        measure "$case" "$scene" "moving tip at rest, $size triangles" --static --most-seconds 30
        ;;
    fast-*)
        moving_tip "$case" --fast
        measure "$case" "$scene" "tip at 19° a frame, $size triangles" --reference 64 --most-seconds 30
        ;;
    tibialis)
        [ -n "$data" ] || continue
        tibialis
        measure "$case" "$out/rig/tibialis.scene.json" "tibialis anterior, 12,420 triangles" --reference 16 --floor 3e-5
        ;;
    tibialis-static)
        [ -n "$data" ] || continue
        tibialis
        measure "$case" "$out/rig/tibialis.scene.json" "tibialis anterior at rest, 12,420 triangles" --static --most-seconds 30
        ;;
    hind-leg)
        [ -n "$data" ] || continue
        tied_leg "$case" hip
        ;;
    fore-leg)
        [ -n "$data" ] || continue
        tied_leg "$case" shoulder
        ;;
    *)
        echo "there is no case $case" >&2
        exit 2
        ;;
    esac
done
