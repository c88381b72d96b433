#!/usr/bin/env python3
"""Fleets of robots on chains, grids, trees and the station: how far `fleet-search` gets.

    python3 benchmarks/fleets.py build/release/orasp [--time-limit 10] [--seeds 3] [--only WORD]

Each case is a problem file as docs/format.md states it, made from a seed, and solved once under
`makespan` and, with --travel, once under `fleet_travel`. A row gives status, steps or m2, bound,
states and seconds, in Markdown.
"""

import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile

DIRECTIONS = ["+x", "-x", "+y", "-y", "+z", "-z"]
SITES = [[1, 0], [-1, -2], [-2, 2], [2, -2]]


def problem(name, parts, edges, robots, sites):
    """A fleet problem; `edges` are triples of two parts from 1 and an axis."""
    return {
        "format": "orasp-problem/1",
        "name": name,
        "direction": "disassembly",
        "parts": [{"id": str(part)} for part in range(1, parts + 1)],
        "connections": [{"id": f"{a}-{b}", "parts": [str(a), str(b)], "axis": axis}
                        for a, b, axis in edges],
        "fleet": {"robots": robots, "depot": [0, 0], "sites": sites},
        "objective": {"type": "makespan"},
    }


def random_sites(seed, count=4):
    rng = random.Random(f"sites {seed}")
    return [[rng.randint(-3, 3), rng.choice([-3, -2, -1, 1, 2, 3])] for _ in range(count)]


def chain(parts, robots, seed):
    """Seed 0: all along x, the four published sites; else random axes and random sites."""
    rng = random.Random(f"chain {parts} {seed}")
    edges = [(i, i + 1, "-x" if seed == 0 else rng.choice(DIRECTIONS)) for i in range(1, parts)]
    sites = SITES if seed == 0 else random_sites(seed)
    return problem(f"chain {parts}, {robots} robots, seed {seed}", parts, edges, robots, sites)


def grid(width, height, robots, seed):
    """A raster along x and y; a seed above 0 leaves a tenth of the connections out."""
    rng = random.Random(f"grid {width} {height} {seed}")
    edges = []
    for row in range(height):
        for column in range(width):
            part = row * width + column + 1
            if column + 1 < width:
                edges.append((part, part + 1, "-x"))
            if row + 1 < height:
                edges.append((part, part + width, "-y"))
    if seed > 0:
        edges = connected_rest(width * height, edges, rng, len(edges) // 10)
    sites = SITES if seed == 0 else random_sites(seed)
    return problem(f"grid {width}x{height}, {robots} robots, seed {seed}", width * height, edges,
                   robots, sites)


def connected_rest(parts, edges, rng, without):
    """The edges but for `without` of them, and still in one piece."""
    kept = list(edges)
    for edge in rng.sample(edges, len(edges)):
        if without == 0:
            break
        rest = [other for other in kept if other != edge]
        reached, frontier = {1}, [1]
        while frontier:
            part = frontier.pop()
            for a, b, _ in rest:
                for here, there in ((a, b), (b, a)):
                    if here == part and there not in reached:
                        reached.add(there)
                        frontier.append(there)
        if len(reached) == parts:
            kept, without = rest, without - 1
    return kept


def tree(parts, robots, seed):
    """Each part on a random earlier one, along a random direction that is free there."""
    rng = random.Random(f"tree {parts} {seed}")
    used = {1: set()}
    edges = []
    for part in range(2, parts + 1):
        base = rng.choice([b for b in used if len(used[b]) < len(DIRECTIONS)])
        axis = rng.choice([d for d in DIRECTIONS if d not in used[base]])
        used[base].add(axis)
        used[part] = {("-" if axis[0] == "+" else "+") + axis[1]}
        edges.append((part, base, axis))
    return problem(f"tree {parts}, {robots} robots, seed {seed}", parts, edges, robots,
                   random_sites(seed))


def cases(seeds):
    for seed in range(seeds):
        yield chain(50, 10, seed)
        yield grid(6, 6, 6, seed)
        yield chain(100, 10, seed)
        yield grid(9, 9, 9, seed)
        yield tree(60, 8, seed)
        yield tree(100, 8, seed)


def solve(program, path, more, limit):
    done = subprocess.run([program, "solve", path, "--method", "fleet-search", "--json",
                           "--time-limit", str(limit), *more],
                          capture_output=True, text=True, check=False)
    if not done.stdout.strip():
        return {"status": (done.stderr.strip() or "no answer").splitlines()[0]}
    return json.loads(done.stdout)


def row(name, objective, answer):
    stats = answer.get("statistics", {})
    number = lambda value: "-" if value is None else f"{-value:g}"
    print(f"| {name} | {objective} | {answer['status']} | {number(answer.get('reward'))} | "
          f"{number(answer.get('bound'))} | {stats.get('states', '-')} | "
          f"{stats.get('seconds', 0):.2g} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--time-limit", type=float, default=10)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--only", default="", help="cases whose name has this word")
    parser.add_argument("--travel", action="store_true", help="under fleet_travel too")
    options = parser.parse_args()
    print("| case | objective | status | answer | bound | states | seconds |")
    print("|---|---|---|---|---|---|---|")
    objectives = ["makespan"] + (["fleet_travel"] if options.travel else [])
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "problem.json"
        for objective in objectives:
            for case in cases(options.seeds):
                if options.only not in case["name"]:
                    continue
                path.write_text(json.dumps(case))
                answer = solve(options.program, str(path), ["--objective", objective],
                               options.time_limit)
                row(case["name"], objective, answer)
            for robots in (8,):
                name = f"fleet-iss, {robots} robots"
                if options.only in name:
                    more = ["--objective", objective, "--robots", str(robots)]
                    row(name, objective, solve(options.program, "fleet-iss", more,
                                               options.time_limit))
    return 0


if __name__ == "__main__":
    sys.exit(main())
