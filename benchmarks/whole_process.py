#!/usr/bin/env python3
"""Wall time of whole runs of the program: benchmarks/whole_process.py [PROGRAM] [RUNS]; a Markdown table."""
import statistics
import subprocess
import sys
import time

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "build/release/orasp"
RUNS = int(sys.argv[2]) if len(sys.argv) > 2 else 40
CASES = [["--version"]]
CASES += [["solve", "hubble", "--method", m] for m in
          ("auto", "value-iteration", "dijkstra", "bellman-ford", "orasp-search")]
CASES += [["solve", name, "--method", "value-iteration"] for name in ("lattice", "hubble-upc", "hubble-free")]
CASES += [["solve", name] for name in ("iss", "iss-upc", "jwst", "jwst-upc", "chain:100", "tree:500:7")]


def wall(case):
    begin = time.perf_counter()
    subprocess.run([PROGRAM, *case], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    return (time.perf_counter() - begin) * 1e3


print("| command | least ms | median ms |\n|---|---|---|")
for case in CASES:
    times = [wall(case) for _ in range(RUNS)]
    print(f"| `orasp {' '.join(case)}` | {min(times):.1f} | {statistics.median(times):.1f} |", flush=True)
