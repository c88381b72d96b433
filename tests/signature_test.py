#!/usr/bin/env python3
"""Compares what every exact method does on every built-in problem, and the digests of all problem files, with a file.

    tests/signature_test.py PROGRAM            compare with tests/signature.txt
    tests/signature_test.py PROGRAM --update   write it anew

A method that looks at other states than before, in another order or with another bound, has changed, though its answer
may be as right as before. Such a change is either an accident, or is meant and then shows in the file as a difference
that a reader sees. The file holds the searches that end within three seconds of processor time; which those are is
decided when it is written, so write it with a release build.
"""
import json
import os
import resource
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FILE = ROOT / "tests/signature.txt"
# Random steps, trained networks and another program's solver are left out: they are no search of ours.
METHODS = ["auto", "value-iteration", "dijkstra", "bellman-ford", "orasp-search", "a-star", "beam", "and-or", "exhaustive",
           "q-learning", "greedy"]
FLEET_METHODS = ["auto", "fleet-search", "fast", "greedy"]
# Beside the built-in problems: random and regular ones, and objectives that no bound meets at once.
OTHERS = ["chain:10", "grid:3x4", "tree:12:1", "random:8:12:1", "lattice --objective time", "hubble --objective indexed",
          "hubble --objective time", "lattice --objective fuel", "2x3 --objective completion", "grid:3x3 --objective travel",
          "lattice --direction assembly", "hubble --max-moved-parts 2", "2x3 --max-subassemblies 1"]
SECONDS_OF_PROCESSOR = 3


def plan(program, *arguments, limited=False):
    """The plan as JSON with its numbers left as they are written; a message where there is none."""
    def limit():
        if limited:
            resource.setrlimit(resource.RLIMIT_CPU, (SECONDS_OF_PROCESSOR, SECONDS_OF_PROCESSOR + 1))
    done = subprocess.run([program, "solve", *arguments, "--json", "--quiet", "--threads", "2", "--memory-limit", "2000"],
                          capture_output=True, text=True, preexec_fn=limit)
    if not done.stdout:
        return None if done.returncode == 30 else done.stderr or f"ended with {done.returncode}"
    return json.loads(done.stdout, parse_float=str, parse_int=str)


def searched(program, problem, method, limited=False):
    """One line of the file, or nothing where the method refuses the problem or takes too long."""
    found = plan(program, *problem.split(), "--method", method, limited=limited)
    if not isinstance(found, dict) or "stopped" in found and found["stopped"] not in (None, "none"):
        return None
    counts = " ".join(f"{name} {found['statistics'].get(name, 0)}" for name in ("expanded", "generated", "pruned"))
    return f"{problem} --method {method}: {found['status']} {found['reward']}, {counts}"


def problem_files():
    for folder in ("data", "examples"):
        for file in sorted((ROOT / folder).rglob("*.json")):
            if json.loads(file.read_text(encoding="utf-8")).get("format") == "orasp-problem/1":
                yield file.relative_to(ROOT).as_posix()


def digest(program, file):
    problem = str(ROOT / file)  # greedy takes any size, but not attempts that may fail
    found = plan(program, problem, "--method", "greedy") or plan(program, problem, "--time-limit", "5")
    return f"{file}: {found['problem_digest']}"


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--update"]):
        sys.exit(__doc__)
    program = str(Path(sys.argv[1]).resolve())
    update = len(sys.argv) == 3
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        digests = list(pool.map(lambda file: digest(program, file), problem_files()))
        if update:
            scenarios = [row["name"] for row in json.loads(subprocess.run(
                [program, "scenarios", "--json"], capture_output=True, text=True, check=True).stdout) if not row["generator"]]
            pairs = [(problem, method) for problem in scenarios + OTHERS
                     for method in (FLEET_METHODS if problem.startswith("fleet-") else METHODS)]
            lines = pool.map(lambda pair: searched(program, *pair, limited=True), pairs)
            FILE.write_text("\n".join([*digests, "", *filter(None, lines), ""]), encoding="utf-8")
            return
        before = FILE.read_text(encoding="utf-8").splitlines()
        pairs = [line.split(": ")[0].split(" --method ") for line in before[before.index("") + 1:]]
        now = [*digests, "", *pool.map(lambda pair: searched(program, *pair) or " --method ".join(pair) + ": no answer", pairs)]
    if now == before:
        return
    for line in sorted(set(before) - set(now)):
        print("before", line)
    for line in sorted(set(now) - set(before)):
        print("now   ", line)
    sys.exit("The signature has changed. If that was meant: tests/signature_test.py PROGRAM --update")


if __name__ == "__main__":
    main()
