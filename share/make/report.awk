# Numbers and words out of a tool's report: a key and a value a line. read_report(FILE, FIELD) fills FIELD["key"], and
# FIELD["before.key"] for what lies in an object; returns whether there is such a file. FIELD["KEY#"] tells how often a key came, in a list of objects.
function read_report(file, field,    line, key, value, scope, found) {
    split("", field)
    while ((getline line < file) > 0) {
        found = 1
        if (line ~ /^ *"[A-Za-z0-9_-]+": [{[]$/) {
            split(line, key, "\"")
            if (line ~ /^  "/) scope = key[2] "."
        } else if (line ~ /^  [}\]],?$/) {
            scope = ""
        } else if (line ~ /^ *"[A-Za-z0-9_-]+": /) {
            split(line, key, "\"")
            value = line
            sub(/^[^:]*: /, "", value)
            sub(/,$/, "", value)
            gsub(/^"|"$/, "", value)
            field[scope key[2]] = value
            field[scope key[2] "#"]++
        }
    }
    close(file)
    return found
}

# The first line of a file; nothing where there is none.
function first_line(file,    line) {
    line = ""
    getline line < file
    close(file)
    return line
}
