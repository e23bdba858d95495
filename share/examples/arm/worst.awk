# From the log of simulate: the worst volume error, length error and smallest triangle of the run. Fails where the volume strays by
# more than 1 %, a position is not a number, or the log is empty.

# The number that follows "name": after the text `from`.
function number(from, name,    at) {
    at = index($0, from)
    if (!at) return 0
    rest = substr($0, at)
    at = index(rest, "\"" name "\":")
    return at ? substr(rest, at + length(name) + 3) + 0 : 0
}
function where() { return label " at frame " number("{", "frame") }

{
    gsub(/": /, "\":")
    label = $0
    sub(/.*"muscle":"/, "", label)
    sub(/".*/, "", label)
    volume = number("{", "volume_error")
    if (volume < 0) volume = -volume
    if (volume >= worst_volume) { worst_volume = volume; volume_at = where() }
    split("internal radial mesh", kinds, " ")
    for (k in kinds) {
        largest = number("\"" kinds[k] "\":", "max")
        rms = number("\"" kinds[k] "\":", "rms")
        if (largest >= worst_length) { worst_length = largest; length_at = kinds[k] " edge, " where() }
        if (rms >= worst_rms) { worst_rms = rms; rms_at = kinds[k] " edges, " where() }
    }
    triangle = number("{", "smallest_triangle")
    if (NR == 1 || triangle < smallest) { smallest = triangle; triangle_at = where() }
    nan += number("{", "nan")
}

END {
    if (NR == 0) { print "the log is empty" > "/dev/stderr"; exit 1 }
    printf "  worst volume error      %7.3f %% of the goal        (%s)\n", 100 * worst_volume, volume_at
    printf "  worst length error, rms %7.3f mean edges          (%s)\n", worst_rms, rms_at
    printf "  worst length error, max %7.3f mean edges          (%s)\n", worst_length, length_at
    printf "  smallest triangle       %7.3f of its rest area    (%s)\n", smallest, triangle_at
    if (nan > 0 || worst_volume > 0.01) { print "the simulation has failed: see arm.jsonl" > "/dev/stderr"; exit 1 }
}
