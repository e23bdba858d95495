# Moment arms of fibres: -dl/dq of every fibre in a table of lengths (simulate --lengths, .tsv or .sto) over a coordinate of it, for each sweep
# of the coordinate by itself. Each fibre's lengths are smoothed within its sweep by l' = (l- + 4 l + l+) / 6, five times, ends kept (Kohout and
# Cervenka 2021, 4.4); the slope is that between the rows before and after, so that a sweep's first and last row have none; nor have rows about
# which the angle goes less than half of what it goes in the mean (the ends of a motion that starts and stops softly).
#
#   awk -f arms.awk -v over=hip_L_extend.rad [-v sign=-1] [-v summary=FILE] lengths.tsv > arms.tsv
#
# OVER is a column, in degrees where it ends in .angle, in radians where it ends in .rad. With sign=-1 the angle counts the other way: flexion, where
# the coordinate is one of extension. Printed, a line for each row of each sweep: muscle; sweep, from 1; degrees; mean, least and greatest arm of the
# fibres, mm; their mean length, mm. SUMMARY has a line a muscle: fibres; their mean length at the first row, mm; at the end of the first sweep;
# least, and its angle; fibres that are longer there than at first; least and greatest mean arm of the first sweep; range, that is from the
# least to the greatest of all sweeps; greatest difference of the second sweep's mean arm from the first's at the same angle, over that range, and
# its angle; rms of these. A coordinate that does not turn around has no second sweep: nan.
function fail(text) { print "arms.awk: " text > "/dev/stderr"; failed = 1; exit 1 }
function abs(x) { return x < 0 ? -x : x }
function read_names(    i, name) {
    for (i = 1; i <= NF; i++) {
        if ($i == over) x = i
        if ($i !~ /\.[0-9]+$/ || $i ~ /\.blend\.[0-9]+$/) continue
        name = $i
        sub(/\.[0-9]+$/, "", name)
        if (!(name in count)) muscles[++muscle_count] = name
        column[name, ++count[name]] = i
    }
    if (!x) fail("there is no column " over)
    if (!muscle_count) fail("there is no length of a fibre")
}
BEGIN {
    FS = "\t"
    if (over == "") fail("say -v over=COLUMN")
    if (over !~ /\.(rad|angle)$/) fail("the column " over " has no unit: its name ends in .rad or .angle")
    scale = over ~ /\.rad$/ ? 57.29577951308232 : 1
    if (sign == "") sign = 1
}
$1 == "time" { read_names(); named = NF; next }
!named { next }
NF != named { fail("line " NR " has " NF " fields instead of " named) }
{
    rows++
    angle[rows] = sign * scale * $x + 0
    if (angle[rows] == 0) angle[rows] = 0 # no -0
    for (i = 2; i <= NF; i++) l[rows, i] = 1000 * $i
}
# Sweeps: runs of rows in which the angle goes one way; where it stands still there is none.
function find_sweeps(    r, way, step) {
    for (r = 2; r <= rows; r++) {
        step = angle[r] - angle[r - 1]
        step = abs(step) < 1e-6 ? 0 : step > 0 ? 1 : -1
        if (step != way && step) { first[++sweeps] = r - 1; direction[sweeps] = step }
        if (step) last[sweeps] = r
        way = step
    }
    if (!sweeps) fail("the coordinate " over " does not move")
}
function smooth(i, a, b,    round, r, before, here) {
    for (round = 0; round < 5; round++) {
        before = l[a, i]
        for (r = a + 1; r < b; r++) { here = l[r, i]; l[r, i] = (before + 4 * here + l[r + 1, i]) / 6; before = here }
    }
}
# The mean arm of a muscle in sweep s at an angle, between the rows about it; "" = it has none there.
function arm_at(m, s, q,    r, t) {
    for (r = first[s] + 1; r < last[s] - 1; r++) {
        if (!((m, s, r) in mean_arm) || !((m, s, r + 1) in mean_arm)) continue
        if ((angle[r] - q) * (angle[r + 1] - q) > 0 || angle[r] == angle[r + 1]) continue
        t = (q - angle[r]) / (angle[r + 1] - angle[r])
        return (1 - t) * mean_arm[m, s, r] + t * mean_arm[m, s, r + 1]
    }
    return ""
}
function slow(s, r) { return abs(angle[r + 1] - angle[r - 1]) < abs(angle[last[s]] - angle[first[s]]) / (last[s] - first[s]) }
function sweep_arms(m, s,    r, k, i, v, n) {
    n = count[m]
    # a row that two sweeps share is an end of both, which smoothing keeps
    for (k = 1; k <= n; k++) smooth(column[m, k], first[s], last[s])
    for (r = first[s]; r <= last[s]; r++) {
        sum = lengths = 0; least = 1e30; most = -1e30
        for (k = 1; k <= n; k++) lengths += l[r, column[m, k]]
        mean_length[m, r] = lengths / n
        if (r == first[s] || r == last[s] || slow(s, r)) continue
        for (k = 1; k <= n; k++) {
            i = column[m, k]
            v = -(l[r + 1, i] - l[r - 1, i]) / (angle[r + 1] - angle[r - 1]) * 57.29577951308232
            sum += v; if (v < least) least = v; if (v > most) most = v
        }
        mean_arm[m, s, r] = sum / n
        printf "%s\t%d\t%.4f\t%.4f\t%.4f\t%.4f\t%.4f\n", m, s, angle[r], sum / n, least, most, lengths / n
    }
}
function summarize(m,    s, r, k, a, b, lo, hi, low1, high1, worst, at, n, squares, away, grew, shortest, short_at) {
    lo = low1 = 1e30; hi = high1 = -1e30
    for (s = 1; s <= 2 && s <= sweeps; s++)
        for (r = first[s] + 1; r < last[s]; r++) {
            if (!((m, s, r) in mean_arm)) continue
            a = mean_arm[m, s, r]
            if (a < lo) lo = a
            if (a > hi) hi = a
            if (s == 1) { low1 = lo; high1 = hi }
        }
    worst = at = away = "nan"
    for (r = first[2] + 1; sweeps > 1 && r < last[2]; r++) {
        b = (m, 2, r) in mean_arm ? arm_at(m, 1, angle[r]) : ""
        if (b == "") continue
        a = abs(mean_arm[m, 2, r] - b); n++; squares += a * a
        if (n == 1 || a > worst) { worst = a; at = angle[r] }
    }
    if (n) { away = sprintf("%.2f", 100 * sqrt(squares / n) / (hi - lo)); worst = sprintf("%.2f", 100 * worst / (hi - lo)) }
    shortest = 1e30
    for (r = first[1]; r <= last[1]; r++) if (mean_length[m, r] < shortest) { shortest = mean_length[m, r]; short_at = angle[r] }
    for (k = 1; k <= count[m]; k++) grew += l[last[1], column[m, k]] > l[first[1], column[m, k]]
    printf "%s\t%d\t%.3f\t%.3f\t%.3f\t%.1f\t%d\t%.3f\t%.3f\t%.3f\t%s\t%s\t%s\n", m, count[m], mean_length[m, first[1]], mean_length[m, last[1]], shortest, short_at,
        grew, low1, high1, hi - lo, worst, at, away > summary
}
END {
    if (failed) exit 1
    if (!named) fail("there is no line of names, with time first")
    if (rows < 5) fail("there are fewer than five rows")
    find_sweeps()
    print "muscle\tsweep\tdegrees\tarm_mean_mm\tarm_least_mm\tarm_greatest_mm\tlength_mean_mm"
    if (summary != "") print "muscle\tfibres\tlength_first_mm\tlength_turn_mm\tlength_least_mm\tat_degrees\tgrew\tarm_least_mm\tarm_greatest_mm\trange_mm\tdifference_%\tat_degrees\tdifference_rms_%" > summary
    for (m = 1; m <= muscle_count; m++) {
        for (s = 1; s <= sweeps; s++) sweep_arms(muscles[m], s)
        if (summary != "") summarize(muscles[m])
    }
}
