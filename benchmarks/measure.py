#!/usr/bin/env python3
"""Measures the program and writes the figures into the documentation.

    benchmarks/measure.py [PROGRAM] [--only SECTION,...] [--limit SECONDS] [--shared FOLDER]

Sections: expansions, bounds, growth, comparison (docs/performance.md, docs/images/growth.svg) and problems
(docs/problems.md, from FOLDER/problems; the default folder is $ORASP_SHARED or ../shared), and, only if named, learning
and ablations (docs/learning.md, from there too; an hour). In the pages each section stands between <!-- begin: SECTION --> and <!-- end: SECTION -->. All take about a quarter of an hour. Standard library
only.
"""
import argparse
import concurrent.futures
import json
import math
import os
import random
import re
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
    """One run of `orasp solve`: its plan, CPU seconds, greatest resident memory in MiB (at least the launcher's 10)."""

    def __init__(self, problem, *options, method="auto", objective=None, limit=None):
        words = [ARGUMENTS.program, "solve", problem, "--method", method, "--json", "--quiet", *options]
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

SERIES = [  # name, colour, mark, method, objective
    ("auto, cubesat", "#1b6ca8", "circle", "auto", None),
    ("auto, size of the piece", "#7b3fa0", "diamond", "auto", SIZES),
    ("a-star, cubesat", "#c4561b", "square", "a-star", None),
    ("beam, cubesat", "#2c8a4b", "triangle", "beam", None),
    ("value-iteration, cubesat", "#444444", "wedge", "value-iteration", None),
]
FAMILIES = [
    ("chains", [f"chain:{n + 1}" for n in (4, 8, 12, 16, 20, 24, 32, 64, 128, 256, 512, 1024)]),
    ("grids", [f"grid:{r}x{c}" for r, c in ((2, 2), (2, 3), (3, 3), (3, 4), (3, 5), (4, 4), (5, 5), (6, 6), (8, 8),
                                            (11, 11), (16, 16), (23, 23))]),
    ("trees", [f"tree:{n + 1}:1" for n in (4, 8, 12, 16, 20, 24, 32, 64, 128, 256, 512, 1024)]),
]


def connections_of(problem):
    kind, *numbers = re.split(r"[:x]", problem)
    if kind == "grid":
        r, c = map(int, numbers)
        return r * (c - 1) + c * (r - 1)
    return int(numbers[0]) - 1


def growth():
    points = {}
    for family, problems in FAMILIES:
        for name, _, _, method, objective in SERIES:
            line = points[family, name] = []
            for problem in problems:
                run = Run(problem, method=method, objective=objective, limit=ARGUMENTS.limit)
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
                  + limit_of_runs() + "\n\n" + table(head, rows))


def drawn(points):
    """An SVG of two rows (seconds, MiB) and a column a family, both axes logarithmic."""
    left, top, width, height, gap = 64, 64, 250, 210, 26
    most_x = (3, 1500)
    total_width = left + 3 * width + 2 * gap + 16
    total_height = top + 2 * height + gap + 50 + 62
    title = "Time and memory against the number of connections"
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total_width} {total_height}" '
           'font-family="sans-serif" font-size="12" fill="#222">',
           f'<rect width="{total_width}" height="{total_height}" fill="white"/>',
           f'<text x="{left}" y="24" font-size="15" font-weight="bold">{title}</text>']
    rows = [("seconds", 1, (1e-5, 30)), ("MiB of the process", 2, (4, 8192))]

    def scaled(value, least, most, begin, length):
        return begin + length * (math.log10(value) - math.log10(least)) / (math.log10(most) - math.log10(least))

    def power(exponent):
        small = {-5: "10 µs", -4: "0.1 ms", -3: "1 ms", -2: "10 ms", -1: "0.1 s", 0: "1 s", 1: "10 s"}
        return small[exponent]

    for r, (unit, index, (least, most)) in enumerate(rows):
        y0 = top + r * (height + gap)
        ticks = ([(10.0 ** e, power(e)) for e in range(-5, 2)] if index == 1 else
                 [(2.0 ** e, f"{2 ** e:,}") for e in range(2, 14, 2)])
        for f, (family, _) in enumerate(FAMILIES):
            x0 = left + f * (width + gap)
            if r == 0:
                out.append(f'<text x="{x0 + width / 2}" y="{top - 10}" text-anchor="middle" font-size="13">{family}'
                           '</text>')
            out.append(f'<rect x="{x0}" y="{y0}" width="{width}" height="{height}" fill="none" stroke="#999"/>')
            for value, label in ticks:
                y = scaled(value, least, most, y0 + height, -height)
                out.append(f'<line x1="{x0}" y1="{y:.1f}" x2="{x0 + width}" y2="{y:.1f}" stroke="#e4e4e4"/>')
                if f == 0:
                    out.append(f'<text x="{x0 - 6}" y="{y + 4:.1f}" text-anchor="end">{label}</text>')
            for value in (4, 16, 64, 256, 1024):
                x = scaled(value, *most_x, x0, width)
                out.append(f'<line x1="{x:.1f}" y1="{y0}" x2="{x:.1f}" y2="{y0 + height}" stroke="#e4e4e4"/>')
                if r == 1:
                    out.append(f'<text x="{x:.1f}" y="{y0 + height + 16}" text-anchor="middle">{value:,}</text>')
            if r == 1:
                out.append(f'<text x="{x0 + width / 2}" y="{y0 + height + 34}" text-anchor="middle">connections</text>')
            for name, colour, mark, *_ in SERIES:
                line = [(scaled(point[0], *most_x, x0, width),
                         scaled(min(max(point[index], least), most), least, most, y0 + height, -height), point[3])
                        for point in points[family, name]]
                path = " ".join(f"{x:.1f},{y:.1f}" for x, y, _ in line)
                out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6"/>')
                out += [marked(mark, x, y, colour, proved) for x, y, proved in line]
        middle = y0 + height / 2
        out.append(f'<text x="14" y="{middle}" text-anchor="middle" transform="rotate(-90 14 {middle})">{unit}</text>')
    x = left
    y = total_height - 34
    for name, colour, mark, *_ in SERIES:
        out.append(f'<line x1="{x}" y1="{y - 4}" x2="{x + 22}" y2="{y - 4}" stroke="{colour}" stroke-width="1.6"/>')
        out.append(marked(mark, x + 11, y - 4, colour, True))
        out.append(f'<text x="{x + 28}" y="{y}">{name}</text>')
        x += 44 + 6.9 * len(name)
    out.append(f'<text x="{left}" y="{total_height - 10}">Hollow: stopped after {ARGUMENTS.limit:g} s without a proof. '
               'Small problems: the memory of any process.</text>')
    return "\n".join(out) + "\n</svg>\n"


def marked(mark, x, y, colour, filled):
    paint = f'fill="{colour if filled else "white"}" stroke="{colour}" stroke-width="1.4"'
    shapes = {"circle": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.4" {paint}/>',
              "square": f'<rect x="{x - 3.2:.1f}" y="{y - 3.2:.1f}" width="6.4" height="6.4" {paint}/>'}
    corners = {"diamond": [(0, -4.4), (4.4, 0), (0, 4.4), (-4.4, 0)], "triangle": [(0, -4.2), (4, 3.2), (-4, 3.2)],
               "wedge": [(0, 4.2), (4, -3.2), (-4, -3.2)]}
    if mark in shapes:
        return shapes[mark]
    return f'<polygon points="{" ".join(f"{x + dx:.1f},{y + dy:.1f}" for dx, dy in corners[mark])}" {paint}/>'


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
    rows = [("hubble-upc", "hubble-upc", 60), ("iss-upc", "iss-upc", 120), ("jwst-upc", "jwst-upc", 60),
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


SECTIONS = {"expansions": expansions, "bounds": bounds, "growth": growth, "comparison": comparison,
            "problems": problems, "learning": learning, "ablations": ablations}
LONG = ["learning", "ablations"]

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
