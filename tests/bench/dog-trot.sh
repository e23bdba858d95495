#!/bin/sh
# A whole dog trots: share/examples/dog/Makefile, 253 muscles tied to each other where they face each other within 6 mm, on 172 bones. Prints the
# groups of the plan with rows and what their matrices cost, then for one thread and for two the time until the first frame, ms a frame and
# memory, and of the last run who is torn at the end, has exploded or is not finite, and the five muscles with the longest edges.
# Usage: BIN=... DATA=... tests/bench/dog-trot.sh OUT [OPTION ...]: OUT keeps everything, and what is there already; options are simulate's.
set -eu
export LC_ALL=C
unset MAKEFLAGS MFLAGS MAKELEVEL
here=$(cd "$(dirname "$0")/../.." && pwd)
bin=$(cd "${BIN:?the folder of the tools}" && pwd)
data=$(cd "${DATA:?the folder of real anatomy}" && pwd)
mkdir -p "${1:?the folder for what it makes}"
cd "$1"
shift
make -s -j2 -f "$here/share/examples/dog/Makefile" TOOLS="$bin" DATA="$data" scene > said 2>&1

/usr/bin/python3 - "$bin/simulate" "$@" <<'END'
import json, os, subprocess, sys

simulate, options = sys.argv[1], sys.argv[2:]
plan = json.loads(subprocess.run([simulate, "-q", "trot.scene.json", "--externals", "--plan"] + options, stdout=subprocess.PIPE, check=True).stdout)["plan"]
for group in plan["coupled"]:
    print("a group of %d muscles: %d rows, %d of them begin inside; matrix: %d entries, factor %.0f ms, solve %.1f ms" % (
        len(group["muscles"]), group["rows"], group["overlapsAtRest"], group["matrix"]["entries"], group["matrix"]["factorMilliseconds"],
        group["matrix"]["solveMilliseconds"]))
for threads in ("1", "2"):
    child = subprocess.Popen([simulate, "-q", "trot.scene.json", "--externals", "--threads", threads, "-o", "frames", "--log", "trot.jsonl",
                              "--report", "trot.report.json"] + options, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    report = json.load(open("trot.report.json"))
    print("%s thread%s: %.1f s until the first frame, %.0f ms a frame, %.0f MB, status %d" % (
        threads, "" if threads == "1" else "s", report["setupSeconds"], 1e3 * report["medianFrameSeconds"], used.ru_maxrss / 1024,
        os.waitstatus_to_exitcode(status)))
rows = [json.loads(line) for line in open("trot.jsonl")]
last = [r for r in rows if r["frame"] == rows[-1]["frame"]]
print("%d frames; not finite: %d; torn at the end: %s" % (rows[-1]["frame"] - rows[0]["frame"] + 1, sum(r["nan"] > 0 for r in rows),
                                                        ", ".join(r["muscle"] for r in last if r["torn"]) or "none"))
for r in sorted(last, key=lambda r: -r["largest_edge_ratio"])[:5]:
    print("  %-40s longest edge %6.2f, smallest triangle %.2f, volume %+.1f %%, in a neighbour by %.1f mm more than at rest" % (
        r["muscle"], r["largest_edge_ratio"], r["smallest_triangle"], 100.0 * (r["volume_ratio"] / r["volume_goal"] - 1.0), 1e3 * r.get("entered", 0.0)))
END
