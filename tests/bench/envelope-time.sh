#!/bin/sh
# How long envelope-bind takes for an envelope of about 10,700 triangles over the 202 bones of a body: to bind it, to move it
# by a frame, and to measure a frame of a run. The best of five, by the clock, on one thread; what loading takes is taken off by a run without.
# Usage: BIN=... DATA=... tests/bench/envelope-time.sh (make motion-time).
set -eu
: "${BIN:?set BIN to the folder of the tools}" "${DATA:?set DATA to the folder of real anatomy}"
/usr/bin/python3 - "$BIN" "$DATA" "$(dirname "$0")/../../share/examples/body/bp3d.tsv" <<'END'
import json, os, subprocess, sys, tempfile, time

tools, data, table = sys.argv[1:]
folder = tempfile.mkdtemp()
at = lambda name: os.path.join(folder, name)
with open(data + "/body-bp3d-low/manifest.tsv") as manifest, open(at("bones.txt"), "w") as names:
    for row in (line.split("\t") for line in manifest):
        if row[1] == "bone": names.write(os.path.abspath(data) + "/body-bp3d-low/meshes/" + row[0] + "\n")

def run(tool, *words):
    begun = time.perf_counter()
    subprocess.run([tools + "/" + tool, "-q", *words], check=True, stdin=subprocess.DEVNULL)
    return time.perf_counter() - begun

best = lambda *words: min(run("envelope-bind", "--threads", "1", "--bones", at("run.motion.json"), *words) for _ in range(5))
run("motion-fit", data + "/mocap-cmu/motion/cmu_02_03_run.bvh", "--body", table, "--bones", at("bones.txt"), "-o", at("run.motion.json"))
run("envelope-bind", "--bones", at("run.motion.json"), "--write-bones", at("bones.ply"))
run("mesh-clean", at("bones.ply"), "--units", "m", "--wrap", "0.0014", "--keep", "all", "--smooth", "1", "--triangles", "10700", "--flip-slivers", "-o", at("skin.ply"))
out = ["-o", at("skin.envelope.json")]
skin = [at("skin.ply"), "--units", "m", "--reach", "53mm", "--grow", "9mm"]
load = best("--write-bones", at("again.ply"))
bind = best(*skin, *out)
given = best(at("skin.envelope.json"), "-o", at("again.envelope.json"))
print("what\tms")
print("load motion and bones\t%.1f" % (1e3 * load))
print("bind, with its document\t%.1f" % (1e3 * (bind - load)), flush=True)
subprocess.run([tools + "/../tests/bench/envelope_deform", at("skin.envelope.json")], check=True)
report = run("envelope-bind", "--threads", "1", "--bones", at("run.motion.json"), at("skin.envelope.json"), "--every", "10", "--report", at("report.json"), "-o", at("again.envelope.json"))
print("a frame of the report\t%.1f" % (1e3 * (report - given) / (json.load(open(at("report.json")))["motion"]["frames"] + 1)))
END
