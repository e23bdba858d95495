# simulate --muscle and --freeze-others: one muscle of many, the others as an earlier run has them.

bats_require_minimum_version 1.5.0

refute() { if "$@"; then echo "held: $*"; return 1; fi; }

# The sample arm, its muscles tied to each other in tied.scene.json, and a run of all of them in all/, all.jsonl.
setup_file() {
    sh "$BATS_TEST_DIRNAME/../sample-folder" "$BIN" "$EXAMPLES" "$BATS_FILE_TMPDIR/arm"
    cd "$BATS_FILE_TMPDIR/arm" || exit 1
    mkdir glued
    for m in biceps brachialis triceps; do
        local others=() o
        for o in biceps brachialis triceps; do [ $o = $m ] || others+=(--glue $o=$o.muscle.json); done
        "$BIN/attach-detect" -q $m.muscle.json "${others[@]}" --reach 12mm -o glued/$m.muscle.json
    done
    python3 - <<'END'
import json
s = json.load(open("arm.scene.json"))
for m in s["muscles"]: m["rig"] = "glued/" + m["rig"]
s["externals"] = True
json.dump(s, open("tied.scene.json", "w"))
END
    "$BIN/simulate" -q tied.scene.json --frames 0:30 --iterations 40 -o all --log all.jsonl
}

setup() {
    cp -r "$BATS_FILE_TMPDIR/arm" "$BATS_TEST_TMPDIR/arm"
    cd "$BATS_TEST_TMPDIR/arm" || exit 1
}

# apart A B: the greatest distance of two caches' points in any frame, over the muscle's size
apart() {
    python3 - "$1" "$2" <<'END'
import math, struct, sys
def read(path):
    b = open(path, "rb").read()
    n, _, _, frames = struct.unpack("<iffi", b[16:32])
    return n, [struct.unpack("<%df" % (3 * n), b[32 + 12 * n * i:32 + 12 * n * (i + 1)]) for i in range(frames)]
(n, a), (m, b) = read(sys.argv[1]), read(sys.argv[2])
assert n == m and len(a) == len(b), (n, m, len(a), len(b))
size = math.dist([min(a[0][k::3]) for k in range(3)], [max(a[0][k::3]) for k in range(3)])
print(max(math.dist(p[3 * i:3 * i + 3], q[3 * i:3 * i + 3]) for p, q in zip(a, b) for i in range(n)) / size)
END
}

below() { awk -v x="$1" -v y="$2" 'BEGIN { exit !(x < y) }'; }

lines_of() { grep "\"muscle\":\"$1\"" "$2"; }

@test "what is tied to nothing is run alone, to the same bytes; the plan says why the others are left out" {
    "$BIN/simulate" -q arm.scene.json --frames 0:10 -o a/ --log a.jsonl
    "$BIN/simulate" -q arm.scene.json --frames 0:10 --muscle 'b?ceps' -o b/ --log b.jsonl
    [ "$(ls b)" = biceps.pc2 ]
    cmp a/biceps.pc2 b/biceps.pc2
    cmp <(lines_of biceps a.jsonl) b.jsonl
    "$BIN/simulate" arm.scene.json -v --muscle biceps --plan > plan.json 2> err
    grep -q '0 other muscles are tied' err
    python3 -c 'import json
muscles = {m["name"]: m.get("leftOut") for m in json.load(open("plan.json"))["plan"]["muscles"]}
assert muscles["biceps"] is None and all("--muscle" in muscles[m] for m in muscles if m != "biceps") and len(muscles) == 3, muscles'
    "$BIN/simulate" -q arm.scene.json --frames 0:10 --muscle biceps -o one.pc2 --log b.jsonl
    cmp one.pc2 b/biceps.pc2
}

@test "what is tied to it is stepped too, and neither logged nor written" {
    "$BIN/simulate" -q tied.scene.json --frames 0:30 --iterations 40 --muscle biceps -o b/ --log b.jsonl
    [ "$(ls b)" = biceps.pc2 ]
    cmp all/biceps.pc2 b/biceps.pc2
    cmp <(lines_of biceps all.jsonl) b.jsonl
    "$BIN/simulate" -q tied.scene.json --frames 0:1 --muscle biceps --lengths l.tsv --log b.jsonl
    grep -q 'biceps\.1' l.tsv
    refute grep -q 'brachialis' l.tsv
}

@test "among frozen others a muscle goes as it did among them" {
    for m in biceps brachialis triceps; do
        "$BIN/simulate" -q tied.scene.json --frames 0:30 --iterations 40 --muscle $m --freeze-others all -o one/ --log one.jsonl
        apart all/$m.pc2 one/$m.pc2
        below "$(apart all/$m.pc2 one/$m.pc2)" 1e-3
        [ "$(wc -l < one.jsonl)" -eq 31 ]
        refute grep -v "\"muscle\":\"$m\"" one.jsonl
    done
    # it is held by them: without, it goes elsewhere
    "$BIN/simulate" -q tied.scene.json --frames 0:30 --iterations 40 --no-externals --muscle brachialis -o loose/ --log l.jsonl
    refute below "$(apart all/brachialis.pc2 loose/brachialis.pc2)" 3e-3
}

@test "frozen others may be sequences of meshes, and their folder that of the frames" {
    "$BIN/simulate" -q tied.scene.json --frames 0:6 --format ply -o meshes --log l.jsonl
    "$BIN/simulate" -q tied.scene.json --frames 0:6 -o caches --log l.jsonl
    "$BIN/simulate" -q tied.scene.json --frames 0:6 --muscle biceps --freeze-others meshes -o a/ --log a.jsonl
    "$BIN/simulate" -q tied.scene.json --frames 0:6 --muscle biceps --freeze-others caches -o b/ --log b.jsonl
    below "$(apart a/biceps.pc2 b/biceps.pc2)" 1e-5
    cp meshes/brachialis.*.ply caches
    "$BIN/simulate" tied.scene.json --frames 0:6 --muscle biceps --freeze-others caches -o c/ 2>&1 > log | grep -q 'has a cache and a sequence of "brachialis"; the cache is taken'
    rm caches/*.ply
    cp -r caches own
    "$BIN/simulate" -q tied.scene.json --frames 0:6 --muscle biceps --freeze-others own -o own --log c.jsonl
    cmp own/biceps.pc2 b/biceps.pc2
    cmp own/triceps.pc2 caches/triceps.pc2
}

@test "threads, and a run that stops and goes on, give the same bytes; another choice of muscles is not gone on with" {
    run_one() { "$BIN/simulate" -q tied.scene.json --muscle biceps --freeze-others all "$@"; }
    run_one --frames 0:12 -o a/ --log a.jsonl --threads 1
    run_one --frames 0:12 -o b/ --log b.jsonl --threads 4 --state s.state --stop-after 5
    run_one --frames 6:12 -o b/ --log b.jsonl --from s.state
    cmp a/biceps.pc2 b/biceps.pc2
    cmp a.jsonl b.jsonl
    run -1 "$BIN/simulate" -q tied.scene.json --frames 6:12 --muscle biceps -o c/ --from s.state
    [[ $output == *"this state is another scene's"* ]]
}

@test "names that match nothing, folders that lack a muscle, frames that do not fit or do not reach are told" {
    run -2 "$BIN/simulate" tied.scene.json --muscle bicep
    [[ $output == *'--muscle bicep: no muscle of the scene has such a name'* ]]
    run -2 "$BIN/simulate" tied.scene.json --freeze-others all
    [[ $output == *'--freeze-others needs --muscle NAME'* ]]
    run -2 "$BIN/simulate" tied.scene.json --muscle biceps --freeze-others nowhere
    [[ $output == *'write the folder of an earlier run'* ]]
    run -1 "$BIN/simulate" -q tied.scene.json --frames 0:40 --muscle biceps --freeze-others all -o a/
    [[ $output == *'its frames are from 0 s to 1.25 s, the run from 0 s to 1.66667 s'* ]]
    cp all/biceps.pc2 all/brachialis.pc2
    run -1 "$BIN/simulate" -q tied.scene.json --frames 0:30 --muscle biceps --freeze-others all -o a/
    [[ $output == *'all/brachialis.pc2: has '*' points, but the mesh that it moves has '*' vertices'* ]]
    rm all/brachialis.pc2
    run -1 "$BIN/simulate" -q tied.scene.json --frames 0:30 --muscle biceps --freeze-others all -o a/
    [[ $output == *'all: has no frames of the muscle "brachialis"'* ]]
    # frames of another rate lie where the bones were at another time
    cp -r "$BATS_FILE_TMPDIR/arm/all" again
    run -1 "$BIN/simulate" -q tied.scene.json --rate 48 --frames 0:30 --muscle biceps --freeze-others again -o a/
    [[ $output == *'attached vertices '*' mm from where its bones take them; they are of another motion, rate or unit'* ]]
    "$BIN/simulate" tied.scene.json --frames 0:1 --no-externals --muscle biceps --freeze-others again -o a/ 2>&1 > log | grep -q 'freeze-others has no effect'
    python3 -c 'import json
s = json.load(open("tied.scene.json")); s["muscles"][0]["enabled"] = False; off = s["muscles"][0]["name"]
json.dump(s, open("off.scene.json", "w")); open("name", "w").write(off)'
    run -2 "$BIN/simulate" off.scene.json --muscle "$(cat name)"
    [[ $output == *'does not enable it'* ]]
}

@test "rig-view draws one muscle of a scene, and needs no frames of the others" {
    "$BIN/simulate" -q tied.scene.json --frames 0:6 --muscle biceps -o b/ --log b.jsonl --state b.state
    run -1 "$BIN/rig-view" -q tied.scene.json --frames b --frame 6 -o a.png
    "$BIN/rig-view" -q tied.scene.json --muscle biceps --frames b --frame 6 -o a.png
    "$BIN/rig-view" -q tied.scene.json --muscle biceps --state b.state -o s.png
    run -2 "$BIN/rig-view" -q tied.scene.json --muscle nobody -o a.png
    [[ $output == *'--muscle nobody'* ]]
}
