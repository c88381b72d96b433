#!/usr/bin/env python3
"""How well problems with costs between consecutive steps are proved.

    benchmarks/consecutive_costs.py PROGRAM [CHANGEOVERS]

Changeovers: so many random problems (100) of 12 to 16 connections, with precedence, costs between the values of an
attribute, in both directions; a third with a way between places, a third with durations. Then 60 bars on a base under
`route`, and 40 connections with one of five tools each, without and with precedence. Prints one Markdown table.
"""
import json
import math
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def changeover(seed):
    draw = random.Random(seed)
    connections = draw.randint(12, 16)
    tools = [f"T{i}" for i in range(draw.randint(2, 6))]
    parts = [{"id": "base", "position": [0, 0, 0]}]
    parts += [{"id": f"p{i}", "position": [draw.random() for _ in range(3)]} for i in range(connections)]
    links = [{"id": f"c{i}", "parts": ["base", f"p{i}"], "attributes": {"tool": draw.choice(tools)}}
             for i in range(connections)]
    density = draw.choice([0.05, 0.15, 0.3])
    precedence = [{"connection": f"c{i}", "after": after} for i in range(connections)
                  if (after := [f"c{j}" for j in range(i) if draw.random() < density])]
    costs = [{"from": a, "to": b, "cost": round(draw.uniform(0.2, 3), 2)} for a in tools for b in tools
             if a != b and draw.random() < 0.7]
    objective = {"type": "changeover", "attribute": "tool", "cost": 1, "costs": costs}
    others = [None, {"type": "route"}, {"type": "time"}][seed % 3]
    if others:
        objective = {"type": "sum", "terms": [objective, others]}
    known = {link["attributes"]["tool"] for link in links}
    if not known:
        objective = {"type": "completion"}
    return {"parts": parts, "connections": links, "precedence": precedence, "objective": objective,
            "direction": ["disassembly", "assembly"][seed % 2]}


def bars(direction):
    draw = random.Random(5)
    points = [(0.0, 0.0, 0.0)] + [(draw.uniform(0, 10), draw.uniform(0, 10), draw.uniform(0, 3)) for _ in range(40)]
    reached, edges = {0}, set()
    while len(reached) < len(points):
        _, near, far = min((math.dist(points[i], points[j]), i, j) for i in reached
                           for j in range(len(points)) if j not in reached)
        edges.add((near, far))
        reached.add(far)
    pairs = sorted((math.dist(points[i], points[j]), i, j) for i in range(len(points)) for j in range(i + 1, len(points)))
    for _, i, j in pairs:
        if len(edges) == 60:
            break
        if (j, i) not in edges:
            edges.add((i, j))
    return {"parts": [{"id": f"n{i}", "position": list(point)} for i, point in enumerate(points)],
            "connections": [{"id": f"e{k}", "parts": [f"n{i}", f"n{j}"]} for k, (i, j) in enumerate(sorted(edges))],
            "base": ["n0"], "limits": {"grounded": True, "max_moved_parts": 1}, "direction": direction,
            "objective": {"type": "route", "start": [0, 0, 0]}}


def tools(with_precedence):
    draw = random.Random(7)
    precedence = [{"connection": f"c{i}", "after": after} for i in range(40)
                  if with_precedence and (after := [f"c{j}" for j in range(i) if draw.random() < 0.06])]
    return {"parts": [{"id": "base"}] + [{"id": f"p{i}"} for i in range(40)],
            "connections": [{"id": f"c{i}", "parts": ["base", f"p{i}"], "attributes": {"tool": f"T{i % 5}"}}
                            for i in range(40)],
            "precedence": precedence, "objective": {"type": "changeover", "attribute": "tool"}}


def solved(program, problem, limit, folder):
    file = folder / "problem.json"
    file.write_text(json.dumps({"format": "orasp-problem/1", **problem}))
    begin = time.monotonic()
    run = subprocess.run([program, "solve", file, "--json", "--time-limit", str(limit)], capture_output=True, text=True)
    seconds = time.monotonic() - begin
    return json.loads(run.stdout), seconds


def main():
    program = sys.argv[1]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        runs = [solved(program, changeover(seed), 2, folder) for seed in range(count)]
        proved = sum(plan["status"] in ("optimal", "infeasible") for plan, _ in runs)
        times = sorted(seconds for _, seconds in runs)
        print("| problem | answer | seconds |\n|---|---|---|")
        print(f"| {count} changeover problems | {proved} proved | median {statistics.median(times):.3f}, "
              f"most {times[-1]:.3f} |")
        for label, problem in [("60 bars, disassembly", bars("disassembly")), ("60 bars, assembly", bars("assembly")),
                               ("40 tools", tools(False)), ("40 tools, precedence", tools(True))]:
            plan, seconds = solved(program, problem, 10, folder)
            gap = 100 * plan["gap"] / abs(plan["reward"]) if plan["gap"] else 0
            print(f"| {label} | {plan['reward']:.6g}, {plan['status']}, gap {gap:.2g} % | {seconds:.2f} |")


if __name__ == "__main__":
    main()
