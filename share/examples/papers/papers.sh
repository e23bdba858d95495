#!/bin/sh
# All experiments of Kohout and Cervenka (2021) and of Romeo and others (2018): the dog's hip, an ankle, the generated arm. Leaves in OUT a folder for
# each with PNG, SVG and TSV; index.html with every figure, what it is of the paper, and the table paper / kohout / default; table.tsv.
#
#   papers.sh [-k] DATA OUT
#
# DATA holds dog-dmcontrol and leg-vhf. What is there already is made anew, or with -k kept where it came to its end. The tools are on the PATH;
# EXAMPLES is the folder of the built examples where they are not installed. ONLY=PATTERN runs the experiments whose folder's name matches alone.
# Exit status: 0 all done; 1 one failed, or data or gnuplot are missing; 2 wrong usage; 3 done, but one says that it falls short.
set -eu
LC_ALL=C
export LC_ALL
here=$(cd "$(dirname "$0")" && pwd)
keep=''
while getopts kh option; do
    case $option in
    k) keep=yes ;;
    h) sed -n '2,9s/^#\( \|$\)//p' "$0"; exit 0 ;;
    *) sed -n '2,9s/^#\( \|$\)//p' "$0" >&2; exit 2 ;;
    esac
done
shift $((OPTIND - 1))
[ $# -eq 2 ] || { sed -n '2,9s/^#\( \|$\)//p' "$0" >&2; exit 2; }
command -v gnuplot > /dev/null || { echo "papers: there is no gnuplot, which draws the charts (Debian: gnuplot-nox)" >&2; exit 1; }
for needed in dog-dmcontrol/dog.xml leg-vhf/meshes; do
    [ -e "$1/$needed" ] || { echo "papers: there is no $needed in $1" >&2; exit 1; }
done
DATA=$(cd "$1" && pwd)
mkdir -p "$2"
out=$(cd "$2" && pwd)
HIP=$out/hip FIELDS=$out/fields
export DATA HIP FIELDS
[ -n "$keep" ] || rm -rf "$out/done"
mkdir -p "$out/done"
worst=0
begun=$(date +%s)

# make FOLDER FIGURE TEXT COMMAND...: run it in OUT/FOLDER; what it says goes to its log and to the screen
make() {
    folder=$1 figure=$2 text=$3
    shift 3
    printf '%s\t%s\t%s\n' "$folder" "$figure" "$text" >> "$out/experiments"
    # shellcheck disable=SC2254
    case $folder in ${ONLY:-*}) ;; *) return 0 ;; esac
    [ ! -e "$out/done/$folder" ] || return 0
    rm -rf "${out:?}/$folder"
    mkdir -p "$out/$folder"
    start=$(date +%s) status=0
    "$@" > "$out/$folder/said.txt" 2>&1 || status=$?
    seconds=$(($(date +%s) - start))
    echo "papers: $folder ($figure): ${seconds} s$([ "$status" -eq 0 ] || echo ", status $status: $(tail -n 1 "$out/$folder/said.txt")")"
    echo "$status $seconds" > "$out/$folder/status"
    case $status in
    0) : > "$out/done/$folder" ;;
    3) [ "$worst" -ne 0 ] || worst=3 ;;
    *) worst=1 ;;
    esac
}
recipe() { # FOLDER FIGURE TEXT RECIPE OPTION...
    folder=$1 figure=$2 text=$3 script=$4
    shift 4
    make "$folder" "$figure" "$text" "$here/$script.sh" -o "$out/$folder" "$@"
}
# the hip, and its sweep; the ankle's
hip_sweep() { "$here/../hip/sweep.sh" -o "$out/hip-sweep" -g "$FIELDS" -s -1 "$HIP/hip.scene.json" hip_L_extend.rad; }
ankle_sweep() {
    "$here/../leg/ankle.sh" "$(dirname "$(command -v simulate)")" "$DATA/leg-vhf/meshes" "$out/ankle" &&
        "$here/../hip/sweep.sh" -o "$out/ankle-sweep" -g "$FIELDS" "$out/ankle/ankle.scene.json" ankle.angle
}

: > "$out/experiments"
if [ ! -e "$HIP/joint.txt" ] || [ -z "$keep" ]; then
    rm -rf "$HIP"
    "$here/../hip/dog.sh" "$DATA/dog-dmcontrol" "$HIP" > "$out/hip.txt" || { echo "papers: the hip could not be made" >&2; exit 1; }
fi
major=gluteus_superficialis_major
recipe k21-stages 'fig. 2' 'a muscle through the stages: input, bones moved, surface adapted, fibres' k21-stages -m $major
recipe k21-voxels 'fig. 3' 'pelvis and femur as voxels' k21-voxels
recipe k21-attachments-iliacus 'figs 4, 5' 'fixed vertices of iliacus by voxels, proximity and areas, and what becomes of them' k21-attachments -m iliacus
recipe k21-attachments-gluteus 'fig. 5' 'the same of gluteus superficialis' k21-attachments -m $major
recipe k21-attachments-adductor 'fig. 8, rows' 'the same of adductor magnus' k21-attachments -m adductor_magnus
recipe k21-fibers-gluteus-superficialis 'fig. 6' '100 fibres in gluteus superficialis' k21-fibers -m $major -t 19752
recipe k21-fibers-gluteus-medius 'fig. 6' '100 fibres in gluteus medius' k21-fibers -m gluteus_medius -t 10622
recipe k21-fibers-iliacus 'fig. 6' '100 fibres in iliacus' k21-fibers -m iliacus -t 13858
recipe k21-fibers-adductor 'fig. 6' '100 fibres in adductor magnus' k21-fibers -m adductor_magnus -t 17124
recipe k21-displacement 'fig. 7' 'mean displacement in each iteration' k21-displacement -m adductor_magnus -t 17124
recipe k21-time 'table 1' 'time of a step by iterations, at three resolutions' k21-time -m adductor_magnus
recipe k21-anisotropy 'fig. 8' 'anisotropy off and on, 1 to 100 iterations, at 40 degrees' k21-anisotropy -m adductor_magnus
recipe k21-resolutions 'fig. 9' '17124, 3000 and 1000 triangles at 40 degrees' k21-resolutions -m adductor_magnus
recipe k21-variants 'fig. 10' 'iliacus at 40 degrees: points by collision, by areas, bones that hit ignored; the default' k21-variants -m iliacus
recipe k21-volume-iliacus 'fig. 11' 'volume of iliacus over the flexion' k21-volume -m iliacus
recipe k21-volume-gluteus-superficialis 'fig. 11' 'volume of gluteus superficialis' k21-volume -m $major
recipe k21-volume-gluteus-medius 'fig. 11' 'volume of gluteus medius' k21-volume -m gluteus_medius
recipe k21-volume-adductor 'fig. 11' 'volume of adductor magnus' k21-volume -m adductor_magnus
recipe k21-lengths-gluteus-superficialis 'figs 12, 15' 'fibre lengths of gluteus superficialis, and of the blend' k21-lengths -m $major
recipe k21-lengths-gluteus-medius 'figs 13, 15' 'fibre lengths of gluteus medius, and of the blend' k21-lengths -m gluteus_medius
recipe k21-lengths-iliacus 'figs 14, 15' 'fibre lengths of iliacus, and of the blend' k21-lengths -m iliacus
recipe k21-lengths-adductor '-' 'fibre lengths of adductor magnus, and of the blend' k21-lengths -m adductor_magnus
recipe k21-rates-gluteus-superficialis 'table 2' 'steps a second of gluteus superficialis' k21-rates -m $major -t 19752 -f 6
recipe k21-rates-adductor 'table 2' 'steps a second of adductor magnus' k21-rates -m adductor_magnus -t 17124 -f 6
recipe k21-rates-iliacus 'table 2' 'steps a second of iliacus' k21-rates -m iliacus -t 13858 -f 6
recipe k21-rates-gluteus-medius 'table 2' 'steps a second of gluteus medius' k21-rates -m gluteus_medius -t 10622 -f 6
recipe k21-collision 'section 3.2' 'voxels of several sizes and distance fields, at an ankle' k21-collision
make hip-sweep 'beyond' 'seven muscles of the hip there and back: moment arms of every fibre' hip_sweep
make ankle-sweep 'beyond' 'soleus, tibialis anterior and peroneus longus about the ankle' ankle_sweep
recipe r18-volume-gain 'R18, figs 7, 17' 'volume gains of an active biceps' r18-volume-gain

# ---- table and index ------------------------------------------------------------------------------------------------------------

{
    printf 'experiment\tpaper\tkohout\tdefault\tfolder\n'
    cut -f 1 "$out/experiments" | while read -r folder; do
        [ ! -e "$out/$folder/claims.tsv" ] || sed "s|\$|	$folder|" "$out/$folder/claims.tsv"
    done
} > "$out/table.tsv"
text() { sed 's/&/\&amp;/g; s/</\&lt;/g; s/>/\&gt;/g'; }
{
    cat << END
<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>The papers' experiments</title>
<style>body{font:15px/1.4 sans-serif;max-width:1200px;margin:2em auto;padding:0 1em}img{max-height:300px;max-width:100%}table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.3em .6em;text-align:left;vertical-align:top}</style>
<h1>The papers' experiments, again</h1>
<p>Muscles of a dog's hip, an ankle and a generated arm, by the schemes of the papers and by sinew's default. Times are of this machine, whatever else it did.</p>
<h2>Table</h2><table><tr><th>experiment<th>paper<th>scheme kohout<th>sinew's default</tr>
END
    tail -n +2 "$out/table.tsv" | text | awk -F '\t' '{ printf "<tr><td><a href=\"#%s\">%s</a><td>%s<td>%s<td>%s</tr>\n", $5, $1, $2, $3, $4 }'
    echo '</table><h2>Figures</h2>'
    while IFS='	' read -r folder figure what; do
        printf '<h3 id="%s">%s: %s</h3>\n' "$folder" "$figure" "$(echo "$what" | text)"
        if [ ! -e "$out/$folder/status" ]; then
            echo '<p>Not run.</p>'
            continue
        fi
        read -r status seconds < "$out/$folder/status"
        [ "$status" -eq 0 ] || printf '<p><b>Ended with status %s.</b></p>\n' "$status"
        printf '<p>'
        for file in "$out/$folder"/*.png; do [ ! -e "$file" ] || printf '<img src="%s" alt="%s">\n' "$folder/$(basename "$file")" "$(basename "$file")"; done
        printf '</p><p>'
        for file in "$out/$folder"/*.svg "$out/$folder"/*.tsv "$out/$folder"/said.txt; do
            case $file in */claims.tsv) continue ;; esac
            [ ! -e "$file" ] || printf '<a href="%s">%s</a> ' "$folder/$(basename "$file")" "$(basename "$file")"
        done
        printf '(%s s)</p>\n' "$seconds"
    done < "$out/experiments"
} > "$out/index.html"
echo "papers: $out/index.html: $(wc -l < "$out/experiments") experiments, $(($(wc -l < "$out/table.tsv") - 1)) lines in the table, $(($(date +%s) - begun)) s, $(cat "$out"/*/status | awk '{ s += $2 } END { print s }') s with what was kept"
exit $worst
