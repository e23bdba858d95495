#!/bin/sh
# How long motion-import takes on the walk of 343 frames and 31 joints, as BVH and as ASF with AMC: the best of ten, by the clock and of the
# processor. Usage: BIN=... DATA=... tests/bench/motion-time.sh (make motion-time).
set -eu
: "${BIN:?set BIN to the folder of the tools}" "${DATA:?set DATA to the folder of real anatomy}"
/usr/bin/python3 - "$BIN/motion-import" "$DATA/mocap-cmu/motion" <<'END'
import os, subprocess, sys, tempfile, time

tool, folder = sys.argv[1:]
out = os.path.join(tempfile.mkdtemp(), "walk.motion.json")
walk, acclaim = folder + "/cmu_02_01_walk.bvh", [folder + "/02_01.amc", "--skeleton", folder + "/02.asf"]

def once(words):
    begun = time.perf_counter()
    child = os.posix_spawn(tool, [tool, "-q", "-o", out, *words], os.environ)
    _, status, used = os.wait4(child, 0)
    if status != 0: sys.exit("motion-import fails")
    return time.perf_counter() - begun, used.ru_utime + used.ru_stime

print("source\twall_s\tcpu_s\tbytes")
for name, words in (("BVH", [walk]), ("ASF and AMC", acclaim), ("BVH, filtered, at 60 Hz", [walk, "--filter", "6", "--rate", "60"]), ("motion document", [out])):
    if name == "motion document":
        once([walk])
        words = [out + ".source"]
        os.rename(out, words[0])
    times = [once(words) for _ in range(10)]
    print("%s\t%.3f\t%.3f\t%d" % (name, min(t[0] for t in times), min(t[1] for t in times), os.path.getsize(out)), flush=True)
END
