#!/bin/sh
# Frames of a simulation as one picture, by rig-view. Usage: [TOOLS=DIR] [SCENE=FILE] sheet.sh NAME COUNT TITLE OPTION...: COUNT frames, the last
# among them, of NAME.scene.json (or SCENE), NAME/ and NAME.jsonl. A run that did not end well says so in the title.
set -eu
name=$1 count=$2 title=$3
shift 3
first=$(sed -n '1s/^{"frame":\(-*[0-9]*\),.*/\1/p' "$name.jsonl")
last=$(sed -n '$s/^{"frame":\(-*[0-9]*\),.*/\1/p' "$name.jsonl")
[ -n "$last" ] || { echo "sheet.sh: $name.jsonl has no frames" >&2; exit 1; }
! tail -n 1000 "$name.jsonl" | grep "^{\"frame\":$last," | grep -q '"nan":[1-9]' || last=$((last - 1))
frames=$(awk -v a="$first" -v b="$last" -v n="$count" 'BEGIN { for (i = 1; i <= n; i++) printf "%s%d", (i > 1 ? "," : ""), (n > 1 ? a + int((b - a) * (i - 1) / (n - 1)) : b) }')
if [ "$(cat "$name.status")" -ne 0 ]; then title="$title: status $(cat "$name.status"), $(sed -n 's/^simulate: \(frame [0-9]*: muscle "[^"]*" has exploded\).*/\1/p' "$name.said" | head -n 1)"; fi
exec "${TOOLS:+$TOOLS/}rig-view" -q "${SCENE:-$name.scene.json}" --frames "$name" --frame "$frames" --show surface,bones --title "$title" "$@"
