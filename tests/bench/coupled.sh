#!/bin/sh
# Twelve muscles of a dog's hind leg and of its fore leg, tied to each other: share/examples/dog/hind-leg.sh and fore-leg.sh, and what faces each
# other within 6 mm, two targets a vertex, on two joints that bend by 25 and 30 degrees in a second and hold for half of one, at 60 frames a
# second. Prints of each leg rows, then for each setting ms a frame, and the greatest distance of each muscle in any frame from the converged solve of the same
# steps, over the muscle's size: median and worst of the muscles; all of that without contact; how far what slides is from what it slides on; and the elastic energy at the end with contact of the
# bones, beside that of the converged solve. Usage: BIN=... DATA=... tests/bench/coupled.sh [OUT]
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
make_leg() { # LEG MOTION
    "$here/share/examples/dog/$1-leg.sh" "$bin" "$dog" "$1" 2> said
    "$here/share/examples/dog/tie.sh" "$bin" "$1" "$2" 2>> said
}
make_leg hind hip
make_leg fore shoulder

/usr/bin/python3 - "$bin" "$here/tests/slide-distances.py" <<'END'
import json, math, os, shutil, statistics, struct, subprocess, sys

simulate = sys.argv[1] + "/simulate"
settings = [("qn, %d iterations" % n, ["--iterations", str(n)]) for n in (3, 5, 10, 20, 40)]
settings += [("qn, default, one thread", ["--threads", "1"]), ("xpbd, 10 iterations", ["--solver", "xpbd", "--iterations", "10"]),
             ("xpbd, 10 iterations, 10 substeps", ["--solver", "xpbd", "--iterations", "10", "--substeps", "10"])]

def run(folder, options, tied=True):
    shutil.rmtree(folder, ignore_errors=True)
    words = [simulate, "-q", "tied.scene.json", "-o", folder, "--log", folder + ".jsonl", "--report", folder + ".json"]
    code = subprocess.run(words + ([] if tied else ["--no-externals"]) + options, stderr=subprocess.DEVNULL).returncode
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

converged = ["--iterations", "500", "--tolerance", "1e-9"]

def energy(name):
    rows = [json.loads(line) for line in open(name + ".jsonl")]
    return sum(r["elastic_energy"] for r in rows if r["frame"] == rows[-1]["frame"])

def measure():
    run("converged", converged)
    rows = [json.loads(line) for line in open("converged.jsonl")]
    plan = json.loads(subprocess.run([simulate, "-q", "tied.scene.json", "--plan"], stdout=subprocess.PIPE, check=True).stdout)["plan"]
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
    run("now", [])
    subprocess.run([sys.executable, sys.argv[2], "tied", "now"], check=True)
    run("touching", ["--contact"] + converged)
    least = energy("touching")
    run("now", ["--contact"])
    print("with contact, default: energy at the end %+.2f %% from the converged solve's" % (100.0 * (energy("now") / least - 1.0)))

for leg in ("hind", "fore"):
    os.chdir(leg)
    print("-- %s leg" % leg)
    measure()
    os.chdir("..")
END
