#!/bin/sh
# What it takes to start each tool (--version), beside the smallest program there is: the least of 100 starts, and over that of `true`.
# Usage: BIN=... tests/bench/start-up.sh (make start-up). Prints tool, shared libraries, processor ms, ratio, wall ms, ratio.
set -eu
: "${BIN:?set BIN to the folder of the tools}"
/usr/bin/python3 - /bin/true "$BIN"/* <<'END'
import os, subprocess, sys, time

def start(program):
    quiet = [(os.POSIX_SPAWN_OPEN, 1, "/dev/null", os.O_WRONLY, 0)]
    begun = time.perf_counter()
    child = os.posix_spawn(program, [program, "--version"], os.environ, file_actions=quiet)
    _, status, used = os.wait4(child, 0)
    if status != 0: sys.exit(program + " --version fails")
    return used.ru_utime + used.ru_stime, time.perf_counter() - begun

def least(program):
    starts = [start(program) for _ in range(100)]
    return [1e3 * min(column) for column in zip(*starts)]

print("tool\tlibraries\tcpu_ms\tover_true\twall_ms\tover_true")
for program in sys.argv[1:]:
    cpu, wall = least(program)
    if program == "/bin/true": true_cpu, true_wall = cpu, wall
    libraries = subprocess.run(["ldd", program], capture_output=True, text=True).stdout.count("=>")
    print("%s\t%d\t%.1f\t%.1f\t%.1f\t%.1f" % (os.path.basename(program), libraries, cpu, cpu / true_cpu, wall, wall / true_wall), flush=True)
END
