# names.awk -- a log with the names of its user's files: links in state/in and state/bones, and the documents of a muscle's stages, stand for its
# surface. Given: name (of the muscle or bone), state, stages (folders), bones (bones.tsv). Input: state/in.tsv, then the log.

# in place of every `old`, which is no pattern
function swap(text, old, new,    at, out) {
    while ((at = index(text, old)) > 0) {
        out = out substr(text, 1, at - 1) new
        text = substr(text, at + length(old))
    }
    return out text
}

# tools come upon bones by lists in state/ and in state/options/
function take_bones(    line, cell) {
    while ((getline line < bones) > 0) {
        split(line, cell, "\t")
        link[++links] = state "/options/../bones/" cell[1] "." cell[2]
        path[links] = cell[5]
        link[++links] = state "/bones/" cell[1] "." cell[2]
        path[links] = cell[5]
    }
    close(bones)
}

BEGIN {
    FS = "\t"
    count = split("clean attached roots structure fibers", suffix, " ")
    take_bones()
}

FILENAME == ARGV[1] {
    if ($1 != name) next
    link[++links] = state "/in/" $1 "." $2
    path[links] = $5
    for (k = 1; k <= count; k++) {
        link[++links] = stages "/" $1 "." suffix[k] ".json"
        path[links] = $5
    }
    next
}

{
    for (k = 1; k <= links && index($0, state "/") + index($0, stages "/") > 0; k++) $0 = swap($0, link[k], path[k])
    print
}
