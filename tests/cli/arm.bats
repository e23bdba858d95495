# The sample arm: its meshes, its rigs built by make and by pipes, its simulation.

bats_require_minimum_version 1.5.0

setup_file() {
    export ARM="$EXAMPLES/arm/arm" HERE="$BATS_TEST_DIRNAME/../../share/examples/arm" SAMPLE="$BATS_FILE_TMPDIR/sample"
    "$ARM" --out "$SAMPLE" --triangles 1000 --dirty
    for triangles in 4000 20000; do "$ARM" --out "$BATS_FILE_TMPDIR/$triangles" --triangles $triangles; done
    mkdir "$BATS_FILE_TMPDIR/1000" && cp "$SAMPLE"/*.ply "$BATS_FILE_TMPDIR/1000"
    make -s -C "$SAMPLE" -f "$HERE/Makefile" TOOLS="$BIN"
}

setup() { cd "$BATS_TEST_TMPDIR" || exit 1; }

faces() { head -n 12 "$1" | LC_ALL=C sed -n 's/^element face //p'; }

# value REPORT PATH...: one number of a report
value() { python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); [d := d[k] for k in sys.argv[2:]]; print(d)' "$@"; }

bones_of() { python3 -c 'import json, sys; print(*sorted(a["bone"] for a in json.load(open(sys.argv[1]))["attachments"]))' "$1"; }

@test "every surface is closed, manifold, outward, of genus 0, without self-intersections or slivers from 1k to 20k triangles" {
    for mesh in "$BATS_FILE_TMPDIR"/[0-9]*/*.ply; do
        "$BIN/mesh-clean" --check --self-intersections "$mesh" --report "$(echo "$mesh" | tr / _).report.json"
    done
    python3 - ./*.report.json <<'END'
import json, sys
assert len(sys.argv) == 1 + 3 * 7
for path in sys.argv[1:]:
    mesh = json.load(open(path))["before"]
    found = {name: mesh[name] for name in ("genus", "components", "selfIntersections")}
    assert found == {"genus": 0, "components": 1, "selfIntersections": 0} and mesh["worstQuality"] > 0.5, (path, found)
END
}

@test "the biceps has about the triangles asked for, and other muscles scale with it" {
    for triangles in 1000 4000 20000; do
        folder=$BATS_FILE_TMPDIR/$triangles
        count=$(faces "$folder/biceps.ply")
        [ "$count" -gt $((triangles * 95 / 100)) ] && [ "$count" -lt $((triangles * 107 / 100)) ]
        [ "$(faces "$folder/triceps.ply")" -gt $((triangles / 2)) ]
    done
}

@test "--resolution is the edge length" {
    "$ARM" --out . --resolution 3mm
    "$BIN/mesh-clean" --check biceps.ply --report report.json
    python3 -c 'import sys; sys.exit(not 2.7e-3 < float(sys.argv[1]) < 3.3e-3)' "$(value report.json before edgeMean)"
}

@test "the same options give the same bytes" {
    "$ARM" --out again --triangles 1000 --dirty
    for file in again/*; do cmp "$file" "$SAMPLE/${file#again/}"; done
}

@test "wrong usage: status 2 and one line; a folder that cannot be made: status 1" {
    for words in "" "--out" "--out x extra" "--out x --triangles 10" "--out x --resolution 3parsec" "--out x --resolution 1m" "--no-such"; do
        run -2 "$ARM" $words
        [ "${#lines[@]}" -eq 1 ]
    done
    [ ! -e x ]
    : > file
    run -1 "$ARM" --out file/below
    [[ "$output" == *"file/below"* ]]
}

@test "pipes give the bytes of the Makefile's files, and so does a second run" {
    mkdir piped again
    TOOLS="$BIN" "$HERE/pipeline.sh" "$SAMPLE" piped
    cp "$SAMPLE"/*.ply again
    make -s -C again -f "$HERE/Makefile" TOOLS="$BIN"
    for muscle in biceps brachialis triceps; do
        cmp "$SAMPLE/$muscle.muscle.json" piped/$muscle.muscle.json
        cmp "$SAMPLE/$muscle.muscle.json" again/$muscle.muscle.json
    done
}

@test "one thread and two give the same rig and the same frames" {
    cd "$SAMPLE"
    bones="--bone scapula=scapula.ply --bone humerus=humerus.ply --bone ulna=ulna.ply --bone radius=radius.ply"
    cp "$HERE/arm.scene.json" .
    for threads in 1 2; do
        "$BIN/attach-detect" biceps.clean.json $bones --threads $threads -o "$BATS_TEST_TMPDIR/$threads.json"
        mkdir "$BATS_TEST_TMPDIR/$threads"
        "$BIN/simulate" arm.scene.json --frames 0:2 --threads $threads -o "$BATS_TEST_TMPDIR/$threads" > "$BATS_TEST_TMPDIR/$threads/log"
    done
    cmp "$BATS_TEST_TMPDIR/1.json" "$BATS_TEST_TMPDIR/2.json"
    cmp biceps.attached.json "$BATS_TEST_TMPDIR/1.json"
    diff -r "$BATS_TEST_TMPDIR/1" "$BATS_TEST_TMPDIR/2"
}

@test "muscles are attached to their bones and to no other" {
    [ "$(bones_of "$SAMPLE/biceps.muscle.json")" = "radius scapula" ]
    [ "$(bones_of "$SAMPLE/brachialis.muscle.json")" = "humerus ulna" ]
    [ "$(bones_of "$SAMPLE/triceps.muscle.json")" = "humerus scapula ulna" ]
}

@test "the tree of the biceps has three leaves at any resolution: two heads, one distal tendon" {
    for triangles in 1000 4000 20000; do
        "$BIN/mesh-clean" "$BATS_FILE_TMPDIR/$triangles/biceps.ply" | "$BIN/root-select" | "$BIN/build-structure" -o biceps.json --report report.json
        [ "$(value report.json leaves)" = 3 ]
    done
}

@test "the dirty copy is repaired: closed, and its volume within 1 % of the clean one's" {
    "$BIN/mesh-clean" "$SAMPLE/biceps-dirty.obj" -o repaired.ply --report dirty.json
    "$BIN/mesh-clean" --check repaired.ply
    "$BIN/mesh-clean" --check "$SAMPLE/biceps.ply" --report clean.json
    run -3 "$BIN/mesh-clean" --check "$SAMPLE/biceps-dirty.obj"
    [ "$(value dirty.json before closed)" = False ]
    [ "$(value dirty.json after closed)" = True ]
    [ "$(value dirty.json after genus)" = 0 ]
    python3 -c 'import sys; a, b = map(float, sys.argv[1:]); sys.exit(not abs(a - b) < 0.01 * b)' \
        "$(value dirty.json after volume)" "$(value clean.json before volume)"
}

@test "the elbow bends: volumes stay within 1 % of the goal, nothing is NaN, attached vertices lie where their bones are" {
    cd "$SAMPLE"
    cp "$HERE/arm.scene.json" .
    "$BIN/simulate" arm.scene.json -o "$BATS_TEST_TMPDIR/frames" --fail-on 'volume>0.01,nan>0,triangle<0.01' > "$BATS_TEST_TMPDIR/arm.jsonl"
    [ "$(wc -l < "$BATS_TEST_TMPDIR/arm.jsonl")" -eq $((3 * 61)) ]
    python3 - "$BATS_TEST_TMPDIR/frames" <<'END'
import json, math, struct, sys
angle = math.radians(120)  # of the last frame
def turned(p): return p[0] * math.cos(angle) - p[2] * math.sin(angle), p[1], p[0] * math.sin(angle) + p[2] * math.cos(angle)
for muscle in "biceps", "brachialis", "triceps":
    document = json.load(open(muscle + ".muscle.json"))
    rest = document["mesh"]["vertices"]
    data = open(f"{sys.argv[1]}/{muscle}.pc2", "rb").read()
    points, samples = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
    assert (points, samples) == (len(rest) // 3, 61)
    last = struct.unpack(f"<{3 * points}f", data[32 + 12 * points * 60:])
    for attachment in document["attachments"]:
        for v in attachment["vertices"]:
            p = rest[3 * v:3 * v + 3]
            goal = turned(p) if attachment["bone"] in ("ulna", "radius") else p
            assert math.dist(goal, last[3 * v:3 * v + 3]) < 1e-6, (muscle, v)
END
}

@test "the demo leaves documents, frames, a log and pictures, and says what was measured" {
    TRIANGLES=1000 "$HERE/demo.sh" "$BIN" "$EXAMPLES" demo > out
    for tool in arm mesh-clean root-select build-structure fiber-flow attach-detect simulate motion-import motion-sense scene-build rig-view; do
        grep -q "^  $tool  *[0-9][0-9.]* s" out
    done
    [ "$(grep -c "^  simulate " out)" -eq 2 ]
    [ "$(grep -c "^  worst volume error  *0\.[0-9]* %" out)" -eq 2 ]
    for file in biceps.muscle.json frames/biceps.pc2 arm.jsonl arm.png arm.motion.png biceps.stages.png; do [ -s "demo/$file" ]; done
    for file in curl.bvh curl.motion.json curl.activation.json curl.scene.json curl-frames/triceps.pc2 curl.jsonl curl.png curl.sensors.png; do
        [ -s "demo/$file" ]
    done
}

@test "the curl: elbow and activations are those that its curves and sensors say, at any rate of the recording" {
    cp -r "$SAMPLE" curl
    cd curl
    make -s -f "$HERE/Makefile" TOOLS="$BIN" curl
    [ "$(wc -l < curl.jsonl)" -eq $((3 * 73)) ]
    python3 - <<'END'
import json, math, struct
def jerk(s): s = min(max(s, 0), 1); return s**3 * (10 - 15 * s + 6 * s * s)
def degrees(t): return 120 * jerk((t - 0.25) / 1.25) - 115 * jerk((t - 1.75) / 0.75)
# activations in the log against the readings that the curl has by its formula: at its quickest, held, let down, at rest again
log = {(line["frame"], line["muscle"]): line["activation"] for line in map(json.loads, open("curl.jsonl"))}
fastest = 120 / 1.25 * 1.875  # degrees/s of minimum jerk, at 0.875 s
wanted = {(0, "biceps"): 0.05, (0, "triceps"): 0.5, (21, "biceps"): 0.9 * fastest / 200, (40, "brachialis"): 0.6, (40, "triceps"): 0, (54, "triceps"): 0.6,
          (72, "biceps"): 0.05}
for key, value in wanted.items(): assert abs(log[key] - value) < 2e-3, (key, log[key], value)
# the brake fires once, where the elbow passes 150 degrees/s on its way down
fired = [s["fired"] for s in json.load(open("curl.activation.report.json"))["sensors"] if "fired" in s]
share = (1 - math.sqrt(1 - 4 * math.sqrt(150 * 0.75 / (115 * 30)))) / 2
assert len(fired) == 1 and len(fired[0]) == 1 and abs(fired[0][0] - (1.75 + 0.75 * share)) < 5e-3, (fired, share)
# attached vertices lie where the recording has their bones; between its samples it goes straight
document = json.load(open("biceps.muscle.json"))
rest, data = document["mesh"]["vertices"], open("curl-frames/biceps.pc2", "rb").read()
points = struct.unpack("<i", data[16:20])[0]
for frame in 21, 40, 50, 72:
    a, count = math.radians(degrees(frame / 24)), 0
    now = struct.unpack(f"<{3 * points}f", data[32 + 12 * points * frame:32 + 12 * points * (frame + 1)])
    for attachment in document["attachments"]:
        for v in attachment["vertices"] if attachment["bone"] == "radius" else ():
            x, y, z = rest[3 * v:3 * v + 3]
            goal = x * math.cos(a) - z * math.sin(a), y, x * math.sin(a) + z * math.cos(a)
            count += 1
            assert math.dist(goal, now[3 * v:3 * v + 3]) < 5e-5, (frame, v, math.dist(goal, now[3 * v:3 * v + 3]))
    assert count > 3
END
    awk -f "$HERE/curl.awk" -v rate=240 > fine.bvh
    "$BIN/motion-sense" --sensors "$HERE/curl.sensors.json" --rate 24 fine.bvh -o fine.tsv
    "$BIN/motion-sense" --sensors "$HERE/curl.sensors.json" --rate 24 curl.motion.json -o coarse.tsv
    paste fine.tsv coarse.tsv | awk '{ for (i = 2; i <= 4; i++) { d = $i - $(i + 4); if (d < 0) d = -d; if (d > most) most = d } }
        END { if (NR != 74 || most > 0.005) { print NR, most; exit 1 } }'
    run -2 awk -f "$HERE/curl.awk" -v rate=-1
}

@test "motion and sensors of the example keep to their schemas" {
    python3 - "$HERE" <<'END'
import json, jsonschema, sys
for kind in "sensors", "motion", "scene":
    name = {"sensors": "curl", "motion": "bend", "scene": "arm"}[kind]
    jsonschema.validate(json.load(open(f"{sys.argv[1]}/{name}.{kind}.json")), json.load(open(f"{sys.argv[1]}/../../schema/{kind}.schema.json")))
END
}

@test "a run that strays from the goal volume fails the demo's summary" {
    echo '{"frame":1,"muscle":"m","volume_error":-0.02,"errors":{},"smallest_triangle":1,"nan":0}' > bad.jsonl
    run -1 awk -f "$HERE/worst.awk" bad.jsonl
    run -1 awk -f "$HERE/worst.awk" /dev/null
}
