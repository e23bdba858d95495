# error-time: table, report, chart; errors against an independent computation; refusals; what simulate chooses. And the moving-tip problem.

bats_require_minimum_version 1.5.0

# a && b and ! a do not end a test under bats: state every condition by itself, and what must not hold with `refute`
refute() { if "$@"; then echo "held: $*"; return 1; fi; }

schema=$BATS_TEST_DIRNAME/../../share/schema

# The moving tip with 150 triangles, 8 frames of it measured once; and the same muscle twice in one scene.
setup_file() {
    cd "$BATS_FILE_TMPDIR" || exit 1
    "$EXAMPLES/tip/tip" --triangles 150 tip
    printf '# few\nxpbd substeps=16 iterations=1\n\nqn iterations=4\nqn iterations=4 substeps=4\nqn substeps=3\n' > settings.txt
    "$BIN/error-time" -q tip/tip.scene.json --frames 0:8 --settings settings.txt --runs 2 --reference 16 -o measured
    python3 -c 'import json
s = json.load(open("tip/tip.scene.json"))
s["frames"] = [0, 4]
s["muscles"] = [dict(s["muscles"][0], name=n) for n in ("left", "right")]
s["muscles"][1]["stiffness"] = {"relaxed": 2000, "active": 2000}
json.dump(s, open("tip/two.scene.json", "w"))'
}

setup() {
    cp -r "$BATS_FILE_TMPDIR/tip" "$BATS_FILE_TMPDIR/settings.txt" "$BATS_FILE_TMPDIR/measured" "$BATS_TEST_TMPDIR"
    cd "$BATS_TEST_TMPDIR" || exit 1
    PATH=$BIN:$PATH
}

@test "a folder gets table, report, data and chart, and they agree" {
    [ "$(ls measured | tr '\n' ' ')" = "error-time.dat error-time.json error-time.png error-time.svg error-time.tsv " ]
    python3 - "$schema/error-time.schema.json" <<'END'
import csv, json, jsonschema, sys
report = json.load(open("measured/error-time.json"))
jsonschema.validate(report, json.load(open(sys.argv[1])))
rows = list(csv.DictReader(open("measured/error-time.tsv"), delimiter="\t"))
texts = ["xpbd substeps=16 iterations=1", "qn iterations=4", "qn substeps=4 iterations=4", "qn substeps=3"]
assert [r["setting"] for r in rows] == texts == [s["setting"] for s in report["settings"]]
for row, setting in zip(rows, report["settings"]):
    point, = setting["points"]
    for key, name in (("total_error", "error"), ("scene_error", "sceneError"), ("farthest_error", "farthestError"), ("cpu_s", "cpuSeconds")):
        assert abs(float(row[key]) - point[name]) <= 1e-3 * point[name]
    assert setting["runs"] == 2 and point["error"] <= point["farthestError"] and setting["muscleErrors"] == [point["error"]]
    assert point["claimed"] == (point["error"] >= 10 * report["reference"]["floor"])
    assert (row["verdict"] == "front") == point["front"] and (row["verdict"] == "floor") == (not point["claimed"])
    assert (point["solverError"] is None) == setting["setting"].startswith("xpbd")
front = [p for s in report["settings"] for p in s["points"] if p["front"]]
assert len(report["front"]) == len(front)
for p in (p for s in report["settings"] for p in s["points"] if p["claimed"]):
    floor = report["reference"]["floor"]
    assert p["front"] == (not any(q is not p and q["error"] + (0 if q["claimed"] else floor) <= p["error"] and q["cpuSeconds"] <= p["cpuSeconds"]
                                  for s in report["settings"] for q in s["points"]))
assert report["moments"] == [2, 4, 6, 8]
assert [r["substeps"] for r in report["reference"]["rungs"]] == [1, 2, 4, 8, 16, 3]
END
    [ "$(head -c 8 measured/error-time.png | od -An -c | tr -d ' ')" = '211PNG\r\n032\n' ]
    grep -q "Pareto front" measured/error-time.svg
    python3 -c 'import xml.dom.minidom; xml.dom.minidom.parse("measured/error-time.svg")'
}

@test "errors are those of simulate's frames, weighted by the areas around the vertices" {
    for setting in "16 xpbd 16 1" "q8 qn 8 2000" "q16 qn 16 2000"; do
        set -- $setting
        simulate tip/tip.scene.json --frames 0:8 --solver "$2" --substeps "$3" --iterations "$4" $([ "$2" = qn ] && echo --tolerance 1e-9) \
            -o "$1.pc2" --log log.jsonl
    done
    python3 - <<'END'
import json, math, struct
muscle = json.load(open("tip/fusiform.muscle.json"))
v = muscle["mesh"]["vertices"]
points = [v[i:i + 3] for i in range(0, len(v), 3)]
t = muscle["mesh"]["triangles"]
mass = [0.0] * len(points)
for a, b, c in (t[i:i + 3] for i in range(0, len(t), 3)):
    u = [points[b][k] - points[a][k] for k in range(3)]
    w = [points[c][k] - points[a][k] for k in range(3)]
    area = math.dist((0, 0, 0), (u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]))
    for i in (a, b, c): mass[i] += area
for attachment in muscle["attachments"]:
    for i in attachment["vertices"]: mass[i] = 0.0
L = math.dist([min(p[k] for p in points) for k in range(3)], [max(p[k] for p in points) for k in range(3)])
def frames(name):
    data = open(name, "rb").read()
    count = struct.unpack("<12siiffi", data[:32])[2]
    return [struct.unpack("<%df" % (3 * count), data[32 + 12 * count * f:32 + 12 * count * (f + 1)]) for f in range(9)]
x, coarse, fine = frames("16.pc2"), frames("q8.pc2"), frames("q16.pc2")
report = json.load(open("measured/error-time.json"))
e = m = 0.0
for f in (2, 4, 6, 8):
    r = [2 * b - a for a, b in zip(coarse[f], fine[f])] if report["reference"]["extrapolated"] else fine[f]
    for i, w in enumerate(mass):
        e += w * sum((x[f][3 * i + k] - r[3 * i + k]) ** 2 for k in range(3))
        m += w
found = report["settings"][0]["points"][0]["error"]
assert abs(math.sqrt(e / m) / L - found) < 1e-3 * found, (math.sqrt(e / m) / L, found)
def strain(track):
    most = 0.0
    for f in range(1, 9):
        at = [track[f][i:i + 3] for i in range(0, len(v), 3)]
        for k in range(0, len(t), 3):
            for a, b in ((t[k], t[k + 1]), (t[k + 1], t[k + 2]), (t[k + 2], t[k])):
                most = max(most, abs(math.dist(at[a], at[b]) / math.dist(points[a], points[b]) - 1))
    return most
settings = report["settings"]
assert settings[0]["solvedStrain"] is None
assert abs(settings[0]["largestStrain"] - strain(x)) < 1e-4, (settings[0]["largestStrain"], strain(x))
rungs = {r["substeps"]: r["largestStrain"] for r in report["reference"]["rungs"]}
assert abs(rungs[8] - strain(coarse)) < 1e-4 and abs(rungs[16] - strain(fine)) < 1e-4, (rungs, strain(coarse), strain(fine))
assert [s["solvedStrain"] for s in settings[1:]] == [rungs[1], rungs[4], rungs[3]]
END
}

@test "without -o the table goes to standard output; errors are the same again, and on any number of threads" {
    cd tip
    error-time two.scene.json --settings ../settings.txt --runs 1 --reference 4 --floor 1 > ../once.tsv
    error-time --settings ../settings.txt --runs 1 --reference 4 --floor 1 --threads 2 < two.scene.json > ../again.tsv
    cd ..
    [ "$(wc -l < once.tsv)" -eq 5 ]
    cut -f1-7 once.tsv > a # the others depend on times
    cut -f1-7 again.tsv > b
    cmp a b
    awk -F '\t' 'NR > 1 { if (!($4 >= $5 && $6 >= $4)) exit 1 }' once.tsv # the worst muscle, the scene, the farthest point
}

@test "--static: converged solvers come to rest at the equilibrium, and the hold ends there" {
    printf 'xpbd substeps=16 iterations=1\nqn tolerance=1e-9\n' > two.txt
    error-time -q tip/tip.scene.json --frames 0:4 --static --settings two.txt --runs 1 --hold 64 -o rest
    python3 - "$schema/error-time.schema.json" <<'END'
import json, jsonschema, sys
report = json.load(open("rest/error-time.json"))
jsonschema.validate(report, json.load(open(sys.argv[1])))
assert report["errors"] == "equilibrium" and report["reference"]["floor"] < 1e-6
xpbd, qn = (s["points"] for s in report["settings"])
assert [p["held"] for p in xpbd] == [0, 1, 2, 4, 8, 16, 32, 64]
assert [p["held"] for p in qn[:-1]] == [0, 1, 2, 4, 8, 16, 32, 64][:len(qn) - 1] and qn[-1]["held"] <= 64
assert qn[-1]["error"] < 1e-5 < 1e-4 < xpbd[-1]["error"] < qn[0]["error"] * 2
assert all(a["cpuSeconds"] <= b["cpuSeconds"] for a, b in zip(qn, qn[1:])) # of one run: the time up to each moment
END
}

@test "without gnuplot: everything but the chart, a clear word, status 3" {
    code=0
    PATH=$BIN error-time tip/tip.scene.json --frames 0:2 --settings settings.txt --runs 1 --reference 4 --floor 1 -o bare 2> err || code=$?
    [ "$code" -eq 3 ]
    grep -q "no chart: gnuplot is not installed" err
    [ "$(ls bare | tr '\n' ' ')" = "error-time.dat error-time.json error-time.tsv " ]
}

@test "a setting that takes too long is ended, warned of, and has no error" {
    printf 'xpbd substeps=100000 iterations=1\nqn\n' > slow.txt
    # a frame of the first takes some thousand times as long as one of the other, 1 s or so to 1 ms: the limit lies far from both
    error-time tip/tip.scene.json --frames 0:2 --settings slow.txt --runs 1 --most-seconds 0.05 --reference 4 --floor 1 > table.tsv 2> err
    grep -q "xpbd substeps=100000 iterations=1: not done after 0.05 s" err
    [ "$(awk -F '\t' 'NR == 2 { print $4, $NF }' table.tsv)" = "nan failed" ]
    [ "$(awk -F '\t' 'NR == 3 { print ($4 < 0.1), $12, ($NF != "failed") }' table.tsv)" = "1 1 1" ]
}

@test "bad settings, scenes and requests: one sentence, nothing written" {
    refused() { # STATUS WORD ARGUMENT...
        status=$1 word=$2 code=0
        shift 2
        error-time "$@" -o out > stdout 2> err || code=$?
        [ "$code" -eq "$status" ] || { echo "$*: $code"; cat err; return 1; }
        [ "$(wc -l < err)" -eq 1 ]
        grep -q -e "$word" err || { cat err; return 1; }
        [ ! -s stdout ]
        [ ! -e out ]
    }
    printf 'qn\n\nqn speed=3\n' > bad.txt
    : > empty.txt
    refused 1 'bad.txt:3: qn has no "speed"; it has substeps' tip/tip.scene.json --settings bad.txt
    refused 1 'empty.txt: there is no setting' tip/tip.scene.json --settings empty.txt
    refused 1 'none.txt' tip/tip.scene.json --settings none.txt
    refused 1 'one frame' tip/tip.scene.json --frames 3:3
    refused 1 'no-scene.json' no-scene.json
    refused 2 'write A:B' tip/tip.scene.json --frames 5:3
    refused 2 'write A:B' tip/tip.scene.json --frames 5
    refused 2 'exclude each other' tip/tip.scene.json --settings settings.txt --sweep full
    refused 2 'runs' tip/tip.scene.json --runs 0
    python3 -c 'import json
s = json.load(open("tip/tip.scene.json")); s["muscles"][0]["enabled"] = False; json.dump(s, open("tip/none.scene.json", "w"))'
    refused 1 'no muscle that is enabled' tip/none.scene.json
    run -1 sh -c "error-time tip/tip.scene.json --frames 0:2 --settings settings.txt --runs 1 --reference 4 --floor 1 > /dev/full"
    run -1 error-time tip/tip.scene.json --frames 0:2 --settings settings.txt -o tip/tip.scene.json/folder
}

@test "simulate takes the cheapest setting that reaches an error, as options would" {
    best=$(python3 -c 'import json
r = json.load(open("measured/error-time.json"))
ok = [(p["cpuSeconds"], s["setting"]) for s in r["settings"] for p in s["points"] if p["error"] + r["reference"]["floor"] <= 3e-3]
print(min(ok)[1])')
    simulate -v tip/tip.scene.json --frames 0:8 --target-error 3e-3 --choose measured/error-time.json > chosen.jsonl 2> err
    grep -q "chosen for an error of 0.003: $best:" err
    method=${best%% *} words=
    for item in ${best#"$method"}; do words="$words --${item%%=*} ${item#*=}"; done
    simulate tip/tip.scene.json --frames 0:8 --solver "$method" $words > plain.jsonl
    cmp chosen.jsonl plain.jsonl
}

@test "simulate refuses what a report cannot give" {
    refused() { # STATUS WORD ARGUMENT...
        status=$1 word=$2 code=0
        shift 2
        simulate "$@" > stdout 2> err || code=$?
        [ "$code" -eq "$status" ]
        grep -q -e "$word" err || { cat err; return 1; }
        [ ! -s stdout ]
    }
    report=measured/error-time.json
    refused 1 "no setting reaches an error of 1e-09" tip/tip.scene.json --target-error 1e-9 --choose $report
    refused 1 "another scene" tip/two.scene.json --target-error 1e-2 --choose $report
    "$EXAMPLES/tip/tip" --triangles 200 other
    refused 1 "another scene" other/tip.scene.json --target-error 1e-2 --choose $report
    refused 2 "go together" tip/tip.scene.json --choose $report
    refused 2 "go together" tip/tip.scene.json --target-error 1e-2
    refused 2 "exclude each other" tip/tip.scene.json --target-error 1e-2 --choose $report --substeps 3
    refused 1 "tip.scene.json.*format" tip/tip.scene.json --target-error 1e-2 --choose tip/tip.scene.json
    sed 's/"setting": "qn iterations=4"/"setting": "qn warp=4"/' $report > later.json
    refused 1 'later.json.*settings\[1\].setting: qn has no "warp"' tip/tip.scene.json --target-error 1e-2 --choose later.json
    refused 1 "none.json" tip/tip.scene.json --target-error 1e-2 --choose none.json
    sed 's/"rate": 24/"rate":  24/' tip/tip.scene.json > tip/changed.scene.json
    simulate tip/changed.scene.json --frames 0:1 --target-error 1e-2 --choose $report > log.jsonl 2> err
    grep -q "warning: the scene has changed" err
}

@test "the moving tip: sizes, arc, variants, the same bytes again" {
    for size in 1000 4000 17000; do
        "$EXAMPLES/tip/tip" --triangles $size sized
        python3 -c 'import json, sys
n = len(json.load(open("sized/fusiform.muscle.json"))["mesh"]["triangles"]) / 3
assert abs(n / int(sys.argv[1]) - 1) < 0.03, n' $size
    done
    "$EXAMPLES/tip/tip" --triangles 150 again
    for file in fusiform.muscle.json lower.ply upper.ply tip.scene.json; do cmp tip/$file again/$file; done
    "$EXAMPLES/tip/tip" --triangles 150 --static still
    "$EXAMPLES/tip/tip" --triangles 150 --fast fast
    "$EXAMPLES/tip/tip" --triangles 150 --activation --stiffness-active 5e4 --volume-gain 1.2 --least-area 0 active
    for folder in tip still fast active; do simulate $folder/tip.scene.json --solver qn -o $folder.pc2 --log $folder.jsonl; done
    python3 - "$schema" <<'END'
import json, jsonschema, math, struct, sys
for folder in ("tip", "still", "fast", "active"):
    for kind, name in (("scene", "tip.scene.json"), ("muscle", "fusiform.muscle.json")):
        jsonschema.validate(json.load(open(f"{folder}/{name}")), json.load(open(f"{sys.argv[1]}/{kind}.schema.json")))
def tip(name, f): # the last vertex, carried
    data = open(name, "rb").read()
    n = struct.unpack("<12siiffi", data[:32])[2]
    return struct.unpack("<3f", data[32 + 12 * n * f + 12 * (n - 1):][:12])
def arc(b): return (0, 0.2 * (1 - math.cos(b)) / b, 0.2 * math.sin(b) / b) if b else (0, 0, 0.2)
for f in range(25):
    t = f / 24
    assert math.dist(tip("tip.pc2", f), arc(math.pi / 2 * t * t * (3 - 2 * t))) < 1e-7
    assert math.dist(tip("fast.pc2", f), arc(min(math.pi / 2, math.radians(19) * f))) < 1e-5
for f in range(46): assert math.dist(tip("still.pc2", f), arc(math.radians(2) * f)) < 1e-7
last = json.loads(open("active.jsonl").readlines()[-1])
assert "area" not in last["errors"]
assert last["activation"] == 0.5 and abs(last["volume_goal"] - 1.1) < 0.05
END
    run -2 "$EXAMPLES/tip/tip"
    run -2 "$EXAMPLES/tip/tip" --triangles 5 x
    run -2 "$EXAMPLES/tip/tip" a b
    run -1 "$EXAMPLES/tip/tip" tip/tip.scene.json/x
    [ ! -e x ]
}

@test "a tip at 19 degrees a frame: the default's greatest strain is within 5 % of the solved steps', and no triangle collapses" {
    for size in 1000 4000; do
        "$EXAMPLES/tip/tip" --triangles $size --fast fast$size
        echo "qn substeps=1 iterations=10" > default.txt
        error-time -q fast$size/tip.scene.json --settings default.txt --runs 1 --reference 4 --floor 1 > fast.tsv
        awk -F '\t' 'NR == 2 { exit !($16 < 1.05 * $17 && $16 > 0.95 * $17 && $17 > 0.15) }' fast.tsv
        simulate -q fast$size/tip.scene.json -o fast.pc2 --log log.jsonl --fail-on 'triangle<0.05'
    done
}

@test "errors with a bone in the way are of the muscle that the bone presses" {
    "$EXAMPLES/tip/tip" --triangles 150 --bone bone
    printf 'qn iterations=10\nxpbd substeps=16 iterations=1\n' > two.txt
    error-time -q bone/tip.scene.json --frames 0:10 --settings two.txt --runs 1 --reference 8 --floor 1 -o pressed
    simulate -q bone/tip.scene.json --frames 0:10 --solver qn --fail-on 'penetration>0.00001' -o on.pc2 --log on.log
    simulate -q bone/tip.scene.json --frames 0:10 --solver qn --no-contact -o off.pc2 --log off.log
    python3 - <<'END'
import csv, json, struct
rows = list(csv.DictReader(open("pressed/error-time.tsv"), delimiter="\t"))
errors = [float(r["total_error"]) for r in rows]
assert len(errors) == 2 and all(0.0 < e < 0.05 for e in errors), errors
frames = [json.loads(line) for line in open("on.log")]
assert max(m.get("contacts", 0) for f in frames for m in f.get("muscles", [f])) > 0
def last(path):
    data = open(path, "rb").read()
    n, = struct.unpack_from("<i", data, 16)
    return struct.unpack(f"<{3 * n}f", data[-12 * n:])
on, off = last("on.pc2"), last("off.pc2")
assert max(abs(a - b) for a, b in zip(on, off)) > 0.003
END
}

@test "tied muscles: the corotated matrix is no setting of its own, and the farthest point is named" {
    python3 -c 'import json
s = json.load(open("tip/two.scene.json"))
d = json.load(open("tip/fusiform.muscle.json"))
y = d["mesh"]["vertices"][1::3]
width = max(y) - min(y)
d["mesh"]["vertices"][1::3] = [v + 0.98 * width for v in y]
json.dump(d, open("tip/beside.muscle.json", "w"))
s["muscles"][1]["rig"] = "beside.muscle.json"
s["externals"] = True
json.dump(s, open("tip/tied.scene.json", "w"))'
    attach-detect -q tip/fusiform.muscle.json --glue right=tip/beside.muscle.json --reach 6mm -o tip/left.muscle.json
    mv tip/left.muscle.json tip/fusiform.muscle.json
    [ "$(simulate -q tip/tied.scene.json --plan | python3 -c 'import json, sys; print(len(json.load(sys.stdin)["plan"]["coupled"]))')" = 1 ]
    printf 'qn iterations=4\nqn preconditioner=corotated\n' > tied.txt
    error-time tip/tied.scene.json --settings tied.txt --runs 1 --reference 4 -o tied 2> said
    grep -q "warning: .*1 settings with the corotated one are left out" said
    [ "$(tail -n +2 tied/error-time.tsv | cut -f1)" = "qn iterations=4" ]
    python3 -c 'import json
point, = json.load(open("tied/error-time.json"))["settings"][0]["points"]
assert point["farthest"]["muscle"] in ("left", "right") and point["farthest"]["vertex"] >= 0, point'
    echo 'qn preconditioner=corotated' > corotated.txt
    run -1 error-time tip/tied.scene.json --settings corotated.txt --runs 1 --reference 4
    [[ "$output" == *"all settings ask for the corotated matrix"* ]]
    # the same muscles without ties: both settings are measured
    python3 -c 'import json
s = json.load(open("tip/tied.scene.json")); s["externals"] = False; json.dump(s, open("tip/apart.scene.json", "w"))'
    error-time -q tip/apart.scene.json --settings tied.txt --runs 1 --reference 4 -o apart
    [ "$(tail -n +2 apart/error-time.tsv | wc -l)" -eq 2 ]
}

@test "bones' files are looked at: one that is not there draws a warning as in simulate, one that is no file is refused" {
    cp tip/*.json .
    for file in nowhere.ply /dev/zero; do
        python3 - $file << 'END'
import json, sys
s = json.load(open("tip/tip.scene.json"))
s["bones"][0]["mesh"] = sys.argv[1]
json.dump(s, open("tip/odd.scene.json", "w"))
END
        code=0
        timeout 60 "$BIN/error-time" tip/odd.scene.json --frames 0:1 --settings settings.txt --runs 1 --reference 4 -o odd 2> err || code=$?
        if [ $file = nowhere.ply ]; then
            grep -q 'warning: .*nowhere.ply: bone ".*": cannot be opened.*this run does without its surface' err
            [ "$code" -ne 1 ]
        else
            grep -q '/dev/zero: bone ".*": is a device or a pipe' err
            [ "$code" -eq 1 ]
        fi
    done
}
