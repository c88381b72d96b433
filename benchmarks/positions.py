#!/usr/bin/env python3
"""How far from the bound plans are where things move in space:

    benchmarks/positions.py [PROGRAM] [SECONDS] [FILE...]

solves three generated problems under `time` and `travel`, with positions drawn evenly from a cube of 20 m around the depot (the same
ones in every run), and the problem files given, at most SECONDS each, and prints a Markdown table.
"""
import json
import pathlib
import random
import subprocess
import sys

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "build/release/orasp"
SECONDS = sys.argv[2] if len(sys.argv) > 2 else "30"


def placed(name):
    """A problem without limits whose parts have random positions."""
    problem = json.loads(subprocess.run([PROGRAM, "scenarios", name], capture_output=True, text=True, check=True).stdout)
    problem.pop("limits", None)
    draw = random.Random(name)
    for part in problem["parts"]:
        part["position"] = [round(draw.uniform(-10, 10), 6) for _ in range(3)]
    return problem


problems = [(f"`{name}`", json.dumps(placed(name))) for name in ("grid:8x8", "tree:60:3", "jwst")]
problems += [(pathlib.Path(file).stem, pathlib.Path(file).read_text(encoding="utf-8")) for file in sys.argv[3:]]
print("| problem | objective | plan | bound | gap | seconds |\n|---|---|---|---|---|---|", flush=True)
for name, text in problems:
    for objective in ("time", "travel"):
        run = subprocess.run([PROGRAM, "solve", "-", "--objective", objective, "--time-limit", SECONDS, "--json", "--quiet"],
                             input=text, capture_output=True, text=True, check=False)
        answer = json.loads(run.stdout)
        plan, bound = answer["reward"], answer["bound"]
        gap = f"{100 * (bound - plan) / abs(plan):.2g} %" if bound > plan else "0"
        print(f"| {name} | `{objective}` | {plan:.6g} | {bound:.6g} | {gap} | {answer['statistics']['seconds']:.1f} |", flush=True)
