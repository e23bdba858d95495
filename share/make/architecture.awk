# architecture.awk -- a line for each rig from the report of the fibres through it. Given: out, stages (folders). Input: state/in.tsv.
# With report.awk. Lengths, areas and volumes in the rig's unit, whose metres are in metersPerUnit; angles in degrees.

BEGIN {
    FS = "\t"
    count = split("metersPerUnit volume fibers lengthMean lengthDeviation lengthLeast lengthGreatest pennationOriginDegrees pennationInsertionDegrees physiologicalArea tendonLengthShare bellyLengthMean bellyLengthDeviation bellyPhysiologicalArea tendon", key, " ")
    printf "muscle\tstatus\tmessage\tends"
    for (k = 1; k <= count; k++) printf "\t%s", key[k]
    print ""
}

{
    found = read_report(stages "/" $1 ".architecture.report.json", field)
    status = found ? "ok" : "failed"
    message = found ? first_line(stages "/" $1 ".architecture.short") : first_line(stages "/" $1 ".architecture.failed")
    if (found && message != "") status = "short"
    if (!found && message == "") message = "there is no rig"
    gsub(/\t/, " ", message)
    printf "%s\t%s\t%s\t%s", $1, status, message, field["ends"]
    for (k = 1; k <= count; k++) printf "\t%s", field["architecture." key[k]]
    print ""
}
