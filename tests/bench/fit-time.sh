#!/bin/sh
# How long motion-fit takes to put a walk (343 frames) and a run (173) on the 202 bones of a body, without the distances of the report: the best
# of ten, by the clock and of the processor; and once with the report. Usage: BIN=... DATA=... tests/bench/fit-time.sh (make motion-time).
set -eu
: "${BIN:?set BIN to the folder of the tools}" "${DATA:?set DATA to the folder of real anatomy}"
/usr/bin/python3 - "$BIN/motion-fit" "$DATA" "$(dirname "$0")/../../share/examples/body/bp3d.tsv" <<'END'
import os, subprocess, sys, tempfile, time

tool, data, table = sys.argv[1:]
folder = tempfile.mkdtemp()
out, bones = os.path.join(folder, "fit.motion.json"), os.path.join(folder, "bones.txt")
with open(data + "/body-bp3d-low/manifest.tsv") as manifest, open(bones, "w") as names:
    for row in (line.split("\t") for line in manifest):
        if row[1] == "bone": names.write(os.path.abspath(data) + "/body-bp3d-low/meshes/" + row[0] + "\n")

def once(words):
    begun = time.perf_counter()
    child = os.posix_spawn(tool, [tool, "-q", "--body", table, "--bones", bones, "-o", out, *words], os.environ)
    _, status, used = os.wait4(child, 0)
    if status != 0: sys.exit("motion-fit fails")
    return time.perf_counter() - begun, used.ru_utime + used.ru_stime

print("motion\twall_s\tcpu_s\tbytes")
for name in ("01_walk", "03_run"):
    source = [data + "/mocap-cmu/motion/cmu_02_%s.bvh" % name]
    for what, words, count in (("", [], 10), (", with the report", ["--report", os.path.join(folder, "report.json")], 1)):
        times = [once(source + words) for _ in range(count)]
        print("%s%s\t%.3f\t%.3f\t%d" % (name[3:], what, min(t[0] for t in times), min(t[1] for t in times), os.path.getsize(out)), flush=True)
END
