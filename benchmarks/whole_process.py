#!/usr/bin/env python3
"""Wall time of whole runs of the program: benchmarks/whole_process.py [PROGRAM] [RUNS]; a Markdown table.

benchmarks/whole_process.py --iss [PROGRAM] runs value-iteration on `iss` once, with its largest memory: 8 GiB, a minute.
"""
import resource
import statistics
import subprocess
import sys
import time

ISS = "--iss" in sys.argv
WORDS = [word for word in sys.argv[1:] if word != "--iss"]
PROGRAM = WORDS[0] if len(WORDS) > 0 else "build/release/orasp"
RUNS = int(WORDS[1]) if len(WORDS) > 1 else 40
CASES = [["--version"]]
CASES += [["solve", "hubble", "--method", m] for m in
          ("auto", "value-iteration", "dijkstra", "bellman-ford", "orasp-search")]
CASES += [["solve", name, "--method", "value-iteration"] for name in ("lattice", "hubble-upc", "hubble-free")]
CASES += [["solve", name] for name in ("iss", "iss-upc", "jwst", "jwst-upc", "chain:100", "tree:500:7")]


def wall(case):
    begin = time.perf_counter()
    subprocess.run([PROGRAM, *case], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    return (time.perf_counter() - begin) * 1e3


if ISS:
    seconds = wall(["solve", "iss", "--method", "value-iteration"]) / 1e3
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"iss: {seconds:.1f} s, processor {usage.ru_utime:.1f} s, kernel {usage.ru_stime:.1f} s, "
          f"largest {usage.ru_maxrss / 2**20:.2f} GiB")
    sys.exit()

print("| command | least ms | median ms |\n|---|---|---|")
for case in CASES:
    times = [wall(case) for _ in range(RUNS)]
    print(f"| `orasp {' '.join(case)}` | {min(times):.1f} | {statistics.median(times):.1f} |", flush=True)
