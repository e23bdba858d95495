# summary.awk -- a line for each muscle from its reports and logs. Given: out (folder). Input: state/in.tsv. With report.awk.

function number(value) { return value == "" ? "" : value + 0 }

function warnings_in(file,    line, n) {
    while ((getline line < file) > 0)
        if (line ~ /: warning: /) {
            n++
            if (first == "") first = line
        }
    close(file)
    return n + 0
}

function exists(file,    line, found) {
    found = (getline line < file) >= 0
    close(file)
    return found
}

function print_head(    t) {
    printf "muscle\tsurface\tstatus\tstage\tmessage\twarnings\ttriangles_before\ttriangles\tcomponents_before\tholes_filled\tvolume"
    printf "\troots\tsamples\tbranches\tattached\tbones"
    for (t = 1; t in tool; t++) printf "\t%s_s", tool[t]
    print "\ttotal_s"
}

BEGIN {
    FS = "\t"
    split("mesh-clean attach-detect root-select build-structure fiber-flow fiber-fill", tool, " ")
    split("clean attached roots structure fibers muscle", suffix, " ")
    print_head()
}

{
    status = "ok"
    stage = message = first = ""
    warnings = total = 0
    times = ""
    split("", all)
    for (t = 1; t in tool; t++) {
        read_report(out "/stages/" $1 "." suffix[t] ".report.json", field)
        for (key in field) all[tool[t], key] = field[key]
        times = times "\t" number(field["seconds"])
        total += field["seconds"]
        warnings += warnings_in(out "/logs/" $1 "." tool[t] ".log")
        line = first_line(out "/stages/" $1 "." suffix[t] ".short")
        if (line != "") {
            status = "short"
            stage = tool[t]
            message = line
        }
    }
    if (message == "") message = first
    if (!exists(out "/" $1 ".muscle.json")) {
        status = "failed"
        stage = "-"
        message = "not made"
    }
    if (split(first_line(out "/stages/" $1 ".failed"), cell, "\t") == 2) {
        status = "failed"
        stage = cell[1]
        message = cell[2]
    }
    gsub(/\t/, " ", message)
    printf "%s\t%s\t%s\t%s\t%s\t%d", $1, $3, status, stage, message, warnings
    printf "\t%s\t%s\t%s\t%s\t%s", all["mesh-clean", "before.triangles"], all["mesh-clean", "after.triangles"], all["mesh-clean", "before.components"],
        all["mesh-clean", "holesFilled"], number(all["mesh-clean", "after.volume"])
    printf "\t%s\t%s\t%s\t%s\t%s", all["root-select", "count"], all["build-structure", "samples"], all["build-structure", "branches"],
        all["attach-detect", "attached"], all["attach-detect", "attachments.bone#"] + 0
    printf "%s\t%s\n", times, total
}
