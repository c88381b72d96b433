#!/usr/bin/env python3
"""Measures the program and writes the figures into the documentation.

    benchmarks/measure.py [PROGRAM] [--only SECTION,...] [--limit SECONDS] [--shared FOLDER]

Sections: expansions, bounds, growth, comparison (docs/performance.md, docs/images/growth.svg) and problems
(docs/problems.md, from FOLDER/problems; the default folder is $ORASP_SHARED or ../shared), and, only if named, learning
and ablations (docs/learning.md, from there too; an hour) and paper (docs/paper.md and its figures, all that `orasp paper`
makes; minutes). In the pages each section stands between <!-- begin: SECTION --> and <!-- end: SECTION -->. All take about a quarter of an hour. Standard library
only.
"""
import argparse
import concurrent.futures
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SIZES = {"type": "expression", "formula": "-separates*(moved_parts+kept_parts)"}  # a cut costs what the piece has parts
SCENARIOS = ["3piece", "4brick", "4piece", "2x3", "lattice", "hubble", "hubble-free", "hubble-upc", "iss", "iss-upc",
             "jwst", "jwst-upc"]


# A process of its own, small: what a program was started from counts as its memory, before it is the program.
LAUNCHER = """import resource, subprocess, sys
subprocess.run(sys.argv[1:])
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, file=sys.stderr)
"""


class Run:
    """One run of `orasp solve`: its plan, CPU seconds, greatest resident memory in MiB (at least the launcher's 10).

    `brief`: only how it ended and how long it took, from the table for people: as JSON the steps of thousands of
    connections list millions of parts."""

    def __init__(self, problem, *options, method="auto", objective=None, limit=None, brief=False):
        words = [ARGUMENTS.program, "solve", problem, "--method", method, *options]
        if not brief:
            words += ["--json", "--quiet"]
        if limit is not None:
            words += ["--time-limit", str(limit)]
        if objective is not None:
            words += ["--objective", objective_file(objective)]
        done = subprocess.run([sys.executable, "-S", "-E", "-c", LAUNCHER, *words], stdin=subprocess.DEVNULL,
                              capture_output=True, check=True)
        *error, figures = done.stderr.decode(errors="replace").strip().split("\n")
        self.cpu, self.mebibytes = map(float, figures.split())
        self.error = "\n".join(error)
        text = done.stdout
        if brief:
            status = re.search(r"^status +(\w+)", text.decode(), re.MULTILINE)
            seconds = re.search(r"^effort .* ([\d.e-]+) s(?:,|$)", text.decode(), re.MULTILINE)
            self.plan = status and {"status": status[1], "statistics": {"seconds": float(seconds[1])}}
        else:
            self.plan = json.loads(text) if text else None

    @property
    def seconds(self):
        return self.plan["statistics"]["seconds"]

    @property
    def settled(self):
        return self.plan is not None and self.plan["status"] in ("optimal", "infeasible")


def objective_file(objective):
    if isinstance(objective, str):
        return objective
    path = Path(SCRATCH.name) / "objective.json"
    path.write_text(json.dumps(objective), encoding="utf-8")
    return str(path)


def figure(value):
    """Three significant digits, thousands separated."""
    if value == 0:
        return "0"
    digits = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:,.{digits}f}"


def limit_of_runs():
    return f"Time limit of each run: {ARGUMENTS.limit:g} s."


def table(head, rows):
    lines = ["| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *rows]]
    return "\n".join(lines)


def write_section(page, section, text):
    path = ROOT / page
    old = path.read_text(encoding="utf-8")
    pattern = re.compile(rf"(<!-- begin: {section} -->\n).*?(<!-- end: {section} -->)", re.DOTALL)
    if not pattern.search(old):
        sys.exit(f"{page} has no section {section}")
    path.write_text(pattern.sub(lambda match: match[1] + "\n" + text + "\n\n" + match[2], old), encoding="utf-8")
    print(f"{page}: {section}", flush=True)


# ---------------------------------------------------------------------------------------------------------------------

def effort(run):
    """States expanded and milliseconds; where it was stopped, `>` and the gap."""
    if run.plan is None:
        return "refused"
    statistics = run.plan["statistics"]
    expanded = f"{statistics['expanded']:,}"
    if run.settled:
        return f"{expanded} ({figure(run.seconds * 1e3)} ms)"
    gap = run.plan["gap"]
    return f"> {expanded} (gap {'unknown' if gap is None else figure(gap)})"


def size_of_graph(name):
    """States of H: counted where H is small, 2^n where nothing constrains it, or the estimate of a refusal."""
    spec = json.loads(subprocess.run([ARGUMENTS.program, "scenarios", name], capture_output=True, text=True).stdout)
    if not any(key in spec for key in ("precedence", "limits", "blocking")):
        n = len(spec["connections"])
        return f"{2 ** n:,}" if n < 40 else f"2^{n}"
    run = Run(name, method="value-iteration", limit=ARGUMENTS.limit)
    if run.plan is not None and run.settled:
        return f"{run.plan['statistics']['states']:,}"
    if run.plan is not None:
        return f"> {run.plan['statistics']['states']:,}"
    found = re.search(r"graph: (?:about )?(\S+) states", run.error)
    return f"about {found[1]}" if found else "?"


def expansions():
    columns = [("value-iteration", None)]
    columns += [(method, bound) for method in ("orasp-search", "a-star", "beam")
                for bound in ("none", "connections", "sizes")]
    columns += [("and-or", None), ("auto", None)]
    head = ["method, bound"] + SCENARIOS
    rows = [["states of H"] + [size_of_graph(name) for name in SCENARIOS]]
    for method, bound in columns:
        options = [] if bound is None else ["--bound", bound]
        row = [f"`{method}`" + ("" if bound is None else f", {bound}")]
        for name in SCENARIOS:
            row.append(effort(Run(name, *options, method=method, limit=ARGUMENTS.limit)))
        rows.append(row)
        print(" ".join(row), file=sys.stderr, flush=True)
    half = len(SCENARIOS) // 2 + 1
    parts = [table(["method, bound"] + SCENARIOS[:half - 1], [row[:half] for row in rows]),
             table(["method, bound"] + SCENARIOS[half - 1:], [row[:1] + row[half:] for row in rows])]
    write_section("docs/performance.md", "expansions", limit_of_runs() + "\n\n" + "\n\n".join(parts))


def bounds():
    cases = [("hubble-free", "time"), ("grid:3x4", "time"), ("grid:3x4", "travel"), ("grid:3x4", "fuel"),
             ("grid:3x4", "completion"), ("grid:3x4", "indexed"), ("iss", "fuel"), ("grid:4x4", SIZES)]
    names = ["none", "connections", "sizes", "parts", "best"]
    rows = []
    for problem, objective in cases:
        row = [f"`{problem}`, " + (f"`{objective}`" if isinstance(objective, str) else "size of the piece")]
        row += [effort(Run(problem, "--bound", bound, "--memory-limit", "4096", method="a-star", objective=objective,
                           limit=ARGUMENTS.limit)) for bound in names]
        rows.append(row)
        print(" ".join(row), file=sys.stderr, flush=True)
    write_section("docs/performance.md", "bounds",
                  limit_of_runs() + "\n\n" + table(["problem, objective"] + names, rows))


# ---------------------------------------------------------------------------------------------------------------------

SERIES = [  # name, colour, gnuplot's full and hollow mark, method, objective
    ("auto, cubesat", "#1b6ca8", 7, 6, "auto", None),
    ("auto, size of the piece", "#7b3fa0", 13, 12, "auto", SIZES),
    ("a-star, cubesat", "#c4561b", 5, 4, "a-star", None),
    ("beam, cubesat", "#2c8a4b", 9, 8, "beam", None),
    ("value-iteration, cubesat", "#444444", 11, 10, "value-iteration", None),
]
FAMILIES = [
    ("chains", [f"chain:{n + 1}" for n in (4, 8, 12, 16, 20, 24, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192,
                                        16000)]),
    ("grids", [f"grid:{r}x{c}" for r, c in ((2, 2), (2, 3), (3, 3), (3, 4), (3, 5), (4, 4), (5, 5), (6, 6), (8, 8),
                                            (11, 11), (16, 16), (23, 23), (32, 32), (46, 46), (64, 64), (90, 90))]),
    ("trees", [f"tree:{n + 1}:1" for n in (4, 8, 12, 16, 20, 24, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16000)]),
]
MOST_AS_JSON = 1100  # connections


def connections_of(problem):
    kind, *numbers = re.split(r"[:x]", problem)
    if kind == "grid":
        r, c = map(int, numbers)
        return r * (c - 1) + c * (r - 1)
    return int(numbers[0]) - 1


def growth():
    points = {}
    for family, problems in FAMILIES:
        for name, _, _, _, method, objective in SERIES:
            line = points[family, name] = []
            for problem in problems:
                run = Run(problem, method=method, objective=objective, limit=ARGUMENTS.limit,
                          brief=connections_of(problem) > MOST_AS_JSON)
                print(family, name, problem, run.plan and (run.plan["status"], run.seconds), round(run.mebibytes),
                      file=sys.stderr, flush=True)
                if run.plan is None:
                    break  # H does not fit
                line.append((connections_of(problem), max(run.seconds, 1e-6), run.mebibytes, run.settled))
                if not run.settled:
                    break
    (ROOT / "docs/images/growth.svg").write_text(drawn(points), encoding="utf-8")
    rows = []
    for family, _ in FAMILIES:
        for name, *_ in SERIES:
            proved = [point for point in points[family, name] if point[3]]
            if not proved:
                rows.append([family, name, "none", "", ""])
                continue
            n, seconds, mebibytes, _ = proved[-1]
            rows.append([family, name, f"{n:,}", figure(seconds), figure(mebibytes)])
    head = ["family", "method, objective", "most connections proved", "seconds", "MiB of the process"]
    write_section("docs/performance.md", "growth",
                  "![Time and memory against the number of connections, for chains, grids and trees](images/growth.svg)\n\n"
                  + f"Hollow: stopped after {ARGUMENTS.limit:g} s without a proof. Small problems: the memory of any process.\n\n"
                  + limit_of_runs() + "\n\n" + table(head, rows))


def drawn(points):
    """An SVG of two rows (seconds, MiB) and a column a family, both axes logarithmic, by gnuplot."""
    script = ["set encoding utf8",
              'set terminal svg size 900,540 fixed font "Helvetica,11" background rgb "white"',
              "set multiplot layout 2,3 margins 0.095,0.985,0.17,0.93 spacing 0.03,0.05",
              "set logscale xy", "set xrange [3:24000]", "set border 3 lc rgb '#57606a' lw 0.8", "unset key",
              "set tics nomirror out scale 0.6", "set grid lc rgb '#eaeef2' lw 0.8 lt 1"]
    for f, (family, _) in enumerate(FAMILIES):
        for i, (name, *_) in enumerate(SERIES):
            line = points[family, name]
            for kind, chosen in (("line", line), ("full", [point for point in line if point[3]]),
                                 ("hollow", [point for point in line if not point[3]])):
                rows = [f"{n} {seconds} {mebibytes}" for n, seconds, mebibytes, _ in chosen]
                script += [f"$f{f}s{i}{kind} << EOD", *(rows or ["NaN NaN NaN"]), "EOD"]
    for i, (name, colour, full, *_) in enumerate(SERIES):
        script.append(f"set label {i + 1} '{name}' at screen {0.07 + 0.188 * i:.3f},0.035 offset 1 "
                      f"point pt {full} ps 0.7 lc rgb '{colour}'")
    panels = [("seconds", 2, "1e-5:30", {1e-5: "10 µs", 1e-4: "0.1 ms", 1e-3: "1 ms", 1e-2: "10 ms", 0.1: "0.1 s",
                                         1: "1 s", 10: "10 s"}),
              ("MiB of the process", 3, "4:8192", {n: f"{n:,}" for n in (4, 16, 64, 256, 1024, 4096)})]
    for row, (unit, column, span, names) in enumerate(panels):
        for f, (family, _) in enumerate(FAMILIES):
            ticks = ", ".join(f"'{text if f == 0 else ''}' {value}" for value, text in names.items())
            places = ", ".join(f"'{n if row == 1 else ''}' {n}" for n in (4, 32, 256, 2048, 16384))
            plots = []
            for i, (_, colour, full, hollow, *_) in enumerate(SERIES):
                for kind, look in (("line", "lines lw 1.4"), ("full", f"points pt {full} ps 0.6"),
                                   ("hollow", f"points pt {hollow} ps 0.8 lw 1.4")):
                    plots.append(f"$f{f}s{i}{kind} using 1:{column} with {look} lc rgb '{colour}'")
            script += [f"set yrange [{span}]", f"set ytics ({ticks})", f"set xtics ({places})",
                       f"set title '{family if row == 0 else ''}'",
                       f"set ylabel '{unit if f == 0 else ''}' offset 1",
                       f"set xlabel '{'connections' if row == 1 else ''}'", "plot " + ", ".join(plots),
                       "unset label"]
    done = subprocess.run(["gnuplot", "-d"], input="\n".join(script) + "\n", capture_output=True, text=True, check=True)
    return done.stdout.replace('font-family="Helvetica"', 'font-family="Helvetica,Arial,sans-serif"')


# ---------------------------------------------------------------------------------------------------------------------

# CPU seconds of Fast Downward with A* and merge-and-shrink on the same problems, measured apart (not by this script).
FAST_DOWNWARD = {"lattice": 0.12, "hubble": 0.17, "hubble-free": 0.34, "iss": 39}


def comparison():
    rows = []
    for name, theirs in FAST_DOWNWARD.items():
        runs = [Run(name) for _ in range(20)]
        assert all(run.settled for run in runs)
        rows.append([f"`{name}`", figure(min(run.seconds for run in runs)), figure(min(run.cpu for run in runs)),
                     figure(theirs)])
    head = ["problem", "`orasp solve`: solving, s", "`orasp solve`: CPU of the process, s",
            "Fast Downward: CPU, s"]
    write_section("docs/performance.md", "comparison", table(head, rows))


SEEDS = range(1, 6)


def trainings(problem, limit, options=()):
    """One training for each seed, two at a time: (what its policy earns, seconds)."""
    def train(seed):
        done = subprocess.run([ARGUMENTS.program, "train", problem, "--seed", str(seed), "--time-limit", str(limit), "--quiet",
                               "--json", *options], stdin=subprocess.DEVNULL, capture_output=True, check=False)
        outcome = json.loads(done.stdout)
        return outcome["policy_reward"], outcome["seconds"]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return list(pool.map(train, SEEDS))


def fuel_problem():
    """hubble-upc with random masses: what a step earns is no linear function of anything."""
    scenario = subprocess.run([ARGUMENTS.program, "scenarios", "hubble-upc"], capture_output=True, check=True).stdout
    problem = json.loads(scenario)
    masses = random.Random(1)
    for part in problem["parts"]:
        part["mass"] = round(masses.uniform(1, 200), 1)
    problem["objective"] = {"type": "fuel"}
    path = Path(SCRATCH.name) / "hubble-upc-fuel.json"
    path.write_text(json.dumps(problem), encoding="utf-8")
    return str(path)


def learned_problems():
    """(name, problem, limit of a training in seconds)."""
    rows = [("hubble-upc", "hubble-upc", 60), ("iss-upc", "iss-upc", 120), ("jwst-upc", "jwst-upc", 300),
            ("hubble-upc, fuel", fuel_problem(), 60)]
    for name in ["furniture/bookcase_billy_0190", "furniture/bed_dalselv_0270", "furniture/desk_hannes_0529",
                 "lego/lego-013", "lego/lego-001", "lego/lego-045"]:
        path = Path(ARGUMENTS.shared) / "problems" / f"{name}.json"
        if not path.exists():
            sys.exit(f"no file {path}; name the folder that holds problems/ with --shared or ORASP_SHARED")
        rows.append((path.stem, str(path), 60))
    return rows


def reached(reward, best):
    return reward >= best - 1e-9 * max(1, abs(best))


def learning():
    rows = []
    for name, problem, limit in learned_problems():
        best = Run(problem, limit=60).plan
        sample = json.loads(subprocess.run([ARGUMENTS.program, "sample", problem, "--json", "--quiet"], capture_output=True,
                                           check=True).stdout)
        outcomes = trainings(problem, limit)
        rewards = sorted(reward for reward, _ in outcomes)
        seconds = sorted(seconds for _, seconds in outcomes)
        plain = [sample["mean"], sample["max"], Run(problem, method="greedy").plan["reward"], rewards[0], rewards[2],
                 best["reward"]]
        rows.append([name, str(len(best["disassembly"])), *(f"{reward:.4f}" for reward in plain),
                     f"{sum(reached(reward, best['reward']) for reward in rewards)} of 5",
                     f"{figure(seconds[2])}, {figure(seconds[-1])}"])
        if best["status"] != "optimal":
            rows[-1][7] += " (not proved)"
        print(" ".join(rows[-1]), file=sys.stderr, flush=True)
    head = ["problem", "connections", "random: mean", "best of 100", "`greedy`", "policy: worst seed", "median", "optimum",
            "seeds there", "s: median, most"]
    write_section("docs/learning.md", "learning", table(head, rows))


VARIANTS = [
    ("as it is", []),
    ("without double Q", ["--no-double-q"]),
    ("targets of one step", ["--n-step", "1"]),
    ("targets of all steps", ["--n-step", "0"]),
    ("returns not as lower bounds", ["--no-returns"]),
    ("without imitation", ["--imitation", "0"]),
    ("rewards not known", ["--no-known-reward"]),
    ("rewards not scaled", ["--no-scaling"]),
    ("without the curriculum", ["--curriculum", "0"]),
    ("four gradient steps a step", ["--updates-per-step", "4"]),
    ("31 exploring episodes at a time", ["--environments", "31", "--updates-per-step", "4"]),
    ("one exploring episode at a time", ["--environments", "1"]),
    ("the paper's, with masks", ["--no-double-q", "--n-step", "1", "--no-returns", "--imitation", "0", "--no-known-reward",
                                 "--no-scaling", "--environments", "1"]),
]


def ablations():
    chosen = ["hubble-upc", "iss-upc", "bookcase_billy_0190", "bed_dalselv_0270", "lego-001"]
    problems = [row for row in learned_problems() if row[0] in chosen]
    bests = {name: Run(problem, limit=60).plan["reward"] for name, problem, _ in problems}
    rows = []
    for title, options in VARIANTS:
        rows.append([title])
        hits_of_all = 0
        for name, problem, _ in problems:
            outcomes = trainings(problem, 30, options)
            hits = sum(reached(reward, bests[name]) for reward, _ in outcomes)
            hits_of_all += hits
            gap = sum(bests[name] - reward for reward, _ in outcomes) / len(outcomes)
            rows[-1].append(f"{hits}, {gap:.3f}, {figure(sorted(seconds for _, seconds in outcomes)[2])} s")
        rows[-1].append(f"{hits_of_all} of {5 * len(problems)}")
        print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    write_section("docs/learning.md", "ablations", table(["variant", *(name for name, _, _ in problems), "in all"], rows))


def problems():
    folder = Path(ARGUMENTS.shared) / "problems"
    if not folder.is_dir():
        sys.exit(f"no folder {folder}; name the one that holds problems/ with --shared or ORASP_SHARED")
    texts = []
    for kind in ("lego", "furniture"):
        rows = []
        total = proved = 0
        for path in sorted((folder / kind).glob("*.json")):
            spec = json.loads(path.read_text(encoding="utf-8"))
            run = Run(str(path), limit=60)
            plan = run.plan
            total += run.seconds
            proved += run.settled
            reward = "" if plan["reward"] is None else f"{plan['reward']:.4f}"
            status = plan["status"] + ("" if run.settled or plan["gap"] is None else f" (gap {figure(plan['gap'])})")
            rows.append([path.stem, str(len(spec["parts"])), str(len(spec["connections"])), reward, status,
                         figure(run.seconds)])
            print(" ".join(rows[-1]), file=sys.stderr, flush=True)
        texts.append(f"## {kind.capitalize()}\n\n{len(rows)} files, {proved} proved, {figure(total)} s in all.\n\n"
                     + table(["file", "parts", "connections", "reward", "status", "seconds"], rows))
    write_section("docs/problems.md", "problems", "\n\n".join(texts))


def paper():
    folder = Path(SCRATCH.name) / "paper"
    subprocess.run([ARGUMENTS.program, "paper", "-o", str(folder)], check=True)
    images = ROOT / "docs/images/paper"
    shutil.rmtree(images, ignore_errors=True)
    shutil.copytree(folder / "figures", images)
    text = (folder / "paper.md").read_text(encoding="utf-8").replace("](figures/", "](images/paper/")
    (ROOT / "docs/paper.md").write_text(text, encoding="utf-8")
    print("docs/paper.md", flush=True)


SECTIONS = {"expansions": expansions, "bounds": bounds, "growth": growth, "comparison": comparison,
            "problems": problems, "learning": learning, "ablations": ablations, "paper": paper}
LONG = ["learning", "ablations", "paper"]

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default=str(ROOT / "build/release/orasp"))
    parser.add_argument("--only", default=",".join(name for name in SECTIONS if name not in LONG),
                        help="sections, joined by commas")
    parser.add_argument("--limit", type=float, default=10, help="seconds of each run (default: 10)")
    parser.add_argument("--shared", default=os.environ.get("ORASP_SHARED", str(ROOT.parent / "shared")))
    ARGUMENTS = parser.parse_args()
    SCRATCH = tempfile.TemporaryDirectory()
    for section in ARGUMENTS.only.split(","):
        if section not in SECTIONS:
            sys.exit(f'no section "{section}"; there are {", ".join(SECTIONS)}')
        SECTIONS[section]()
