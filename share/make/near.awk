# near.awk -- which rigs are near which, by the boxes that mesh-clean reported: a list for attach-detect --muscles for each rig, the rig itself
# among them. Given: out, state, stages (folders). Input: state/sums (checksum, size and path of every cleaned document), then state/in.tsv.
# Writes state/near/NAME; one that would come out the same is left alone. A line of it tells the checksum of a rig's mesh: a mesh that has
# changed changes the lists of those near it. With report.awk.

function write_if_changed(file, text,    line, old) {
    while ((getline line < file) > 0) old = old line "\n"
    close(file)
    if (old == text) return
    printf "%s", text > file
    close(file)
}

function exists(file,    line, found) {
    found = (getline line < file) >= 0
    close(file)
    return found
}

# the reach in metres that a line of options asks for; what cannot be read is any
function reach_of(name, scale,    line, word, n, k, value) {
    value = ""
    getline line < (state "/options/" name ".candidates")
    close(state "/options/" name ".candidates")
    n = split(line, word, /[ =]+/)
    for (k = 1; k < n; k++) if (word[k] == "--reach") value = word[k + 1]
    if (value == "") return 0.005
    if (value ~ /^[0-9.eE+-]+mm$/) return value * 0.001
    if (value ~ /^[0-9.eE+-]+cm$/) return value * 0.01
    if (value ~ /^[0-9.eE+-]+m$/) return value + 0
    if (value ~ /^[0-9.eE+-]+$/) return value * scale
    return 1e9
}

# the box of a rig in metres; 0 where there is no rig
function take_box(name,    field, part, k, scale) {
    if (!exists(out "/" name ".muscle.json") || !read_report(stages "/" name ".clean.report.json", field)) return 0
    scale = field["metersPerUnit"]
    gsub(/[][ ]/, "", field["after.boxLow"])
    gsub(/[][ ]/, "", field["after.boxHigh"])
    split(field["after.boxLow"], part, ",")
    for (k = 1; k <= 3; k++) low[name, k] = part[k] * scale
    split(field["after.boxHigh"], part, ",")
    for (k = 1; k <= 3; k++) high[name, k] = part[k] * scale
    reach[name] = reach_of(name, scale)
    return 1
}

function gap(a, b,    k, d, sum) {
    for (k = 1; k <= 3; k++) {
        d = low[a, k] - high[b, k]
        if (low[b, k] - high[a, k] > d) d = low[b, k] - high[a, k]
        if (d > 0) sum += d * d
    }
    return sqrt(sum)
}

FILENAME == ARGV[1] {
    name = $0
    sub(/^[0-9]+ [0-9]+ /, "", name)
    sub(/.*\//, "", name)
    sub(/\.clean\.json$/, "", name)
    split($0, cell, " ")
    sum[name] = cell[1] " " cell[2]
    next
}

{
    split($0, cell, "\t")
    if (take_box(cell[1])) rig[++n] = cell[1]
}

END {
    for (i = 1; i <= n; i++) {
        text = ""
        for (k = 1; k <= n; k++)
            if (gap(rig[i], rig[k]) <= reach[rig[i]] * (1 + 1e-6)) text = text "# mesh " sum[rig[k]] "\n../../" rig[k] ".muscle.json\n"
        write_if_changed(state "/near/" rig[i], text)
    }
}
