#!/bin/sh
# rig-growth.sh -- time and memory of root-select, build-structure and fiber-flow, documents read and written, on the sample biceps from 1,000
# to N triangles (default 1,000,000), and the exponent of their growth. Fails above an exponent of 1.2, 1.5 kB a triangle, or 60 s.
#   BIN=build/release/bin EXAMPLES=build/release/examples tests/bench/rig-growth.sh [N]
set -eu
export LC_ALL=C
most=${1:-1000000}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# run TOOL OPTION... INPUT OUTPUT: one line of the table; processor time, that others on the machine disturb least
run() {
    /usr/bin/time -f '%U %S %M' -o "$work/time" "${BIN:?the folder of the tools}/$1" -q "$2" -o "$3"
    awk -v tool="$1" -v n="$triangles" '{ printf "%s\t%d\t%.3f\t%.0f\n", tool, n, $1 + $2, $3 / 1024 }' "$work/time"
}

printf 'tool\ttriangles\tseconds\tmegabytes\n'
triangles=1000
while [ "$triangles" -le "$most" ]; do
    "${EXAMPLES:?the folder of the examples}/arm/arm" --out "$work" --triangles "$triangles" > /dev/null
    run root-select "$work/biceps.ply" "$work/roots.json"
    run build-structure "$work/roots.json" "$work/built.json"
    run fiber-flow "$work/built.json" "$work/flow.json"
    triangles=$((triangles * 10))
done | tee "$work/table"

# least squares over the sizes that take long enough to be timed; memory a triangle at the largest
awk '
    $3 > 0.02 { n[$1]++; x = log($2); y = log($3); sx[$1] += x; sy[$1] += y; xx[$1] += x * x; xy[$1] += x * y }
    { last[$1] = $3; kilobytes[$1] = $4 * 1024 / $2 }
    END {
        for (tool in last) {
            spread = n[tool] * xx[tool] - sx[tool] * sx[tool]
            exponent = n[tool] > 1 ? (n[tool] * xy[tool] - sx[tool] * sy[tool]) / spread : 0
            bad = exponent > 1.2 || kilobytes[tool] > 1.5 || last[tool] > 60
            printf "%s: exponent %.2f; %.1f s and %.2f kB a triangle at the largest%s\n", tool, exponent, last[tool], kilobytes[tool], bad ? ": too much" : ""
            failed += bad; passed += !bad
        }
        printf "%d passed, %d failed\n", passed, failed
        exit failed > 0
    }' "$work/table"
