#!/bin/sh
# A whole body walks: share/examples/body/Makefile on the 148 muscles and 202 bones of body-bp3d-low and a walk of 120 frames, without contact.
# Prints what the rigs lack, what the warnings say, and time, memory and the worst muscles of the simulation, which runs with as many threads as
# there are processors. Usage: BIN=... DATA=... tests/bench/body-walk.sh [OUT] (make body-walk). OUT keeps everything, and is
# made anew; without it nothing stays.
# Fails where a muscle has no rig, is not in the scene or in the log, is on no bone, has exploded or has a point that is not finite.
set -eu
export LC_ALL=C
unset MAKEFLAGS MFLAGS MAKELEVEL
here=$(cd "$(dirname "$0")/../.." && pwd)
bin=$(cd "${BIN:?the folder of the tools}" && pwd)
data=$(cd "${DATA:?the folder of real anatomy}" && pwd)
if [ $# -gt 0 ]; then
    mkdir -p "$1"
    cd "$1"
else
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    cd "$work"
fi
make -s -f "$here/share/examples/body/Makefile" DATA="$data" clean

/usr/bin/python3 - "$bin" "$data" "$here" <<'END'
import collections, json, os, re, subprocess, sys, time

tools, data, here = sys.argv[1:]

def spent(words, output=None):
    """Seconds by the clock and of the processor of a command and its children, the most memory of one of them (MB), and its exit status."""
    begun = time.perf_counter()
    child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output, stderr=output)
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return time.perf_counter() - begun, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, child.returncode

make = ["make", "-j2", "-f", here + "/share/examples/body/Makefile", "TOOLS=" + tools, "DATA=" + data]
steps = []
with open("said", "w") as said:
    for target in ("motion", "rigs", "activation", "scene"):
        wall, cpu, _, code = spent(make + [target], said)
        if code: sys.exit("make %s fails:\n%s" % (target, open("said").read()[-2000:]))
        steps.append("%s %.1f s (%.1f s of the processor)" % (target, wall, cpu))
    simulate = [tools + "/simulate", "walk.scene.json", "-o", "frames", "--log", "walk.jsonl", "--report", "walk.report.json"]
    # the best of three, as others work on the machine; and without all frames but the first: what loading and the preroll take
    runs, medians = [], []
    for _ in range(3):
        runs.append(spent(simulate, said))
        if runs[-1][3] not in (0, 3): sys.exit("simulate fails:\n" + open("said").read()[-2000:])
        medians.append(json.load(open("walk.report.json"))["medianFrameSeconds"])
    begun = min(spent([tools + "/simulate", "-q", "walk.scene.json", "--frames", "0:0", "-o", "first", "--log", "first.jsonl"], said)[1] for _ in range(3))
wall, cpu, memory, code = [min(run[k] for run in runs) for k in range(2)] + [max(run[k] for run in runs) for k in range(2, 4)]

names = open("names.txt").read().split()
scene, report = json.load(open("walk.scene.json")), json.load(open("walk.report.json"))
motion = json.load(open("walk.motion.json"))
rows = [json.loads(line) for line in open("walk.jsonl")]
rigs = {name: json.load(open("rigs/%s.muscle.json" % name)) for name in names}
summary = [line.rstrip("\n").split("\t") for line in open("rigs/summary.tsv")][1:]

print("made: " + "; ".join(steps))
print("%d rigs, %d triangles, %d vertices on bones; %d in the scene, %d of them enabled; %d bones on %d joints" % (
    len(rigs), sum(len(r["mesh"]["triangles"]) // 3 for r in rigs.values()), sum(len(a["vertices"]) for r in rigs.values() for a in r["attachments"]),
    len(scene["muscles"]), sum(m.get("enabled", True) for m in scene["muscles"]), len(motion["bones"]), len(motion["joints"])))

# ---- what the rigs lack: exit status 3 of a stage, and warnings by kind
print("status: " + ", ".join("%s %d" % pair for pair in sorted(collections.Counter(row[2] for row in summary).items())))
for row in summary:
    if row[2] != "ok": print("  %s, %s: %s" % (row[0], row[3], row[4]))
kinds = {"is held by one bone only": "on one bone alone", "nothing attached": "on no bone", "less than 1 %": "a slight grip", "scattered": "a scattered grip",
         "slides over": "a tendon that may slide", "wrapped": "wrapped", "closed cracks": "cracks closed", "dropped .* component": "pieces dropped",
         "centroid": "roots far from the middle"}
found = collections.defaultdict(set)
for name in names:
    for tool in ("mesh-clean", "root-select", "build-structure", "fiber-flow", "attach-detect"):
        for line in open("rigs/logs/%s.%s.log" % (name, tool)):
            for words, kind in kinds.items():
                if re.search(words, line): found[kind].add(name)
print("warnings, in muscles: " + ", ".join("%s %d" % (kind, len(found[kind])) for kind in kinds.values()))
print("bones to a muscle: " + ", ".join("%d: %d" % pair for pair in sorted(collections.Counter(len(r["attachments"]) for r in rigs.values()).items())))

# ---- the simulation
frames = sorted({row["frame"] for row in rows})
print("simulate: %d frames at %g a second, with a preroll of %g s; %.1f ms a frame (median by the clock, %d threads), %.1f ms of the processor; "
      "%.1f s in all, %.1f s of the processor; %.0f MB" % (len(frames), scene["rate"], scene.get("preroll", 0), 1e3 * min(medians),
                                                           report["threads"], 1e3 * (cpu - begun) / (len(frames) - 1), wall, cpu, memory))
muscles = collections.defaultdict(list)
for row in rows: muscles[row["muscle"]].append(row)
def worst(title, unit, value, count=5):
    print(title)
    ranked = sorted(((value(max(of, key=value)), name, max(of, key=value)) for name, of in muscles.items()), key=lambda t: (-t[0], t[1]))
    for number, name, row in ranked[:count]:
        print("  %-8s %s, frame %d, activation %.2f" % (unit(number), name, row["frame"], row["activation"]))
worst("volume farthest from its goal", lambda x: "%.2f %%" % (100 * x), lambda row: abs(row["volume_error"] or 0))
worst("longest edge over its goal", lambda x: "%.2f" % x, lambda row: row["largest_edge_ratio"])
worst("smallest triangle over its rest area", lambda x: "%.3f" % -x, lambda row: -row["smallest_triangle"])
torn = collections.Counter(row["muscle"] for row in rows if row["torn"])
print("torn: " + (", ".join("%s in %d frames" % pair for pair in sorted(torn.items())) or "none"))
exploded, wild = report["outcome"]["exploded"], sum(row["nan"] for row in rows)
print("exploded: %d; points that are not finite: %d" % (len(exploded), wild))

loose = [name for name, rig in rigs.items() if not rig["attachments"]]
faults = ["simulate ends with %d" % code] * (code != 0) + ["on no bone: " + name for name in loose] + ["not finite"] * (wild > 0)
manifest = [line.split("\t")[1] for line in open(data + "/body-bp3d-low/manifest.tsv")].count("muscle")
if not manifest == len(rigs) == len(muscles) == len(scene["muscles"]): faults.append("%d muscles, %d rigs, %d in the log" % (manifest, len(rigs), len(muscles)))
if any(len(of) != len(frames) for of in muscles.values()): faults.append("lines of the log are missing")
for fault in faults: print("FAILED: " + fault)
sys.exit(bool(faults))
END
