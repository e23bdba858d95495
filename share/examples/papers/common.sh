# common.sh -- what the recipes share: options, the muscle, its rig, the scene, the charts. Sourced by a recipe, not run.
# shellcheck shell=sh disable=SC2034
#
#   RECIPE [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
#
# Without SURFACE it is the biceps of the generated arm, between scapula and radius, and the forearm swings about the shoulder by a degree a
# frame, which moves its end by 5 mm (in [K21] the hip bends by 2 degrees a step: 4 to 7 mm); in r18-* the elbow bends by 10 degrees a frame.
# SURFACE is any closed surface, ATTACH-OPTIONs are those of attach-detect that say where it is attached (--bone NAME=FILE, --pin NAME=PLACE, ...), UNIT is
# m, cm or mm, and JOINT says which bone turns: "BONE x,y,z ax,ay,az DEGREES", a point on its axis, its direction, and degrees a frame.
# BONES are what else is in the way: "NAME=FILE NAME=FILE+", a plus for those that go with the joint. With -c bones are obstacles.
# MUSCLE is one of the dog's hip, gluteus_medius say, which flexes by 2 degrees a frame (implies -c): from the folder HIP, made by
# share/examples/hip/dog.sh, or made in OUT/hip from the dog in the folder DATA.
# The tools are on the PATH; EXAMPLES is the folder of the built examples where they are not installed.
set -eu
LC_ALL=C
export LC_ALL
here=$(cd "$(dirname "$0")" && pwd)
recipe=$(basename "$0" .sh)
out=$recipe triangles='' frames='' iterations='' unit='' joint='' more='' muscle='' contact=''
while getopts o:t:f:i:u:j:b:m:ch option; do
    case $option in
    o) out=$OPTARG ;;
    t) triangles=$OPTARG ;;
    f) frames=$OPTARG ;;
    i) iterations=$OPTARG ;;
    u) unit=$OPTARG ;;
    j) joint=$OPTARG ;;
    b) more=$OPTARG ;;
    m) muscle=$OPTARG ;;
    c) contact=yes ;;
    *)
        sed -n '4,14s/^#\( \|$\)//p' "$here/common.sh"
        [ "$option" = h ] && exit 0
        exit 2
        ;;
    esac
done
shift $((OPTIND - 1))
mkdir -p "$out"
rm -f "$out/claims.tsv"
# a chart that could not be drawn is work that falls short
missing=''
trap 'status=$?; [ "$status" -ne 0 ] || [ -z "$missing" ] || exit 3' EXIT

say() { echo "$recipe: $*"; }

# run_on SCENE OPTION...: simulate, and go on where a muscle has exploded (status 3): its figures are what the recipe is about
run_on() { simulate "$@" || [ $? -eq 3 ]; }

# claim EXPERIMENT PUBLISHED KOHOUT DEFAULT: a line of the table of all recipes
claim() { printf '%s\t%s\t%s\t%s\n' "$@" >> "$out/claims.tsv"; }

# program NAME FOLDER: a built example, or an installed one
program() {
    if [ -n "${EXAMPLES:-}" ] && [ -x "$EXAMPLES/$2/$1" ]; then echo "$EXAMPLES/$2/$1"; else echo "$here/../../../../libexec/sinew/$1"; fi
}

# ---- the muscle: $surface, and the options of attach-detect in "$@" ------------------------------------------------------------

case ${unit:-m} in
m) meters=1 ;;
cm) meters=0.01 ;;
mm) meters=0.001 ;;
*) say "-u $unit: write m, cm or mm" >&2; exit 2 ;;
esac

# The biceps of the arm with about N triangles: $surface.
generate() {
    "$(program arm arm)" --out "$out/arm" --triangles "$1" > "$out/arm.log"
    surface=$out/arm/biceps.ply
}

# of_hip MUSCLE: $surface, $joint, $more and $attach of a muscle of the dog's hip
of_hip() {
    hip=${HIP:-$out/hip}
    if [ ! -e "$hip/hip.scene.json" ]; then
        [ -e "${DATA:-}/dog-dmcontrol/dog.xml" ] || { say "-m $1: there is no dog at ${DATA:-\$DATA}/dog-dmcontrol; DATA names the folder that holds it" >&2; exit 1; }
        "$here/../hip/dog.sh" "$DATA/dog-dmcontrol" "$hip" > "$out/hip.log"
    fi
    [ -e "$hip/areas/$1.tsv" ] || { say "-m $1: the hip has $(cd "$hip/areas" && echo *.tsv | sed 's/\.tsv//g')" >&2; exit 2; }
    surface=$(awk -F '\t' -v m="$1" '$1 == m { print $2 }' "$hip/muscles.tsv")
    joint=$(cat "$hip/joint.txt")
    attach="--method area --landmarks $hip/areas/$1.tsv"
    for bone in $(cut -f 1 "$hip/areas/$1.tsv" | sort -u); do attach="$attach --bone $bone=$hip/near/$bone.ply"; done
    for bone in "$hip"/near/*.ply; do
        name=$(basename "$bone" .ply)
        more="$more $name=$bone$([ "$name" != "${joint%% *}" ] || echo +)"
    done
    unit=m contact=yes
}

given=$#
if [ -n "${recipe_bones:-}" ]; then given=0; fi # its arguments are bones
surface=${1:-}
[ -z "$muscle" ] || [ "$given" -eq 0 ] || { say "either -m MUSCLE or a surface of your own" >&2; exit 2; }
if [ -n "$muscle" ]; then
    of_hip "$muscle"
    # shellcheck disable=SC2086
    set -- $attach
    given=1
elif [ "$given" -gt 0 ]; then
    shift
    [ -n "$joint" ] || { say "a muscle of your own needs -j \"BONE x,y,z ax,ay,az DEGREES\"" >&2; exit 2; }
elif [ -z "${recipe_bones:-}" ]; then
    set -- --bone "scapula=$out/arm/scapula.ply" --bone "radius=$out/arm/radius.ply"
    joint=${joint:-${swing:-radius 0,0,0.3 0,-1,0 1}}
fi
# what lets bones be obstacles, beside scheme or solver
fields="--contact --grid-cache ${FIELDS:-$out/fields}"
[ -z "$muscle" ] || fields="$fields --grid-cell 1mm" # one for all recipes, and small enough
obstacles=''
[ -z "$contact" ] || obstacles=$fields
voxels='--voxels total:2097152' # the paper's n_max

# frames_to DEGREES: the frame at which the joint has turned by so many; bones "$@": the options among them that name bones
frames_to() { awk -v d="${joint##* }" -v to="$1" 'BEGIN { n = to / (d < 0 ? -d : d); print int(n + 0.5) }'; }
bones_of() {
    while [ $# -gt 0 ]; do
        case $1 in --bone | -b) echo "--bone $2"; shift ;; esac
        shift
    done
}

# The scene's bones, as they are called in the attach options; a pin has no mesh of its own: the muscle's stands for it, and is in no way.
bones_json() {
    moving=${joint%% *} list='' first=$(cd "$(dirname "$surface")" && pwd)/$(basename "$surface")
    for word; do
        case $word in *=*) ;; *) continue ;; esac
        name=${word%%=*} file=${word#*=}
        with=''
        if [ -e "$file" ]; then file=$(cd "$(dirname "$file")" && pwd)/$(basename "$file"); else file=$first with=',"contact":false'; fi
        case "$list $more" in *"\"$name\""* | *" $name="*) continue ;; esac
        [ "$name" != "$moving" ] || with="$with,\"joint\":\"joint\""
        list="$list${list:+,}{\"name\":\"$name\",\"mesh\":\"$file\"$with}"
    done
    for word in $more; do
        name=${word%%=*} file=${word#*=} with=''
        case $file in *+) file=${file%+} with=',"joint":"joint"' ;; esac
        list="$list${list:+,}{\"name\":\"$name\",\"mesh\":\"$(cd "$(dirname "$file")" && pwd)/$(basename "$file")\"$with}"
    done
    echo "$list"
}

# fine TRIANGLES: how to remesh a surface that has fewer, so that there are more; nothing where it has enough
fine() {
    # shellcheck disable=SC2086
    mesh-clean -q --no-history ${unit:+--units $unit} --report "$out/fine.json" "$surface" -o "$out/fine.muscle.json"
    awk -F '[:,]' -v n="$1" '/"triangles"/ { has = $2 } /"area"/ { area = $2 }
        END { if (has + 0 < n) printf "--edge-length %.9g", sqrt(area / (0.433 * n)) }' "$out/fine.json"
    rm -f "$out/fine.json" "$out/fine.muscle.json"
}

# rig NAME TRIANGLES ATTACH-OPTION...: OUT/NAME.muscle.json of $surface, decimated where TRIANGLES is not 0
rig() {
    name=$1 most=$2
    shift 2
    decimate='' source=$surface
    [ "$most" -ne 0 ] || [ -z "$muscle" ] || source=$hip/surfaces/$muscle.ply
    [ "$most" -eq 0 ] || decimate="$(fine "$most") --triangles $most"
    # shellcheck disable=SC2086
    mesh-clean -q $decimate ${unit:+--units $unit} --report "$out/$name.clean.json" "$source" |
        attach-detect -q "$@" | root-select -q | build-structure -q |
        fiber-flow -q --field tree -o "$out/$name.muscle.json" # the papers' directions follow the structure
}

# millimetres NAME: the mean edge of a rig; count NAME: its triangles
millimetres() { awk -F '[:,]' '/"edgeMean"/ { x = $2 } END { print x * 1000 * '"$meters"' }' "$out/$1.clean.json"; }
count() { awk -F '[:,]' '/"triangles"/ { x = $2 } END { print x + 0 }' "$out/$1.clean.json"; }

# scene NAME LAST-FRAME MUSCLE-MEMBERS ATTACH-OPTION...: OUT/NAME.scene.json; the joint turns to frame $turned, or to the last
scene() {
    name=$1 last=$2 members=$3
    shift 3
    # shellcheck disable=SC2086
    set -- "$(bones_json "$@")" $joint
    cat > "$out/$name.scene.json" << END
{ "format": "sinew-scene", "version": 1, "name": "$name", "metersPerUnit": $meters, "rate": 24, "frames": [0, $last],
  "motion": { "joints": [ { "name": "joint", "type": "hinge", "point": [$3], "axis": [$4], "keys": [[0, 0], { "frame": ${turned:-$last}, "degrees": $(awk "BEGIN { print $5 * ${turned:-$last} }") }] } ] },
  "bones": [ $1 ],
  "muscles": [ { "name": "$name", "rig": "$name.muscle.json"$members } ] }
END
}

# ---- the figures ----------------------------------------------------------------------------------------------------------------

# member NAME: its value in every line of JSON
member() { sed -n 's/.*"'"$1"'":\([^,}]*\).*/\1/p'; }

# wild LOG: did the run end with edges that are off by more than 10 mean edges, or not finite? Plain position based dynamics can.
wild() {
    rms=$(tail -n 1 "$1" | sed -n 's/.*"mesh":{"rms":\([^,}]*\).*/\1/p')
    awk -v x="$rms" 'BEGIN { exit x ~ /^[0-9]/ && x + 0 < 10 }'
}

# focus_on: options of rig-view that aim at the muscle of a scene; the hip from where its bones hide least
focus_on() {
    [ -z "$contact$muscle" ] && return 0
    for scene in contact mean-edge 0.5mm 1mm areas collision areas-ignore default muscle; do
        [ ! -e "$out/$scene.scene.json" ] || echo "--focus $scene"
    done
    echo "--zoom 0.75"
    case $muscle in gluteus*) echo "--camera 150:10" ;; iliacus | psoas*) echo "--camera 150:-20" ;; ?*) echo "--camera 60:0" ;; esac
}

# chart NAME: OUT/NAME.tsv by NAME.gp as OUT/NAME.svg and OUT/NAME.png
chart() {
    if ! command -v gnuplot > /dev/null; then
        say "there is no gnuplot: $out/$1.tsv has the figures, and there is no chart" >&2
        missing=chart
        return 0
    fi
    for kind in svg png; do
        gnuplot -e "data = '$out/$1.tsv'; picture = '$out/$1.$kind'; kind = '$kind'" "$here/style.gp" "$here/$1.gp" 2> "$out/gnuplot.log" || {
            say "gnuplot: $(grep -v '^ *$' "$out/gnuplot.log" | tail -n 1)" >&2
            exit 1
        }
    done
    rm -f "$out/gnuplot.log"
    # every curve of the figures that has a finite number draws a path
    [ "$(grep -c '<path' "$out/$1.svg")" -ge 4 ] || { say "$out/$1.svg is empty" >&2; exit 1; }
    say "$out/$1.tsv, $out/$1.svg, $out/$1.png"
}
