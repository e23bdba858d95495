# options.awk -- a table of options for sinew.mk from one with sides: a line with {side} or {Side} stands for two, with left and right.
# Input: names.txt, a muscle a line; then the table. Given some=1, lines that are no muscle's of names.txt are left out, as sinew.mk refuses
# them; without it they stay, so that a muscle misspelt is an error.

function matches(pattern, name) {
    gsub(/[][(){}.^$|+\\]/, "\\\\&", pattern)
    gsub(/\*/, ".*", pattern)
    gsub(/\?/, ".", pattern)
    return name ~ ("^" pattern "$")
}

function write(line,    cell, i) {
    split(line, cell, "\t")
    for (i = 1; some && i <= count; i++) if (matches(cell[1], name[i])) break
    if (!some || i <= count) print line
}

function sided(line, small, large) {
    gsub(/\{side\}/, small, line)
    gsub(/\{Side\}/, large, line)
    return line
}

FNR == NR { name[++count] = $0; next }
/^#/ || !NF { next }
/\{[Ss]ide\}/ { write(sided($0, "left", "Left")); write(sided($0, "right", "Right")); next }
{ write($0) }
