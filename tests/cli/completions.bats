# Completions made from --help: they load, and complete options and values.

bats_require_minimum_version 1.5.0

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    generate="$BATS_TEST_DIRNAME/../../share/completions/generate"
    for shell in bash zsh fish; do
        for tool in "$BIN"/*; do
            "$tool" --help | "$generate" $shell "${tool##*/}" > "${tool##*/}.$shell"
        done
    done
}

# what bash offers at the end of a command line
offers() {
    COMP_WORDS=("$@")
    COMP_CWORD=$(($# - 1))
    local name=_sinew_${1//-/_}
    "$name"
    printf '%s\n' "${COMPREPLY[@]}"
}

@test "bash: options, values and files are completed" {
    for tool in "$BIN"/*; do
        . "./${tool##*/}.bash"
    done
    [ "$(offers mesh-clean --we)" = --weld ]
    [ "$(offers attach-detect --bo | sort | tr '\n' ' ')" = "--bone --bone-units --bone-up --bones " ]
    [ "$(offers mesh-clean --units c)" = cm ]
    [ "$(offers mesh-clean --weld "")" = "" ]
    touch biceps.ply
    [ "$(offers mesh-clean bic)" = biceps.ply ]
    [ "$(offers attach-detect --bone bic)" = biceps.ply ]
    complete -p rig-view | grep -q _sinew_rig_view
}

@test "every option of --help is offered by every shell" {
    for tool in "$BIN"/*; do
        name=${tool##*/}
        . "./$name.bash"
        offers "$name" -- > offered
        for option in $("$tool" --help | grep -o -e '^ *\(-.,\)\? *--[a-z-]*' | grep -o -e '--[a-z-]*'); do
            grep -qx -e "$option" offered
            grep -q -e "$option\[\|$option}" "$name.zsh"
            grep -q -e " -l ${option#--} " "$name.fish"
        done
    done
}

# the values of --help, a line "OPTION VALUE ..." each
values() { "$BIN/$1" --help | sed -n '/^Values:$/,/^$/{s/,//g;s/^  --//p}'; }

@test "every known value is completed by every shell" {
    for tool in "$BIN"/*; do
        name=${tool##*/}
        . "./$name.bash"
        values "$name" > known
        while read -r option words; do
            [ "$(offers "$name" "--$option" "" | tr '\n' ' ')" = "$words " ] || { echo "$name --$option"; offers "$name" "--$option" ""; false; }
            grep -q -e "--$option[^a-z-].*[( ]$words[)']" "$name.zsh" || { echo "$name.zsh --$option"; false; }
            grep -q -e " -l $option .*-a '$words'" "$name.fish" || { echo "$name.fish --$option"; false; }
        done < known
    done
    [ "$(values simulate | grep -c -E '^(law|scheme|solver|precision|hinges|format|collision) ')" -eq 7 ]
    [ "$(offers simulate --scheme k)" = kohout ]
    [ "$(offers simulate --scheme = k)" = kohout ] # as bash parts --scheme=k
    [ "$(offers simulate --scheme = | wc -l)" -eq 3 ]
    [ "$(offers rig-view --show surface,ext)" = surface,externals ]
    [ "$(offers rig-view --show surface,ext,w)" = surface,ext,wire ]
}

@test "the values that the help tells are those that the tools take" {
    for tool in "$BIN"/*; do
        name=${tool##*/}
        values "$name" > known
        while read -r option words; do
            for word in $words; do
                run "$tool" "--$option" "$word" none.of.these.json
                case $output in *"not one of"* | *" is no "*) echo "$name --$option $word: $output"; false ;; esac
            done
        done < known
    done
}

@test "zsh and fish read them" {
    for tool in "$BIN"/*; do
        name=${tool##*/}
        bash -n "$name.bash"
        if command -v zsh > /dev/null; then zsh -n "$name.zsh"; fi
        if command -v fish > /dev/null; then fish -n "$name.fish"; fi
        [ "$(head -n 1 "$name.zsh")" = "#compdef $name" ]
    done
}

@test "help without options, and an unknown shell, are refused" {
    run -1 sh -c "echo nothing | '$generate' bash x"
    run -2 sh -c "echo nothing | '$generate' tcsh x"
}
