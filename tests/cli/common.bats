# What every tool must do alike: help, usage, version, exit statuses, checked output, a man page that tells all of its options.

bats_require_minimum_version 1.5.0

# a && b and ! a do not end a test under bats: state every condition by itself, and what must not hold with `refute`
needed() { case $1 in attach-detect) echo "--bone a=tetra.off" ;; rig-view) echo "-o x.png" ;; motion-fit) echo "--body none.tsv" ;; envelope-bind) echo "--bones none.json" ;; motion-sense) echo "--sensors s.json" ;; moment-arm) echo "--coordinate a" ;; esac; } # what a tool asks for besides its input

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    tools=$(ls "$BIN")
    man="$BATS_TEST_DIRNAME/../../share/man"
    printf 'OFF\n4 4 6\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' > tetra.off
}

@test "--help, --usage and --version go to stdout and exit with 0" {
    for tool in $tools; do
        for option in --help --usage --version; do
            "$BIN/$tool" $option > out 2> err
            [ -s out ]
            [ ! -s err ]
        done
        "$BIN/$tool" --version | grep -qx "$tool (sinew) [0-9]*\.[0-9]*\.[0-9]*"
        "$BIN/$tool" --usage | grep -q "^usage: $tool "
    done
}

@test "--help to a full disk is an error" {
    for tool in $tools; do
        run -1 sh -c "'$BIN/$tool' --help > /dev/full"
    done
}

@test "an unknown option is wrong usage: one line on stderr, nothing on stdout, status 2" {
    for tool in $tools; do
        for words in "--no-such-option" "-Z" "--report"; do
            code=0
            "$BIN/$tool" $words > out 2> err < /dev/null || code=$?
            [ "$code" -eq 2 ]
            [ ! -s out ]
            [ "$(wc -l < err)" -eq 1 ]
            grep -q "^$tool: " err
        done
    done
}

@test "a mistyped option is named as it was meant, in every tool; what is like none is not" {
    for tool in $tools; do
        for option in $("$BIN/$tool" --help | grep -o -e '^ *\(-.,\)\? *--[a-z-]*' | grep -o -e '--[a-z-]*'); do
            [ "${#option}" -ge 7 ] || continue
            mistyped=${option:0:4}q${option:5} # another letter for the third
            code=0
            "$BIN/$tool" "$mistyped" > out 2> err < /dev/null || code=$?
            [ "$code" -eq 2 ]
            grep -q -e "there is no option $mistyped; did you mean --[a-z-]*?;" err || { echo "$tool $mistyped"; cat err; false; }
            swapped=${option:0:3}${option:4:1}${option:3:1}${option:5}
            [ "$swapped" != "$option" ] || continue
            "$BIN/$tool" "$swapped" > out 2> err < /dev/null || true
            grep -q -e "did you mean $option?;" err || { echo "$tool $swapped"; cat err; false; }
        done
        "$BIN/$tool" --help | grep -q -e ' --strict '
        run -2 "$BIN/$tool" --qqqqqqqqqqqqqqqq
        [[ "$output" != *"did you mean"* ]]
    done
}

@test "an option by its whole name is that one, whatever others begin so" {
    for tool in $tools; do
        for option in $("$BIN/$tool" --help | grep -o -e '^ *\(-.,\)\? *--[a-z-]*' | grep -o -e '--[a-z-]*'); do
            "$BIN/$tool" "$option" > out 2> err < /dev/null || true
            refute grep -q "could be" err
        done
    done
}

@test "a mistyped value of an option with known values is named as it was meant" {
    means() { # TOOL OPTION VALUE MEANT
        run -2 "$BIN/$1" "--$2" "$3" none.json
        [[ "$output" == *"did you mean $4?"* ]] || { echo "$*: $output"; false; }
    }
    means simulate scheme romoe romeo
    means simulate solver QN qn
    means simulate law isochorik isochoric
    means rig-view show fibres fibers
    means rig-view show surface,atachments attachments
    means attach-detect method prximity proximity
    means moment-arm unit degres degrees
    means error-time stretch membran membrane
    run -2 "$BIN/mesh-clean" --units dm none.off
    [[ "$output" != *"did you mean"* ]]
    [[ "$output" == *"not one of m, cm, mm;"* ]]
}

@test "a missing input file is named, status 1" {
    for tool in $tools; do
        code=0
        extra=$(needed "$tool")
        "$BIN/$tool" $extra nowhere/none.json > out 2> err || code=$?
        [ "$code" -eq 1 ]
        [ ! -s out ]
        grep -q "nowhere/none.json" err
    done
}

@test "empty, random and truncated input: status 1, one sentence with the file's name, no output file" {
    : > empty
    head -c 3000 /dev/zero > zeros
    awk 'BEGIN { srand(7); for (i = 0; i < 3000; i++) printf "%c", 1 + int(rand() * 254) }' > random
    printf '{"format": "sinew-muscle", "version": 1, "mesh": {"vertices": [0, 0,' > cut.json
    for tool in $tools; do
        for file in empty zeros random cut.json; do
            code=0
            extra=$(needed "$tool")
            "$BIN/$tool" $extra $file -o made > out 2> err || code=$?
            [ "$code" -eq 1 ] || { echo "$tool $file: $code"; cat err; false; }
            [ ! -e made ]
            [ ! -s out ]
            grep -q "^$tool: $file:" err
            [ "$(wc -l < err)" -eq 1 ]
        done
    done
}

@test "the rig chain reads a pipe and a full disk is an error" {
    "$BIN/mesh-clean" < tetra.off > clean.json
    grep -q '"sinew-muscle"' clean.json
    run -1 sh -c "'$BIN/mesh-clean' tetra.off > /dev/full"
    run -1 sh -c "'$BIN/mesh-clean' tetra.off -o /dev/full"
    [ -c /dev/full ]
}

# piped COMMAND...: with a standard output that nobody reads any more; its status and what it said are in code and err
piped() {
    code=0
    { sleep 0.3; "$@" 2> err || echo $? > code; } | true
    code=$(cat code 2> /dev/null || echo 0)
    rm -f code
}

@test "a tool whose reader has gone ends by the signal, without a word, as others do" {
    "$EXAMPLES/tip/tip" --triangles 200 tip > /dev/null
    for tool in $tools; do
        piped "$BIN/$tool" --help
        [ "$code" -eq 141 ] || { echo "$tool --help: $code"; cat err; false; }
        [ ! -s err ]
    done
    printf '{"format": "sinew-motion", "version": 1, "rate": 24, "joints": [{"name": "b", "type": "hinge", "axis": [1,0,0], "point": [0,0,0], "keys": [[0,0],[1,90]]}]}' > m.json
    printf '{"format": "sinew-sensors", "version": 1, "sensors": [{"name": "s", "type": "angle", "joint": "b", "axis": "x", "curve": [[0,0],[90,1]]}]}' > s.json
    awk 'BEGIN { print "time\tb.angle\ts.1"; for (i = 0; i < 20; i++) print i "\t" i "\t" 0.2 - i / 1000 }' > l.tsv
    rig=tip/fusiform.muscle.json
    "$BIN/root-select" -q $rig -o rooted.json
    "$BIN/build-structure" -q rooted.json -o built.json
    while read -r tool words; do
        # shellcheck disable=SC2086
        piped "$BIN/$tool" $words
        [ "$code" -eq 141 ] || { echo "$tool $words: $code"; cat err; false; }
        refute grep -q "^$tool: [^w].*\(written\|write\|pipe\)" err
    done << END
mesh-clean -q $rig
root-select -q $rig
build-structure -q rooted.json
fiber-flow -q built.json
fiber-fill -q -n 4 built.json
attach-detect -q --pin a=indices:1 $rig
motion-import -q m.json
motion-import -q --list m.json
motion-sense -q --sensors s.json m.json
motion-sense -q --sensors s.json --list m.json
moment-arm -q --coordinate b l.tsv
moment-arm -q --list l.tsv
simulate -q tip/tip.scene.json
simulate -q --plan tip/tip.scene.json
rig-view $rig
END
    # whoever ignores the signal wants to hear of it
    (trap '' PIPE; piped "$BIN/mesh-clean" -q $rig; [ "$code" -eq 1 ])
    grep -q '^mesh-clean: .*Broken pipe' err
}

@test "--units, --up and --mesh are applied or refused, never ignored" {
    "$BIN/mesh-clean" -q --units mm tetra.off -o mm.json
    for tool in mesh-clean root-select rig-view; do
        for words in "--units m" "--units cm" "--up y" "--mesh 1"; do
            # shellcheck disable=SC2086
            run -2 "$BIN/$tool" $words mm.json -o x.out
            [[ "$output" == *mm.json:*"bare meshes"* ]] || { echo "$tool $words: $output"; false; }
        done
    done
    "$BIN/mesh-clean" -q --units mm --up z mm.json -o same.json
    echo '{"format": "sinew-scene", "version": 1}' > s.json
    run -2 "$BIN/rig-view" --units mm s.json -o x.png
    [[ "$output" == *s.json:*"bare meshes"* ]]
    echo '{"format": "sinew-motion", "version": 1, "metersPerUnit": 0.01, "joints": [{"name": "b", "type": "hinge", "axis": [1,0,0], "point": [0,0,0]}]}' > m.json
    run -2 "$BIN/motion-import" --units mm m.json
    [[ "$output" == *m.json:*"here 0.01 m, not 0.001 m"* ]]
    "$BIN/motion-import" -q --units cm m.json > out.json
    printf '{"format": "sinew-envelope", "version": 1, "mesh": {"vertices": [0,0,0, 1,0,0, 0,1,0, 0,0,1], "triangles": [0,2,1, 0,1,3, 1,2,3, 2,0,3]}, "bones": ["b"], "influences": {"counts": [1,1,1,1], "bones": [0,0,0,0], "weights": [1,1,1,1]}}' > e.json
    run -2 "$BIN/envelope-bind" --units mm --bones m.json e.json
    [[ "$output" == *e.json:*"bare meshes"* ]]
}

@test "an output that fails leaves the old file alone" {
    echo old > kept.json
    run -1 "$BIN/mesh-clean" nowhere.off -o kept.json
    [ "$(cat kept.json)" = old ]
    run -1 "$BIN/mesh-clean" tetra.off -o no-folder/x.json
    [ "$(ls | wc -l)" -eq 2 ]
}

@test "every option of --help is in the man page, and mandoc finds nothing to warn about" {
    for tool in $tools; do
        [ -s "$man/$tool.1" ]
        mandoc -Tlint -Wwarning "$man/$tool.1"
        mandoc -Tutf8 "$man/$tool.1" | col -b > page
        for option in $("$BIN/$tool" --help | grep -o -e '^ *\(-.,\)\? *--[a-z-]*' | grep -o -e '--[a-z-]*'); do
            grep -q -e "$option" page || { echo "$tool.1 says nothing of $option"; false; }
        done
        for section in NAME SYNOPSIS DESCRIPTION OPTIONS "EXIT STATUS" EXAMPLES "SEE ALSO"; do
            grep -q "^$section" page || { echo "$tool.1 has no $section"; false; }
        done
    done
}

@test "a tool is linked with nothing that it does not use" {
    links() { # TOOL LIBRARY...: is it linked with one of them?
        readelf -d "$BIN/$1" | grep NEEDED > needed
        shift
        for library in "$@"; do
            if grep -q -F "$library" needed; then return 0; fi
        done
        return 1
    }
    links mesh-clean embree
    for tool in mesh-clean root-select build-structure fiber-flow attach-detect simulate; do
        refute links $tool libpng assimp
    done
    for tool in root-select build-structure fiber-flow; do
        refute links $tool gmp mpfr 'stdc++'
    done
    links simulate mpfr # poses and stiffnesses, rounded correctly
    refute links simulate 'stdc++'
    for tool in root-select fiber-flow; do # build-structure asks what lies inside, simulate which fibre vertices lie on the surface or in bones
        refute links $tool embree
    done
    refute links build-structure gmp mpfr gsl cholmod
    refute links moment-arm embree cholmod libpng 'stdc++'
    refute links attach-detect gmp mpfr gsl cholmod
}

@test "nothing calls the functions of the C library whose bits depend on the processor" { # CGAL's calls are renamed: lib/geom/cgal_symbols
    calls() { nm -u "$@" 2> /dev/null | grep -x -E ' *U (a?(sin|cos|tan)h?|atan2|sincos|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot)[fl]?(@.*)?'; }
    build=$(dirname "$BIN")
    [ "$(nm -u "$build/libsinew.a" | grep -c -E ' U (sn_exp|mpfr_exp|sn_quick_atan2)$')" -ge 5 ]
    refute calls "$build/libsinew.a" "$build"/tools/*.o "$build"/share/examples/*/*.o
}

@test "an output whose ending says a format that a tool does not write is wrong usage, in every tool; others are not" {
    for tool in mesh-clean root-select build-structure fiber-flow fiber-fill attach-detect envelope-bind motion-import motion-fit motion-sense scene-build; do
        for ending in glb fbx dae abc usda JPG pdf; do
            run -2 "$BIN/$tool" -o "folder.x/out.$ending" /dev/null
            [[ "$output" == *"out.$ending"*.json* ]] || { echo "$tool $ending: $output"; false; }
            [ ! -e "out.$ending" ]
        done
    done
    for ending in json csv glb pdf; do
        run -2 "$BIN/moment-arm" --coordinate a -o "out.$ending" /dev/null
        [[ "$output" == *"out.$ending"*.tsv* ]]
    done
    for ending in jpg svg pdf gif json ply; do
        run -2 "$BIN/rig-view" -o "out.$ending" /dev/null
        [[ "$output" == *.png* ]]
    done
    run -2 "$BIN/mesh-clean" --report out.pdf /dev/null
    [[ "$output" == *--report*out.pdf* ]]
    "$EXAMPLES/tip/tip" --triangles 200 tip > /dev/null
    for name in out.json out.JSON out.ply out.json.new glb ./a.glb/out out.v2; do
        mkdir -p a.glb
        "$BIN/mesh-clean" -q tip/fusiform.muscle.json -o "$name"
        [ -s "$name" ]
    done
}

@test "control characters of names do not reach the terminal, and no second line" {
    esc=$(printf 'a\033[31mb\nc\177d')
    for tool in $tools; do
        code=0
        # shellcheck disable=SC2046
        "$BIN/$tool" $(needed "$tool") "$esc.json" > out 2> err || code=$?
        [ "$code" -eq 1 ]
        [ "$(wc -l < err)" -eq 1 ]
        grep -q 'a?\[31mb?c?d.json' err || { cat -v err; false; }
        [ "$(tr -d '\n' < err | tr -d ' -~' | wc -c)" -eq 0 ]
    done
    run -2 "$BIN/mesh-clean" --keep "$esc" tetra.off
    [[ "$output" == *'a?[31mb?c?d'* ]]
    cat > named.json << 'END'
{"format": "sinew-scene", "version": 1, "rate": 24, "frames": [0, 1], "bones": [], "muscles": [{"name": "\u001b[31m\u0007", "rig": "none.muscle.json"}]}
END
    run -1 "$BIN/simulate" named.json
    [ "$(echo "$output" | tr -d '\n' | tr -d ' -~' | wc -c)" -eq 0 ]
}
