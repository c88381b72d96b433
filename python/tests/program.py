"""What the tests of the package share: the command line to compare with, and random problems."""
import json
import os
import random
import subprocess
from pathlib import Path

PROGRAM = os.environ["ORASP_PROGRAM"]
ROOT = Path(__file__).resolve().parent.parent.parent


def run(*arguments, stdin=None):
    """The exit code, standard output and standard error of `orasp`."""
    done = subprocess.run([PROGRAM, *arguments], input=stdin, capture_output=True, text=True, timeout=300, check=False)
    return done.returncode, done.stdout, done.stderr


def sentence(stderr):
    """The sentence of an error of the program."""
    lines = [line for line in stderr.splitlines() if not line.startswith("orasp: warning:")]
    return "\n".join(lines).removeprefix("orasp: ")


def without_times(value):
    """A JSON document without what takes time and memory, which differ from run to run."""
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key not in ("seconds", "peak_bytes", "reweighing")}
    if isinstance(value, list):
        return [without_times(item) for item in value]
    return value


def parsed(text):
    return without_times(json.loads(text))


OBJECTIVES = ("cubesat", "custom", "cubesat_zone", "time", "completion", "indexed",
              {"type": "piece_cost", "operation": 0.5, "pieces": {"1": 1, "2": 2.5}},
              {"type": "expression", "formula": "-moved_mass - 0.1 * duration * before"},
              {"type": "sum", "terms": [{"weight": 2, "type": "cubesat"}, {"weight": 0.5, "type": "time"}]})


def random_problem(seed):
    """A small problem with random parts, connections, constraints and objective, as a dict. Often it has no plan."""
    draw = random.Random(seed)
    parts = [{"id": f"p{i}", "mass": draw.choice([1, 2, 0.5, 3.25]), "position": [draw.randint(0, 4) for _ in range(3)]}
             for i in range(draw.randint(2, 6))]
    connections = []
    for i in range(1, len(parts)):
        connections.append([f"p{draw.randrange(i)}", f"p{i}"])
    for _ in range(draw.randint(0, 3)):
        connections.append(sorted(draw.sample([part["id"] for part in parts], 2)))
    problem = {
        "format": "orasp-problem/1",
        "name": f"random {seed}",
        "parts": parts,
        "connections": [{"id": f"c{i}", "parts": ends, "duration": draw.randint(1, 9)} for i, ends in enumerate(connections)],
        "objective": draw.choice(OBJECTIVES),
        "direction": draw.choice(["disassembly", "disassembly", "assembly"]),
    }
    if isinstance(problem["objective"], str):
        problem["objective"] = {"type": problem["objective"]}
    ids = [connection["id"] for connection in problem["connections"]]
    if draw.random() < 0.5:
        problem["precedence"] = [{"connection": (pair := draw.sample(ids, 2))[0], draw.choice(["after", "after_any"]): [pair[1]]}
                                 for _ in range(draw.randint(1, 3)) if len(ids) > 1]
    if draw.random() < 0.4:
        problem["limits"] = {"max_moved_parts": draw.randint(1, 3)}
    if draw.random() < 0.3:
        problem.setdefault("limits", {})["max_subassemblies"] = draw.randint(1, 2)
    if draw.random() < 0.3:
        a, b = draw.sample([part["id"] for part in parts], 2)
        problem["blocking"] = {"directions": ["+x", "-x", "+y", "-y"],
                               "blocked": [{"part": a, "by": b, "directions": draw.sample(["+x", "-x", "+y"], 2)}]}
    if draw.random() < 0.15:
        problem["base"] = [parts[0]["id"]]
    return problem


def program_answer_of_training(*arguments):
    """What `orasp train --json` says."""
    return json.loads(run("train", *arguments, "--json")[1])
