# list.awk -- names, options and dependencies of all muscles, from the lists of surfaces and bones and the table of options.
# Given: state, stages (folders), table (file or ""). Input: lines of name, extension, path, path as given; the muscles' file first, then the
# bones'. Writes state/in.tsv.new and state/bones.tsv.new (safe name, extension, path, name, path as given), sorted by name for comm; options/NAME.TOOL;
# all.bones; assets.mk. A file that would come out the same is left alone, with its time stamp.

# all that is wrong is told, and then nothing is done
function complain(text) { print "sinew.mk: " text | "cat >&2"; failed = 1 }

function write_if_changed(file, text,    line, old) {
    old = ""
    while ((getline line < file) > 0) old = old line "\n"
    close(file)
    if (old == text) return
    printf "%s", text > file
    close(file)
}

# what neither make nor a shell takes for anything else: every run of other characters becomes one _
function safe_name(name,    safe) {
    safe = name
    gsub(/[^A-Za-z0-9._+\200-\377-]+/, "_", safe)
    if (safe != name) sub(/_$/, "", safe)
    return safe
}

# a pattern with * and ? against a whole name
function matches(pattern, name) {
    if (pattern == name) return 1
    if (pattern !~ /[*?]/) return 0
    gsub(/[][(){}.^$|+\\]/, "\\\\&", pattern)
    gsub(/\*/, ".*", pattern)
    gsub(/\?/, ".", pattern)
    return name ~ ("^" pattern "$")
}

# a surface may be called by its safe name, its own, or its own with the extension
function is_called(pattern, kind, i) {
    return matches(pattern, safe[kind, i]) || matches(pattern, own[kind, i]) || matches(pattern, own[kind, i] "." extension[kind, i])
}

# ---- surfaces and bones --------------------------------------------------------------------------------------------------------------

BEGIN {
    FS = "\t"
    split("mesh-clean attach-detect root-select build-structure fiber-flow fiber-fill", tool_names, " ")
    split("clean attached roots structure fibers muscle", suffixes, " ")
    for (t = 1; t in tool_names; t++) tool_number[tool_names[t]] = t
    count["in"] = count["bones"] = 0
}

{
    kind = FILENAME == ARGV[1] ? "in" : "bones"
    name = safe_name($1)
    if (name == "" || name ~ /^-/) complain("'" $4 "': no usable name; rename it")
    if ((kind, name) in taken) complain("'" taken[kind, name] "' and '" $4 "' would both be called '" name "'; rename one of them")
    taken[kind, name] = $4
    i = ++count[kind]
    safe[kind, i] = name
    own[kind, i] = $1
    extension[kind, i] = $2
    path[kind, i] = $3
    shown[kind, i] = $4
}

function write_surfaces(kind,    i, sorted) {
    sorted = "sort > '" state "/" kind ".tsv.new'"
    for (i = 1; i <= count[kind]; i++) 
        printf "%s\t%s\t%s\t%s\t%s\n", safe[kind, i], extension[kind, i], path[kind, i], own[kind, i], shown[kind, i] | sorted
    if (count[kind] == 0) printf "" | sorted
    close(sorted)
}

# ---- the table of options ------------------------------------------------------------------------------------------------------------

function add_bones(i, words, where,    k, n, b, word, any) {
    n = split(words, word, " ")
    if (n == 0) complain(where "no bones named; leave the line out for all of them")
    for (k = 1; k <= n; k++) {
        any = 0
        for (b = 1; b <= count["bones"]; b++)
            if (is_called(word[k], "bones", b)) any = chosen[i, b] = 1
        if (!any && !((where, word[k]) in told)) complain(where "there is no bone '" word[k] "'")
        if (!any) told[where, word[k]] = 1 # once, for however many muscles
    }
    has_choice[i] = 1
}

function add_row(pattern, tool, words, where,    i, any) {
    if (!(tool in tool_number) && tool != "bones" && tool != "candidates" && tool != "architecture")
        complain(where "'" tool "' is none of mesh-clean, attach-detect, root-select, build-structure, fiber-flow, fiber-fill, bones, candidates, architecture")
    if ((" " words " ") ~ / (-o|--output|--report)[ =]/) complain(where "--output and --report are given by sinew.mk")
    for (i = 1; i <= count["in"]; i++) {
        if (!is_called(pattern, "in", i)) continue
        any = 1
        if (tool == "bones") add_bones(i, words, where)
        else given[i, tool] = given[i, tool] " " words
    }
    if (!any) complain(where "there is no muscle '" pattern "'")
}

function read_table(    line, number, rows, cell, where, n) {
    while ((getline line < table) > 0) {
        number++
        sub(/\r$/, "", line)
        if (number == 1) sub(/^\357\273\277/, "", line)
        if (line ~ /^[ \t]*(#|$)/ || (rows++ == 0 && line ~ /^muscle\ttool\t/)) continue
        n = split(line, cell, "\t")
        where = table ":" number ": "
        if (n < 3) complain(where "a line needs a muscle, a tool and options with a tab between them")
        if (n > 3) complain(where "more than three columns; options are separated by spaces")
        if (n == 3) add_row(cell[1], cell[2], cell[3], where)
    }
    close(table)
}

# ---- what make reads -------------------------------------------------------------------------------------------------------------------

# files that options name are dependencies too
function named_files(words,    n, k, word, line, files) {
    n = split(words, word, /[ =]+/)
    for (k = 1; k <= n; k++) {
        if (word[k] !~ /^[A-Za-z0-9_.\/+][A-Za-z0-9_.\/+-]*\.[A-Za-z0-9]+$/) continue
        if ((getline line < word[k]) >= 0) files = files " " word[k]
        close(word[k])
    }
    return files
}

function shared_options(tool,    words) {
    if (tool == "mesh-clean" && ENVIRON["SINEW_UNITS"] != "") words = words " --units " ENVIRON["SINEW_UNITS"]
    if (tool == "mesh-clean" && ENVIRON["SINEW_UP"] != "") words = words " --up " ENVIRON["SINEW_UP"]
    if (tool == "attach-detect" && ENVIRON["SINEW_BONE_UNITS"] != "") words = words " --bone-units " ENVIRON["SINEW_BONE_UNITS"]
    if (tool == "attach-detect" && ENVIRON["SINEW_BONE_UP"] != "") words = words " --bone-up " ENVIRON["SINEW_BONE_UP"]
    if (tool == "fiber-fill" && ENVIRON["SINEW_FIBERS"] != "") words = words " --fibers " ENVIRON["SINEW_FIBERS"]
    return words
}

# the list of bones for attach-detect, with paths from the folder of the list; returns its name, "" where there are none
function write_bones(i,    b, text) {
    if (!(i in has_choice)) return count["bones"] > 0 ? "all.bones" : ""
    for (b = 1; b <= count["bones"]; b++)
        if ((i, b) in chosen) text = text safe["bones", b] "\t../bones/" safe["bones", b] "." extension["bones", b] "\n"
    write_if_changed(state "/options/" safe["in", i] ".bones", text)
    return "options/" safe["in", i] ".bones"
}

function bone_sums(i,    b, sums) {
    if (!(i in has_choice)) return count["bones"] > 0 ? " " state "/all.sum" : ""
    for (b = 1; b <= count["bones"]; b++)
        if ((i, b) in chosen) sums = sums " " state "/bones/" safe["bones", b] ".sum"
    return sums " " state "/options/" safe["in", i] ".bones"
}

# options of one muscle's stages; the second line tells what else the stage hangs on
function write_muscle(i,    t, tool, words, text, rules, name) {
    name = safe["in", i]
    for (t = 1; t in tool_names; t++) {
        tool = tool_names[t]
        words = shared_options(tool) given[i, tool]
        sub(/^ +/, "", words)
        text = words "\n"
        if (tool == "mesh-clean") text = text "# surface: " path["in", i] "\n"
        if (tool == "attach-detect") text = text "# bones: " write_bones(i) "\n"
        write_if_changed(state "/options/" name "." tool, text)
        words = named_files(words)
        if (words != "") rules = rules stages "/" name "." suffixes[t] ".done:" words "\n"
    }
    words = given[i, "candidates"]
    sub(/^ +/, "", words)
    write_if_changed(state "/options/" name ".candidates", words "\n")
    rules = rules state "/candidates/" name ".done:" named_files(words) bone_sums(i) "\n"
    words = given[i, "architecture"]
    sub(/^ +/, "", words)
    write_if_changed(state "/options/" name ".architecture", words "\n")
    rules = rules state "/architecture/" name ".done:" named_files(words) "\n"
    words = state "/in/" name "." extension["in", i]
    rules = rules stages "/" name ".clean.done: " words "\n" state "/lint/surface/" name ".done: " words "\n"
    return rules stages "/" name ".attached.done:" bone_sums(i) "\n"
}

function write_rules(    i, names, rules, link) {
    for (i = 1; i <= count["in"]; i++) names = names " " safe["in", i]
    rules = "sinew_names :=" names "\n"
    names = ""
    for (i = 1; i <= count["bones"]; i++) names = names " " safe["bones", i]
    rules = rules "sinew_bones :=" names "\n"
    for (i = 1; i <= count["in"]; i++) rules = rules write_muscle(i)
    for (i = 1; i <= count["bones"]; i++) {
        link = state "/bones/" safe["bones", i] "." extension["bones", i]
        rules = rules state "/bones/" safe["bones", i] ".done: " link "\n" state "/lint/bone/" safe["bones", i] ".done: " link "\n"
    }
    write_if_changed(state "/assets.mk", rules)
}

function write_all_bones(    b, text) {
    for (b = 1; b <= count["bones"]; b++)
        text = text safe["bones", b] "\tbones/" safe["bones", b] "." extension["bones", b] "\n"
    write_if_changed(state "/all.bones", text)
}

END {
    if (table != "") read_table()
    if (failed) exit 1
    write_surfaces("in")
    write_surfaces("bones")
    write_all_bones()
    write_if_changed(state "/lint.options", ENVIRON["SINEW_LINT"] "\n# units:" shared_options("mesh-clean") shared_options("attach-detect") "\n")
    write_rules()
}
