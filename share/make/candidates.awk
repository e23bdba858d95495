# candidates.awk -- a line for each rig from the reports of its candidates for external constraints. Given: out, stages (folders).
# Input: state/in.tsv. With report.awk.

BEGIN {
    FS = "\t"
    count = split("searched rows deep superficial slide soft hard idle entered without hidden surplus leastDistance meanDistance greatestDistance", key, " ")
    printf "muscle\tstatus\tmessage\tvertices\ttargets"
    for (k = 1; k <= count; k++) printf "\t%s", key[k]
    print ""
}

{
    found = read_report(stages "/" $1 ".candidates.report.json", field)
    status = found ? "ok" : "failed"
    message = found ? "" : first_line(stages "/" $1 ".candidates.failed")
    if (!found && message == "") message = "there is no rig"
    gsub(/\t/, " ", message)
    printf "%s\t%s\t%s\t%s\t%s", $1, status, message, field["vertices"], found ? field["externals.target#"] + 0 : ""
    for (k = 1; k <= count; k++) printf "\t%s", field["neighbours." key[k]]
    print ""
}
