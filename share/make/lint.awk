# lint.awk -- a line for each surface from the reports of mesh-clean --check. Given: state (folder). Input: kind, name, path. With report.awk.

# what mesh-clean said of the file, without the warnings
function complaint(file,    line, said) {
    while (said == "" && (getline line < file) > 0)
        if (line !~ /: warning: /) said = line
    close(file)
    sub(/^mesh-clean: [^:]*: */, "", said)
    return said
}

BEGIN {
    FS = "\t"
    columns = split("vertices triangles components boundaryEdges boundaryLoops nonManifoldEdges nonManifoldVertices inconsistentEdges " \
        "degenerateTriangles sliverTriangles duplicateTriangles duplicateVertices unusedVertices selfIntersections genus area volume diagonal edgeMin edgeMean " \
        "edgeMax worstQuality outward", column, " ")
    printf "kind\tname\tfile\tstatus\tdefects"
    for (i = 1; i <= columns; i++) printf "\t%s", column[i]
    printf "\n"
}

{
    code = first_line(state "/lint/" $1 "/" $2 ".code")
    defects = code == 0 ? "" : complaint(state "/lint/" $1 "/" $2 ".log")
    gsub(/\t/, " ", defects)
    read_report(state "/lint/" $1 "/" $2 ".json", field)
    printf "%s\t%s\t%s\t%s\t%s", $1, $2, $3, code == 0 ? "sound" : code == 3 ? "defective" : "unreadable", defects
    for (i = 1; i <= columns; i++) printf "\t%s", field["before." column[i]]
    printf "\n"
}
