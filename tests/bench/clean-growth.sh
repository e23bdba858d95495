#!/bin/sh
# clean-growth.sh -- time and memory of mesh-clean on the dirty sample biceps from 1,000 to N triangles (default 1,000,000), and the exponent
# of their growth. Fails above 1.5 GB, 1.2, or SECONDS (default 10) for the largest.
#   BIN=build/release/bin EXAMPLES=build/release/examples tests/bench/clean-growth.sh [N] [SECONDS]
set -eu
export LC_ALL=C
most=${1:-1000000} seconds=${2:-10}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

printf 'triangles\tseconds\tmegabytes\n'
triangles=1000
while [ "$triangles" -le "$most" ]; do
    "${EXAMPLES:?the folder of the examples}/arm/arm" --out "$work" --dirty --triangles "$triangles" > /dev/null
    # the best of three: processor time, that others on the machine disturb least
    for i in 1 2 3; do
        /usr/bin/time -f '%U %S %M' -o "$work/time" "${BIN:?the folder of the tools}/mesh-clean" -q "$work/biceps-dirty.obj" -o "$work/out.ply"
        awk '{ printf "%.3f %.0f\n", $1 + $2, $3 / 1024 }' "$work/time"
    done | sort -n | awk -v n="$(grep -c '^f' "$work/biceps-dirty.obj")" 'NR == 1 { print n "\t" $1 "\t" $2 }'
    triangles=$((triangles * 10))
done | tee "$work/table"

# least squares over the sizes that take long enough to be timed
awk -v most_seconds="$seconds" '
    $2 > 0.02 { n++; x = log($1); y = log($2); sx += x; sy += y; xx += x * x; xy += x * y }
    { last = $2; memory = $3 }
    END {
        exponent = n > 1 ? (n * xy - sx * sy) / (n * xx - sx * sx) : 0
        printf "exponent %.2f over %d sizes; %.1f s and %.0f MB for the largest\n", exponent, n, last, memory
        bad = exponent > 1.2 || memory > 1536 || last > most_seconds
        printf "%d passed, %d failed\n", !bad, bad
        exit bad
    }' "$work/table"
