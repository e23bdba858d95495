#!/bin/sh
# [K21] figure 3: bones as voxels: 64 along each axis; about n_max = 262144 in all; about 2097152. A picture of each and of the surface, cells,
# and memory: by the paper a byte a cell, here a bit. BONES are files, or NAME=FILE; by default pelvis and femur of the dog in HIP or DATA,
# or else humerus and scapula of the generated arm.
# Usage: k21-voxels.sh [-o OUT] [BONE...]
recipe_bones=yes
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
if [ $# -eq 0 ] && [ -e "${HIP:-$out/hip}/near/Pelvis.ply" ]; then
    set -- "${HIP:-$out/hip}/near/Pelvis.ply" "${HIP:-$out/hip}/near/Femoris_L.ply"
elif [ $# -eq 0 ] && [ -e "${DATA:-}/dog-dmcontrol/meshes/BONEPelvis.stl" ]; then
    set -- "pelvis=$DATA/dog-dmcontrol/meshes/BONEPelvis.stl" "femur=$DATA/dog-dmcontrol/meshes/BONEFemoris_L.stl"
elif [ $# -eq 0 ]; then
    say "no real anatomy at ${DATA:-\$DATA}: these are bones of the generated arm"
    generate 1000
    set -- "$out/arm/scapula.ply" "$out/arm/humerus.ply"
fi
voxels_of=$(program voxels papers)
printf 'bone\tcells_asked\tx\ty\tz\tcells\tboundary\tinside\tfaces\tpublished_kb\tkb\n' > "$out/$recipe.tsv"
for bone; do
    file=${bone#*=} name=$(basename "${file%.*}")
    case $bone in *=*) name=${bone%%=*} ;; esac
    ln -sf "$(cd "$(dirname "$file")" && pwd)/$(basename "$file")" "$out/$name.${file##*.}"
    drawn="$out/$name.${file##*.}"
    for cells in 64 total:262144 total:2097152; do
        as=$out/$name-${cells#total:}.obj
        figures=$("$voxels_of" "$file" "$cells" "$as")
        printf '%s\t%s\t%s\n' "$name" "$cells" "$figures" >> "$out/$recipe.tsv"
        drawn="$drawn $as"
    done
    # shellcheck disable=SC2086
    rig-view $drawn --units m --columns 4 --size 420x420 --show surface --camera 50:15 --title "$name: surface, 64 along each axis, n_max = 262144, 2097152" \
        -q -o "$out/$recipe-$name.png"
    say "$out/$recipe-$name.png"
done
rm -f "$out"/*.obj "$out"/*.ply "$out"/*.stl
cells() { awk -F '\t' -v c="$1" -v n="$2" 'NR > 1 { x = x (k++ ? "; " : "") (n == 3 ? $3 "x" $4 "x" $5 : sprintf("%.0f", $n)) } END { print x }' "$out/$recipe.tsv"; }
claim "fig. 3: KB of the voxels of $(awk -F '\t' 'NR > 1 && !($1 in seen) { seen[$1]; printf "%s%s", n++ ? ", " : "", $1 }' "$out/$recipe.tsv"), 64 along an axis; n_max = 262144; 2097152" \
    "256; 250; 2031 and 256; 245; 2016" "$(cells 1 11) (cells $(cells 1 3))" "- (distance fields)"
awk -F '\t' -v r="$recipe" 'NR > 1 { printf "%s: %-9s %13s: %d x %d x %d, %d at the surface, %d inside, %d KB (a byte each: %d)\n", r, $1, $2, $3, $4, $5, $7, $8, $11, $10 }' "$out/$recipe.tsv"
