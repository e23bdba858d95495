#!/bin/sh
# What it takes to start each tool (--version), beside the smallest program there is, and beside that with the tool's libraries loaded into it:
# what the tool does itself is the difference. The least of 100 starts each, of the processor and by the clock, over that of `true` alone.
# Usage: BIN=... tests/bench/start-up.sh (make start-up)
set -eu
: "${BIN:?set BIN to the folder of the tools}"
/usr/bin/python3 - "$BIN"/* <<'END'
import os, re, subprocess, sys, time

def start(program, environment):
    quiet = [(os.POSIX_SPAWN_OPEN, 1, "/dev/null", os.O_WRONLY, 0)]
    begun = time.perf_counter()
    child = os.posix_spawn(program, [program, "--version"], environment, file_actions=quiet)
    _, status, used = os.wait4(child, 0)
    if status != 0: sys.exit(program + " --version fails")
    return used.ru_utime + used.ru_stime, time.perf_counter() - begun

def least(program, libraries=()):
    environment = dict(os.environ, LD_PRELOAD=":".join(libraries)) if libraries else os.environ
    return [1e3 * min(column) for column in zip(*(start(program, environment) for _ in range(100)))]

true = least("/bin/true")
print("program\tlibraries\tcpu_ms\tcpu_over_true\tlibraries_alone\twall_ms\twall_over_true")
print("true\t-\t%.1f\t1.0\t-\t%.1f\t1.0" % tuple(true))
for program in sys.argv[1:]:
    libraries = re.findall(r"=> (\S+)", subprocess.run(["ldd", program], capture_output=True, text=True).stdout)
    tool, alone = least(program), least("/bin/true", libraries)
    print("%s\t%d\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f" % (os.path.basename(program), len(libraries), tool[0], tool[0] / true[0], alone[0] / true[0],
          tool[1], tool[1] / true[1]), flush=True)
END
