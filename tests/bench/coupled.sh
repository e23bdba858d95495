#!/bin/sh
# Twelve muscles of a dog's hind leg, tied to each other: share/examples/dog/hind-leg.sh, and what faces each other within 6 mm, two targets a
# vertex, on hip and knee that bend by 25 and 30 degrees in a second and hold for half of one, at 60 frames a second, without contact.
# Prints rows, then for each setting ms a frame, and the greatest distance of each muscle in any frame from the converged solve of the same
# steps, over the muscle's size: median and worst of the muscles; and for one core. Usage: BIN=... DATA=... tests/bench/coupled.sh [OUT]
set -eu
export LC_ALL=C
here=$(cd "$(dirname "$0")/../.." && pwd)
bin=$(cd "${BIN:?the folder of the tools}" && pwd)
dog=$(cd "${DATA:?the folder of real anatomy}" && pwd)/dog-dmcontrol
if [ $# -gt 0 ]; then
    mkdir -p "$1"
    cd "$1"
else
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    cd "$work"
fi
"$here/share/examples/dog/hind-leg.sh" "$bin" "$dog" . 2> said
mkdir -p tied
for rig in rigs/*.muscle.json; do
    "$bin/attach-detect" -q "$rig" --muscles rigs --reach 6mm -o "tied/${rig#rigs/}"
done
"$bin/scene-build" -q tied --motion hip.motion.json --rate 60 --frames 0:90 -o tied.scene.json 2>> said

/usr/bin/python3 - "$bin" <<'END'
import json, math, os, shutil, statistics, struct, subprocess, sys

simulate = sys.argv[1] + "/simulate"
settings = [("qn, %d iterations" % n, ["--iterations", str(n)]) for n in (3, 5, 10, 20, 40)]
settings += [("qn, default, one thread", ["--threads", "1"]), ("xpbd, 10 iterations", ["--solver", "xpbd", "--iterations", "10"]),
             ("xpbd, 10 iterations, 10 substeps", ["--solver", "xpbd", "--iterations", "10", "--substeps", "10"])]

def run(folder, options, tied=True):
    shutil.rmtree(folder, ignore_errors=True)
    words = [simulate, "-q", "tied.scene.json", "-o", folder, "--log", folder + ".jsonl", "--report", folder + ".json"]
    code = subprocess.run(words + (["--externals"] if tied else []) + options, stderr=subprocess.DEVNULL).returncode
    if code not in (0, 3): sys.exit("simulate %s: status %d" % (" ".join(options), code))
    return 1e3 * json.load(open(folder + ".json"))["medianFrameSeconds"]

def frames(path):
    data = open(path, "rb").read()
    points, samples = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
    return points, samples, struct.unpack("<%df" % (3 * points * samples), data[32:])

def distance(a, b):
    points, samples, x = frames(a)
    y = frames(b)[2]
    size = math.dist([min(y[k:3 * points:3]) for k in range(3)], [max(y[k:3 * points:3]) for k in range(3)])
    squares = (sum((p - q) ** 2 for p, q in zip(x[at:at + 3 * points], y[at:at + 3 * points])) for at in range(0, 3 * points * samples, 3 * points))
    return math.sqrt(max(squares) / points) / size

run("converged", ["--iterations", "500", "--tolerance", "1e-9"])
rows = [json.loads(line) for line in open("converged.jsonl")]
plan = json.loads(subprocess.run([simulate, "-q", "tied.scene.json", "--externals", "--plan"], stdout=subprocess.PIPE, check=True).stdout)["plan"]
count = sum(g["rows"] for m in plan["muscles"] for g in m["groups"] if g["kind"] == "external")
print("%d muscles, %d rows; converged: %d of %d steps by tolerance" % (
    len(plan["muscles"]), count, sum(r["stopped_by"] == "tolerance" for r in rows), len(rows)))
deep = sorted(r["entered"] for r in rows)
print("converged: deeper in a neighbour than at rest by %.2f mm at most, %.2f in 99 of 100 frames of muscles" % (1e3 * deep[-1], 1e3 * deep[len(deep) * 99 // 100]))
print("tied to nothing, default: %.1f ms a frame" % run("apart", [], False))
print("%-34s%8s%10s%10s  %s" % ("", "ms", "median", "worst", "of"))
for name, options in settings:
    milliseconds = min(run("now", options) for _ in range(3))
    off = {m: distance("now/" + m, "converged/" + m) for m in sorted(os.listdir("converged"))}
    worst = max(off, key=off.get)
    print("%-34s%8.1f%10.1e%10.1e  %s" % (name, milliseconds, statistics.median(off.values()), off[worst], worst[:-4]))
END
