#!/usr/bin/env python3
"""Measures policies for products they have not seen (docs/learning.md, "One policy for many products").

    benchmarks/generalise.py ORASP trees
    benchmarks/generalise.py ORASP positions
    benchmarks/generalise.py ORASP FOLDER [--folds 5] [--only FOLD]

`trees` learns from random trees and grids of 10 to 30 parts under -separates*(moved_parts+kept_parts) and asks about trees and
grids of 60 to 200 parts. `positions` learns under time, with positions at random and the limits 4 and 3, from products of 8 to 38
parts and asks about three of 144 to 300. FOLDER holds problem files: cross-validation under cubesat. Prints a line for each problem asked, and how
far the policy and greedy are from the optimum, which auto proves.
"""
import argparse
import json
import random
import subprocess
import sys
import tempfile
from pathlib import Path

FORMULA = '{"type": "expression", "formula": "-separates*(moved_parts+kept_parts)"}'
TRAIN = [f"tree:{parts}:{parts}" for parts in range(10, 31)] + [f"tree:{parts}:{parts + 100}" for parts in range(10, 31)] + [
    "grid:2x5", "grid:3x4", "grid:2x7", "grid:3x5", "grid:4x4", "grid:3x6", "grid:4x5", "grid:3x7", "grid:5x5", "grid:4x6", "grid:5x6"]
ASK = [f"tree:{parts}:7" for parts in range(60, 201, 10)] + ["grid:6x10", "grid:8x8", "grid:8x10", "grid:10x10", "grid:10x14", "grid:14x14"]

PLACED = ([f"chain:{parts}" for parts in (8, 12, 16, 20, 24, 30)]
          + [f"tree:{parts}:{parts}" for parts in (8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 34, 38)]
          + [f"tree:{parts}:{parts + 50}" for parts in (12, 16, 20, 24, 28)]
          + [f"grid:{size}" for size in ("2x4", "3x3", "3x4", "3x5", "4x4", "3x6", "4x5", "5x5", "4x6", "2x8", "3x7", "5x6")])
ASK_PLACED = ["chain:200", "tree:300:7", "grid:12x12"]


def placed(orasp, folder, name, seed):
    """The file of a problem under time, its parts at random in a cube of 10 m."""
    problem = json.loads(subprocess.run([orasp, "scenarios", name], check=True, capture_output=True, text=True).stdout)
    draw = random.Random(seed)
    for part in problem["parts"]:
        part["position"] = [round(draw.uniform(-5, 5), 3) for _ in range(3)]
    problem["limits"] = {"max_subassemblies": 4, "max_moved_parts": 3}
    problem["objective"] = {"type": "time"}
    file = Path(folder) / f"{name.replace(':', '-')}-{seed}.json"
    file.write_text(json.dumps(problem), encoding="utf-8")
    return str(file)


def reward(orasp, problem, objective, *arguments):
    command = [orasp, "solve", problem, "--objective", objective, "--json", "--quiet", *arguments]
    answer = json.loads(subprocess.run(command, check=False, capture_output=True, text=True).stdout)
    return answer


def measure(orasp, train, ask, objective, seed, limit):
    with tempfile.TemporaryDirectory() as folder:
        policy = str(Path(folder) / "policy.pt")
        done = subprocess.run([orasp, "train", "--problems", *train, "--objective", objective, "-o", policy, "--quiet", "--json", "--seed",
                               str(seed)], check=True, capture_output=True, text=True)
        print(done.stdout.strip(), flush=True)
        rows = []
        for problem in ask:
            best = reward(orasp, problem, objective, "--time-limit", str(limit), "--threads", "1")
            mine = reward(orasp, problem, objective, "--method", "dqn", "--policy", policy)
            greedy = reward(orasp, problem, objective, "--method", "greedy")
            rows.append((problem, best, mine, greedy))
            print(f"{Path(problem).stem:12} {best['status']:9} best {best['reward']:12.4f} bound {best['bound'] or 0:12.4f} "
                  f"policy {mine['reward']:12.4f} greedy {greedy['reward']:12.4f}", flush=True)
        return rows


def summarise(rows):
    def gap(row, which):
        known = row[1]["reward"]
        return max(0.0, known - row[which]["reward"]) / max(1e-9, abs(known))

    print(f"{len(rows)} asked, {sum(row[1]['status'] == 'optimal' for row in rows)} proved; mean distance: policy "
          f"{100 * sum(gap(r, 2) for r in rows) / len(rows):.2f} %, greedy {100 * sum(gap(r, 3) for r in rows) / len(rows):.2f} %; "
          f"most: policy {100 * max(gap(r, 2) for r in rows):.2f} %")
    behind = [r for r in rows if gap(r, 3) > 1e-6]
    print(f"policy at least as good as greedy: {sum(gap(r, 2) <= gap(r, 3) + 1e-6 for r in rows)} of {len(rows)}; better where greedy "
          f"is not optimal: {sum(gap(r, 2) < gap(r, 3) - 1e-6 for r in behind)} of {len(behind)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("orasp")
    parser.add_argument("problems")
    parser.add_argument("--folds", type=int, default=5)
    parser.add_argument("--only", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=10)
    chosen = parser.parse_args()
    if chosen.problems == "trees":
        with tempfile.NamedTemporaryFile("w", suffix=".json") as objective:
            objective.write(FORMULA)
            objective.flush()
            summarise(measure(chosen.orasp, TRAIN, ASK, objective.name, chosen.seed, chosen.limit))
        return
    if chosen.problems == "positions":
        with tempfile.TemporaryDirectory() as folder:
            train = [placed(chosen.orasp, folder, name, 100 + i) for i, name in enumerate(PLACED)]
            ask = [placed(chosen.orasp, folder, name, 1) for name in ASK_PLACED]
            for name, best, mine, greedy in measure(chosen.orasp, train, ask, "time", chosen.seed, chosen.limit):
                gap = best["bound"] - greedy["reward"]
                print(f"{Path(name).stem}: {100 * (mine['reward'] - greedy['reward']) / gap:.0f} % of the gap of greedy")
        return
    files = sorted(str(file) for file in Path(chosen.problems).glob("*.json"))
    rows = []
    for fold in range(chosen.folds) if chosen.only is None else [chosen.only]:
        ask = files[fold::chosen.folds]
        rows += measure(chosen.orasp, [file for file in files if file not in ask], ask, "cubesat", chosen.seed, chosen.limit)
    summarise(rows)


if __name__ == "__main__":
    sys.exit(main())
