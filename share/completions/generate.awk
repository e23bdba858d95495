# generate.awk -- completions from the text of --help. Given: shell, tool.
# An option's line: "  -o, --output FILE             write to FILE"; two spaces or more end the argument's word.
# The values of one, under "Values:": "  --units                       m, cm, mm".

/^[A-Z][a-z ]*:$/ { values_follow = $0 == "Values:" }
values_follow && /^  --[a-z]/ {
    name = substr($1, 3)
    words[name] = $0
    sub(/^ *[^ ]+ +/, "", words[name])
    gsub(/,/, "", words[name])
}

/^  (-[A-Za-z], |    )--[a-z]/ {
    n++
    if (substr($0, 3, 1) == "-") short[n] = substr($0, 4, 1)
    rest = substr($0, 9)
    long[n] = rest
    sub(/[^a-z0-9-].*/, "", long[n])
    rest = substr(rest, length(long[n]) + 1)
    if (rest ~ /^ [^ ]/) {
        argument[n] = substr(rest, 2)
        sub(/ .*/, "", argument[n])
        rest = substr(rest, length(argument[n]) + 2)
    }
    sub(/^ +/, "", rest)
    help[n] = rest
}

# what an option's argument stands for: choices, "files", or "" for anything
function values(i,    word) {
    word = argument[i]
    if (long[i] in words) return words[long[i]]
    return word ~ /FILE|PATH/ || (word ~ /LIST/ && help[i] ~ /^a text file/) ? "files" : ""
}

function quoted(text) {
    gsub(/'/, "'\\''", text)
    return "'" text "'"
}

# ---- bash --------------------------------------------------------------------------------------------------------------------------

# may there be several of the values, with commas between them?
function is_list(i) { return argument[i] ~ /LIST/ && long[i] in words }

function bash_names(i) { return "--" long[i] (i in short ? " | -" short[i] : "") }

function write_bash(    i, options, name, value) {
    name = "_sinew_" tool
    gsub(/-/, "_", name)
    for (i = 1; i <= n; i++) options = options (i > 1 ? " " : "") (i in short ? "-" short[i] " " : "") "--" long[i]
    print name "() {"
    print "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}"
    print "    COMPREPLY=()"
    print "    if [[ $word == = ]]; then word=; elif [[ $before == = ]]; then before=${COMP_WORDS[COMP_CWORD - 2]}; fi"
    print "    case $before in"
    for (i = 1; i <= n; i++) {
        if (!(i in argument)) continue
        value = values(i)
        if (value == "") print "        " bash_names(i) ") return ;;"
        else if (is_list(i)) print "        " bash_names(i) ") before=; [[ $word == *,* ]] && before=${word%,*},; mapfile -t COMPREPLY < <(compgen -P \"$before\" -W " quoted(value) " -- \"${word##*,}\"); return ;;"
        else if (value != "files") print "        " bash_names(i) ") mapfile -t COMPREPLY < <(compgen -W " quoted(value) " -- \"$word\"); return ;;"
    }
    print "    esac"
    print "    if [[ $word == -* ]]; then"
    print "        mapfile -t COMPREPLY < <(compgen -W " quoted(options) " -- \"$word\")"
    print "    else"
    print "        compopt -o filenames 2> /dev/null"
    print "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\")"
    print "    fi"
    print "}"
    print "complete -F " name " " tool
}

# ---- zsh ---------------------------------------------------------------------------------------------------------------------------

function zsh_text(text) {
    gsub(/\\/, "\\\\", text)
    gsub(/\[|\]|:/, "\\\\&", text)
    return text
}

function write_zsh(    i, value, action, tail) {
    print "_arguments -s \\"
    for (i = 1; i <= n; i++) {
        tail = "[" zsh_text(help[i]) "]"
        if (i in argument) {
            value = values(i)
            action = value == "files" ? "_files" : value == "" ? " " : is_list(i) ? "_values -s , " long[i] " " value : "(" value ")"
            tail = tail ":" zsh_text(argument[i]) ":" action
        }
        if (i in short) print "    '*'{-" short[i] ",--" long[i] "}" quoted(tail) " \\"
        else print "    " quoted("*--" long[i] tail) " \\"
    }
    print "    '*:input:_files'"
}

# ---- fish --------------------------------------------------------------------------------------------------------------------------

function fish_quoted(text) {
    gsub(/[\\']/, "\\\\&", text)
    return "'" text "'"
}

function write_fish(    i, value, line) {
    for (i = 1; i <= n; i++) {
        line = "complete -c " tool (i in short ? " -s " short[i] : "") " -l " long[i]
        if (i in argument) {
            value = values(i)
            line = line (value == "files" ? " -r -F" : value == "" ? " -x" : " -x -a " fish_quoted(value))
        }
        print line " -d " fish_quoted(help[i])
    }
}

END {
    if (n == 0) {
        print "generate: no options in the help of " tool | "cat >&2"
        exit 1
    }
    if (shell == "zsh") print "#compdef " tool
    print "# " shell " completion of " tool "(1), made from its --help"
    if (shell == "bash") write_bash()
    else if (shell == "zsh") write_zsh()
    else write_fish()
}
