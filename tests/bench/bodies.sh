#!/bin/sh
# Romeo's body, whole: every target of share/examples/body/tied.mk in OUT, with what each takes; then the bill: rows by kind beside those of Romeo
# et al. (2018), what the plan leaves out, memory, ms a frame on one thread and on two, error against a converged solve, and how the motions ended;
# OUT/bill.md and OUT/index.md, which lists tables and pictures. Usage: BIN=... DATA=... tests/bench/bodies.sh OUT [TARGET ...] (make bodies).
# OUT keeps everything, and what is there already and unchanged is not made again. Fails where a target does, where a log has a number that is not
# finite or lacks lines, or where a run ended with another status than 0 and nothing tells of it.
set -eu
export LC_ALL=C
unset MAKEFLAGS MFLAGS MAKELEVEL
here=$(cd "$(dirname "$0")/../.." && pwd)
bin=$(cd "${BIN:?the folder of the tools}" && pwd)
data=$(cd "${DATA:?the folder of real anatomy}" && pwd)
mkdir -p "${1:?the folder for what it makes}"
cd "$1"
shift
[ $# -gt 0 ] || set -- motion rigs skeleton candidates types bend torsion shake gains walk charts run romeo

exec /usr/bin/python3 - "$bin" "$data" "$here" "$@" <<'END'
import collections, glob, json, math, os, shutil, statistics, struct, subprocess, sys, time

tools, data, here = sys.argv[1:4]
targets = sys.argv[4:]
PAPER = {"mesh": 75644, "internal": 20572, "external": 39424, "volume": 140}
table = []

def say(line=""):
    print(line, flush=True)
    table.append(line)

def spent(words):
    """Seconds by the clock, of the processor with all children, most memory of one of them (MB), exit status."""
    begun = time.perf_counter()
    with open("said", "a") as said:
        child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=said, stderr=said)
        _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return time.perf_counter() - begun, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, child.returncode

# ---- the targets
open("said", "w").close()
say("| targets | seconds by the clock | of the processor |")
say("| --- | --- | --- |")
total = [0.0, 0.0]
first = [t for t in targets if t in ("motion", "rigs")], [t for t in targets if t in ("skeleton", "candidates")]
for group in first + ([t for t in targets if t not in first[0] + first[1]],):
    if not group: continue
    wall, cpu, _, code = spent(["make", "-j2", "-f", here + "/share/examples/body/Makefile", "TOOLS=" + tools, "DATA=" + data] + group)
    if code: sys.exit("make %s fails:\n%s" % (" ".join(group), open("said").read()[-2000:]))
    say("| %s | %.0f | %.0f |" % (" ".join(group), wall, cpu))
    total = [total[0] + wall, total[1] + cpu]
say("| all | %.0f | %.0f |" % tuple(total))
say()

# ---- how the motions ended
def rows_of(name): return [json.loads(line) for line in open("tied/%s.jsonl" % name)]

faults = []
say("| run | frames | status | torn at the end | longest edge over its goal, at any time; at the end | volume off its goal, 99 %; worst | deeper than at rest in what it slides on, 99 % of frames of muscles; worst |")
say("| --- | --- | --- | --- | --- | --- | --- |")
for name in ("walk", "run", "romeo", "bend-distances", "bend-contraction", "bend-gain", "torsion", "shake", "gain-100", "gain-130", "gain-150", "gain-200"):
    if not os.path.exists("tied/%s.jsonl" % name): continue
    rows, status = rows_of(name), int(open("tied/%s.status" % name).read())
    frames, muscles = sorted({r["frame"] for r in rows}), {r["muscle"] for r in rows}
    if len(rows) != len(frames) * len(muscles): faults.append(name + ": lines of the log are missing")
    if any(r["nan"] for r in rows) and status != 3: faults.append(name + ": not finite, and status %d" % status)
    last = [r for r in rows if r["frame"] == frames[-1]]
    at = lambda values: sorted(values)[len(values) * 99 // 100] if values else 0.0
    worst = max(rows, key=lambda r: r["largest_edge_ratio"] or 0.0)
    ended = max(last, key=lambda r: r["largest_edge_ratio"] or 0.0)
    volume = [abs(r["volume_error"] or 0.0) for r in rows]
    entered = [1e3 * max(r.get("entered") or 0.0, 0.0) for r in rows]
    deepest = max(rows, key=lambda r: r.get("entered") or 0.0)
    off = max(rows, key=lambda r: abs(r["volume_error"] or 0.0))
    say("| %s | %d of %d muscles | %d | %s | %.1f (%s, frame %d); %.1f (%s) | %.1f %%; %.1f %% (%s) | %.1f mm; %.1f mm (%s, frame %d) |" % (
        name, len(frames), len(muscles), status, ", ".join(r["muscle"] for r in last if r["torn"]) or "none", worst["largest_edge_ratio"], worst["muscle"],
        worst["frame"], ended["largest_edge_ratio"], ended["muscle"], 100 * at(volume), 100 * max(volume), off["muscle"], at(entered), max(entered),
        deepest["muscle"], deepest["frame"]))
say()
def smallest(name): return min(rows_of(name), key=lambda r: r["smallest_triangle"])
if "torsion" in targets:
    r = smallest("torsion")
    say("Forearm torsion to 150 degrees: the smallest triangle has %.1f %% of its area at rest (%s, frame %d)." % (100 * r["smallest_triangle"], r["muscle"], r["frame"]))

def cache(path):
    head = open(path, "rb").read()
    points, samples = struct.unpack("<i", head[16:20])[0], struct.unpack("<i", head[28:32])[0]
    return points, samples, struct.unpack("<%df" % (3 * points * samples), head[32:])

def apart(points, x, y): return max(math.dist(x[k:k + 3], y[k:k + 3]) for k in range(0, 3 * points, 3))
if "shake" in targets:
    drift = {}
    for path in glob.glob("tied/shake/*.pc2"):
        points, samples, flat = cache(path)
        first, late, end = flat[:3 * points], flat[-3 * points * 31:-3 * points * 30], flat[-3 * points:]
        drift[os.path.basename(path)[:-4]] = (apart(points, first, end), apart(points, late, end), max(apart(points, first, flat[3 * points * s:3 * points * (s + 1)]) for s in range(samples)))
    unit = 1e3 * json.load(open(glob.glob("rigs/candidates/*.muscle.json")[0]))["metersPerUnit"]
    name = max(drift, key=lambda m: drift[m][0])
    say("Arm shaking: points go as far as %.0f mm; at the end, 1.4 s after, none is farther than %.2f mm from where it began (%s), median of the muscles %.2f mm; the last half second moves none by more than %.3f mm." % (
        unit * max(d[2] for d in drift.values()), unit * drift[name][0], name, unit * statistics.median(d[0] for d in drift.values()), unit * max(d[1] for d in drift.values())))
say()

# ---- the bill
if "walk" in targets:
    simulate = [tools + "/simulate", "-q", "tied/walk.scene.json"]
    def plan_of(options): return json.loads(subprocess.run(simulate + ["--plan"] + options, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True).stdout)["plan"]
    plans = {"qn, the default": plan_of([]), "--scheme romeo": plan_of(["--scheme", "romeo"])}
    candidates = sum(int(line.split("\t")[6]) for line in open("rigs/candidates.tsv").read().split("\n")[1:] if line)
    say("| rows | Romeo et al. | " + " | ".join(plans) + " |")
    say("| --- | --- |" + " --- |" * len(plans))
    counts = {}
    for label, plan in plans.items():
        counts[label] = collections.Counter()
        for muscle in plan["muscles"]:
            for group in muscle["groups"]: counts[label][group["kind"]] += group["rows"] - group.get("carriedByBones", 0)
    kinds = [("mesh", ["mesh"]), ("internal", ["internal", "radial"]), ("external", ["external"]), ("volume", ["volume"]), ("angles and least areas", ["dihedral", "area"])]
    for title, members in kinds:
        say("| %s | %s | %s |" % (title, PAPER.get(title, "none"), " | ".join(str(sum(c[m] for m in members)) for c in counts.values())))
    say()
    first = plans["qn, the default"]
    say("%d candidates in the rigs, of which those on attached vertices tie nothing. The model takes %.1f MB, the state %.1f MB." % (
        candidates, sum(m["modelBytes"] for m in first["muscles"]) / 1e6, sum(m["stateBytes"] for m in first["muscles"]) / 1e6))
    for group in first["coupled"]:
        say("A group of %d muscles: %d rows, %d of them begin inside of what they lie on, %.1f mm deep at most; matrix: %d entries, factor %.0f ms, solve %.1f ms." % (
            len(group["muscles"]), group["rows"], group["overlapsAtRest"], 1e3 * group["deepestAtRest"], group["matrix"]["entries"],
            group["matrix"]["factorMilliseconds"], group["matrix"]["solveMilliseconds"]))
    left = collections.Counter()
    for muscle in first["muscles"]:
        for group in muscle["groups"]:
            if "leftOut" in group: left[group["kind"] + ": " + group["leftOut"]] += 1
    say("Left out by the plan: " + ("; ".join("%s (%d muscles)" % pair for pair in sorted(left.items())) or "nothing") + "; %d samples on which no vertex hangs." % (
        sum(m.get("samplesLeftOut", 0) for m in first["muscles"])))
    say()
    end = json.loads(open("tied/walk.jsonl").read().strip().split("\n")[-1])["frame"]
    def on(folder, options, frames=5):
        shutil.rmtree(folder, ignore_errors=True)
        used = spent(simulate + ["--from", "tied/walk.state", "--frames", "%d:%d" % (end + 1, end + frames), "-o", folder, "--log", folder + ".jsonl", "--report", folder + ".json"] + options)
        if used[3] not in (0, 3): sys.exit("simulate %s: status %d" % (" ".join(options), used[3]))
        return used + (1e3 * json.load(open(folder + ".json"))["medianFrameSeconds"],)
    def distance(a, b):
        points, samples, x = cache(a)
        y = cache(b)[2]
        size = math.dist([min(y[k:3 * points:3]) for k in range(3)], [max(y[k:3 * points:3]) for k in range(3)])
        squares = (sum((p - q) ** 2 for p, q in zip(x[s:s + 3 * points], y[s:s + 3 * points])) for s in range(0, 3 * points * samples, 3 * points))
        return math.sqrt(max(squares) / points) / size
    on("error-converged", ["--iterations", "200", "--tolerance", "1e-8"])
    say("| the walk goes on, 5 frames | ms a frame, 1 thread; 2 | memory | error against the converged solve: median; worst muscle |")
    say("| --- | --- | --- | --- |")
    for label, options in (("qn, 10 iterations", ["--iterations", "10"]), ("qn, 30 iterations", ["--iterations", "30"])):
        one, two = on("error-now", options + ["--threads", "1"]), on("error-now", options + ["--threads", "2"])
        off = {m: distance("error-now/" + m, "error-converged/" + m) for m in sorted(os.listdir("error-converged"))}
        worst = max(off, key=off.get)
        say("| %s | %.0f; %.0f | %.0f MB | %.1e; %.1e (%s) |" % (label, one[4], two[4], two[2], statistics.median(off.values()), off[worst], worst[:-4]))
    if os.path.exists("tied/romeo.jsonl"):
        rows, theirs = rows_of("walk"), rows_of("romeo")
        shared = min(rows[-1]["frame"], theirs[-1]["frame"])
        off = {}
        for path in sorted(glob.glob("tied/romeo/*.pc2")):
            (points, _, x), (_, _, y) = cache(path), cache(path.replace("/romeo/", "/walk/"))
            at = 3 * points * (shared - rows[0]["frame"])
            x, y = x[at:at + 3 * points], y[at:at + 3 * points]
            size = math.dist([min(y[k::3]) for k in range(3)], [max(y[k::3]) for k in range(3)])
            off[os.path.basename(path)[:-4]] = math.sqrt(sum((p - q) ** 2 for p, q in zip(x, y)) / points) / size
        worst = max(off, key=off.get)
        say("| --scheme romeo, 10 iterations, the whole walk | %.0f on all threads | | from the default at frame %d: %.1e; %.1e (%s) |" % (
            1e3 * json.load(open("tied/romeo.report.json"))["medianFrameSeconds"], shared, statistics.median(off.values()), off[worst], worst))
    say()

with open("bill.md", "w") as out: out.write("# The bill\n\n" + "\n".join(table) + "\n")
with open("index.md", "w") as out:
    out.write("# Romeo's body: what is here\n\n- [The bill](bill.md)\n")
    for path in sorted(glob.glob("tied/*.svg") + glob.glob("tied/*.tsv") + ["rigs/summary.tsv", "rigs/candidates.tsv"]): out.write("- [%s](%s)\n" % (path, path))
    for path in sorted(glob.glob("tied/*.png")): out.write("\n## %s\n\n![%s](%s)\n" % (os.path.basename(path)[:-4], path, path))
for fault in faults: print("FAILED: " + fault)
sys.exit(bool(faults))
END
