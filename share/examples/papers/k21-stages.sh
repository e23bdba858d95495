#!/bin/sh
# [K21] figure 2: a muscle through the stages at a flexion of 40 degrees (or FRAMES): a) the input, with what is attached to which bone;
# b) the bones have moved, the muscle has not (wireframe); c) the surface adapted to the bones; d) the output, with its fibres. A picture
# of each, and a table of the frames, by the default.
# Usage: k21-stages.sh [-o OUT] [-t TRIANGLES] [-f FRAMES] [-i ITERATIONS] [-c] [-m MUSCLE | [-u UNIT] [-j JOINT] [-b BONES] SURFACE ATTACH-OPTION...]
# shellcheck source=common.sh
. "$(dirname "$0")/common.sh"
frames=${frames:-$(frames_to 40)}
[ "$given" -gt 0 ] || generate "${triangles:-4000}"
rig bare "$([ "$given" -gt 0 ] && echo "${triangles:-0}" || echo 0)" "$@"
fiber-fill -q --fibers 100 --segments 15 "$out/bare.muscle.json" -o "$out/muscle.muscle.json" || [ $? -eq 3 ]
scene muscle "$frames" '' "$@"
mkdir -p "$out/frames"
# shellcheck disable=SC2086
run_on "$out/muscle.scene.json" $obstacles --fibers -o "$out/frames" --log "$out/log.jsonl" -q
! wild "$out/log.jsonl" || { say "the run blew up: nothing is drawn" >&2; exit 1; }
draw() { # NAME TITLE OPTION...
    name=$1 title=$2
    shift 2
    # shellcheck disable=SC2046
    rig-view "$out/muscle.scene.json" $(focus_on) --size 480x420 --title "$title" "$@" -q -o "$out/$recipe-$name.png"
}
draw a 'a) input' --frame 0 --show surface,attachments,bones
draw b 'b) bones moved' --frame "$frames" --show surface,wire,bones
draw c 'c) surface adapted' --frames "$out/frames" --frame "$frames" --show surface,wire,bones
draw d 'd) output' --frames "$out/frames" --frame "$frames" --show surface,fibers,bones
printf 'frame\tdegrees\tvolume_error_%%\tlongest_edge\tcontacts\n' > "$out/$recipe.tsv"
awk -v d="${joint##* }" '{
    match($0, /"volume_error":[^,]*/); v = substr($0, RSTART + 15, RLENGTH - 15)
    match($0, /"largest_edge_ratio":[^,]*/); e = substr($0, RSTART + 21, RLENGTH - 21)
    c = match($0, /"contacts":[^,]*/) ? substr($0, RSTART + 11, RLENGTH - 11) : "nan"
    printf "%d\t%g\t%.4f\t%.3f\t%s\n", NR - 1, (NR - 1) * d, 100 * v, e, c }' "$out/log.jsonl" >> "$out/$recipe.tsv"
say "$out/$recipe-a.png, -b, -c, -d, $out/$recipe.tsv"
tail -n 1 "$out/$recipe.tsv" | awk -F '\t' -v r="$recipe" '{ printf "%s: at %g degrees by default: volume error %s %%, longest edge %s, %s vertices at bones\n", r, $2, $3, $4, $5 }'
