#!/usr/bin/env python3
"""How many products are proved, by objective and direction:

    benchmarks/real_products.py FOLDER [PROGRAM] [SECONDS]

solves every problem file in FOLDER and below under eight objectives in both directions, at most SECONDS each, and prints a
Markdown table. An objective that a problem has no data for, such as positions, does not count for it. Below the table stands
each problem that was not proved, with its gap.
"""
import json
import pathlib
import subprocess
import sys

FOLDER = pathlib.Path(sys.argv[1])
PROGRAM = sys.argv[2] if len(sys.argv) > 2 else "build/release/orasp"
SECONDS = sys.argv[3] if len(sys.argv) > 3 else "5"
OBJECTIVES = ("cubesat", "time", "travel", "fuel", "completion", "indexed", "custom", "cubesat_zone")

print("| objective | direction | proved | problems |\n|---|---|---|---|", flush=True)
left = []
for objective in OBJECTIVES:
    for direction in ("disassembly", "assembly"):
        proved = 0
        asked = 0
        for file in sorted(FOLDER.rglob("*.json")):
            run = subprocess.run([PROGRAM, "solve", file, "--objective", objective, "--direction", direction, "--time-limit",
                                  SECONDS, "--json", "--quiet"], capture_output=True, text=True, check=False)
            if not run.stdout:
                continue
            answer = json.loads(run.stdout)
            asked += 1
            if answer["status"] in ("optimal", "infeasible"):
                proved += 1
            else:
                left.append(f"{file.name}, {objective}, {direction}: {answer['status']}, gap {answer.get('gap')}")
        print(f"| `{objective}` | {direction} | {proved} | {asked} |", flush=True)
for line in left:
    print(line)
