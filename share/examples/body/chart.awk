# chart.awk -- from a log of simulate, columns for chart.gp: time, then of each muscle of `names` its activation, stiffness of edges (N/m, from
# 5e5 relaxed to 5e7 active in log scale, the scene's default) and volume over that at rest.
function value(line, member) { return match(line, "\"" member "\":[-+.0-9eE]+") ? substr(line, RSTART + length(member) + 3, RLENGTH - length(member) - 3) : "nan" }
BEGIN { count = split(names, name, " "); for (k = 1; k <= count; k++) number[name[k]] = k }
match($0, /"muscle":"[^"]*"/) {
    of = substr($0, RSTART + 10, RLENGTH - 11)
    if (!(of in number)) next
    k = number[of]
    if (k == 1) { rows++; time[rows] = value($0, "time") }
    activation[rows, k] = value($0, "activation")
    volume[rows, k] = value($0, "volume_ratio")
}
END {
    printf "time"
    for (k = 1; k <= count; k++) printf "\t%s\t%s stiffness\t%s volume", name[k], name[k], name[k]
    print ""
    for (r = 1; r <= rows; r++) {
        printf "%s", time[r]
        for (k = 1; k <= count; k++) printf "\t%s\t%.6g\t%s", activation[r, k], 5e5 * exp(activation[r, k] * log(100)), volume[r, k]
        print ""
    }
}
