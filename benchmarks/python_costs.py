#!/usr/bin/env python3
"""What Python adds to the time of the library:

    PYTHONPATH=FOLDER_OF_THE_MODULE benchmarks/python_costs.py [PROGRAM]

H of hubble-free as arrays against `orasp graph`, and value iteration on lattice with rewards that are built in, that a function gives
for many steps at once, and that one gives step by step: the least of seven runs each, in turn, as a Markdown table.
"""
import json
import subprocess
import sys
import time

import orasp

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "build/release/orasp"
RUNS = 7


def arrays():
    h = orasp.graph("hubble-free")
    return h.states, h.row_offsets, h.successors, h.connections, h.reward_numbers, h.reward_table


def timed(work):
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def by_program():
    answer = subprocess.run([PROGRAM, "graph", "hubble-free", "--json"], capture_output=True, text=True, check=True).stdout
    return json.loads(answer)["seconds"]


def one(step):
    return -len(step.moved) * step.before - 0.5 * len(step.kept)


def one_many(steps):
    return -steps.moved_parts * steps.before - 0.5 * steps.kept_parts


def solved(**options):
    return lambda: orasp.solve("lattice", "value-iteration", **options)


CASES = [
    ("H of hubble-free, `orasp graph`", by_program),
    ("H of hubble-free, arrays", lambda: timed(arrays)),
    ("lattice, `cubesat`", lambda: timed(solved())),
    ("lattice, a function of many steps", lambda: timed(solved(objective=orasp.Reward(one_many, vectorized=True)))),
    ("lattice, a function of one step", lambda: timed(solved(objective=one))),
]
least = [min(times) for times in zip(*[[case() for _, case in CASES] for _ in range(RUNS)])]
print("| what | ms |\n|---|---|")
for (name, _), seconds in zip(CASES, least):
    print(f"| {name} | {seconds * 1e3:.2f} |")
