# What make prints, how the counts of suites are added up, and what is said while packages install.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

setup() {
    top=$(cd "$BATS_TEST_DIRNAME/../.." && pwd)
    cd "$BATS_TEST_TMPDIR" || exit 1
}

@test "make prints a short line a file, under V=1 the command, under -s nothing" {
    compile() { make -C "$top" --no-print-directory "B=$PWD/b" "$@" "$PWD/b/lib/base/word.o" > said; rm -r b; }
    compile
    [ "$(cat said)" = "CC lib/base/word.c" ]
    compile -j2
    [ "$(cat said)" = "CC lib/base/word.c" ]
    compile V=1
    [ "$(wc -l < said)" -eq 1 ]
    grep -q -e '-c -o .*word.o lib/base/word.c$' said
    compile -s
    [ ! -s said ]
}

@test "what a suite skips is no longer passed, and the last line names the suite" {
    suite() { "$top/tests/suite" "stamps/$1" "$1" sh -c "$2"; }
    suite bats 'echo "ok 1 a"; echo "ok 2 b # skip no data"' > said
    grep -q '1 passed   0 failed .*(1 skipped)' said
    suite cmocka 'echo "[==========] 2 test(s) run."; echo "skipped: no data"; echo "[  PASSED  ] 1 test(s)."; echo "[  SKIPPED ] 1 test(s), listed below:"' > said
    grep -q '1 passed   0 failed .*(1 skipped)' said
    suite own 'echo "no real anatomy at x: skipped"; echo "1 passed, 0 failed"' > said
    grep -q '0 passed   0 failed .*(1 skipped)' said
    suite loose 'echo "skipped: origins of gait (no such data)"; echo "3 passed, 0 failed"' > said
    suite whole 'echo "ok 1 a"; echo "2 passed, 0 failed"' > said
    refute grep -q skipped said
    [ "$("$top/tests/sum" stamps/whole)" = "3 passed, 0 failed" ]
    [ "$("$top/tests/sum" stamps/bats stamps/cmocka stamps/own stamps/loose stamps/whole)" = "8 passed, 0 failed, 4 skipped in bats, cmocka, own, loose" ]
    run -1 "$top/tests/sum" stamps/bats stamps/none
    [ "${lines[1]}" = "1 passed, 1 failed, 1 skipped in bats" ]
    run -1 suite bad 'echo "not ok 1 a"; echo "ok 2 # skip"'
    run -1 "$top/tests/sum" stamps/bad
    [ "${lines[0]}" = "0 passed, 1 failed, 1 skipped in bad" ]
    run -1 suite empty true
    [[ "$output" == *"empty ran no test"* ]]
}

@test "a line is said for every package that installs; a failure of apt-get is one of make deps" {
    mkdir -p bin
    printf '#!/bin/sh\ncase $* in *libb*) echo not-installed ;; *) echo installed ;; esac\n' > bin/dpkg-query
    printf '#!/bin/sh\necho 0\n' > bin/id
    cat > bin/apt-get << 'END'
#!/bin/sh
[ "$1" = install ] || exit 0
echo "Reading package lists..."
echo "Get:1 http://deb.debian.org/debian bookworm/main amd64 libb-dev amd64 1.2 [40 kB]"
echo "Setting up libb-dev (1.2) ..."
exit "$(cat code)"
END
    chmod +x bin/*
    printf '# a comment\nliba-dev\nlibb-dev # why\n' > list
    echo 0 > code
    PATH=$PWD/bin:$PATH "$top/share/make/install-packages" list > said
    printf 'deps: %s\n' "installing libb-dev" "fetching the lists of packages" "fetched libb-dev" "set up libb-dev" | cmp said -
    echo 100 > code
    PATH=$PWD/bin:$PATH run -1 "$top/share/make/install-packages" list
    [[ "$output" == *"deps: apt-get failed"* ]]
}
