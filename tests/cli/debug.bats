# What sinew-debug(7) tells of the broken biceps is so.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

setup() {
    cd "$BATS_TEST_TMPDIR" || exit 1
    PATH=$BIN:$PATH
    "$EXAMPLES/arm/arm" --out . --triangles 1000
    mesh-clean biceps.ply -o biceps.obj
    awk -f "$BATS_TEST_DIRNAME/../../share/examples/arm/bridge.awk" biceps.obj > bridged.obj
    mesh-clean bridged.obj -o bridged.json --report bridged.report.json
}

figure() { sed -n "s/^  \"$1\": \([0-9]*\),*$/\1/p" "$2"; }

@test "the bridge leaves a closed, oriented surface without crossings, with one handle" {
    mesh-clean --check --self-intersections bridged.obj --report check.json
    grep -q '"genus": 1,' check.json
    [ "$(grep -c '^f' bridged.obj)" -eq "$(($(grep -c '^f' biceps.obj) + 4))" ]
    for tool in mawk gawk original-awk; do
        command -v $tool > /dev/null || continue
        $tool -f "$BATS_TEST_DIRNAME/../../share/examples/arm/bridge.awk" biceps.obj > other.obj
        cmp bridged.obj other.obj
    done
}

@test "the trace's third split is at the bridge, and not there without it" {
    height=$(sed -n 's/^# bridge at height //p' bridged.obj)
    root-select bridged.json -o roots.json 2> warned
    grep -q 'handles (genus 1)' warned
    build-structure roots.json --trace bridged.jsonl --report bridged.report.json -o structure.json
    root-select biceps.obj | build-structure --trace sound.jsonl --report sound.report.json -o sound.json
    for name in bridged sound; do
        sed -n 's/.*"sample":[0-9]*,"parent":\([0-9]*\),.*/\1/p' $name.jsonl | sort -n | uniq -d > $name.splits
    done
    [ "$(wc -l < bridged.splits)" -eq 3 ]
    [ "$(wc -l < sound.splits)" -eq 2 ]
    [ "$(figure branches bridged.report.json)" -eq 7 ]
    [ "$(figure branches sound.report.json)" -eq 5 ]
    grep "\"sample\":$(tail -n 1 bridged.splits)," bridged.jsonl |
        awk -F '"z":' -v height="$height" '{ exit !($2 - height < 0.01 && height - $2 < 0.01) }'
}

@test "without the bridge's triangles the biceps is sound again" {
    awk '{ line[NR] = $0 } END { for (i = 1; i < NR - 6; i++) print line[i] }' bridged.obj > cured.obj
    mesh-clean cured.obj -o cured.json --report cured.report.json
    [ "$(figure holesFilled cured.report.json)" -eq 2 ]
    root-select cured.json 2> warned | build-structure --report structure.report.json -o cured.json 2>> warned
    [ "$(figure branches structure.report.json)" -eq 5 ]
    refute grep -q genus warned
}
