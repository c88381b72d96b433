#!/usr/bin/env python3
"""Tests `orasp paper`: its numbers against the exact ones of the reference, its files, its figures.

    tests/cli/paper_test.py PROGRAM [unittest's arguments]
"""
import json
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import xml.dom.minidom
from html.parser import HTMLParser
from pathlib import Path

PROGRAM = ""

# Found by exhaustive search in the published code: states and actions of H, best and worst plan.
SIZES = {
    "3piece": (8, 12, 0.7785, 0.7785),
    "4brick": (8, 12, 0.5570, 0.5450),
    "4piece": (16, 32, 0.5570, 0.5450),
    "2x3": (96, 304, 0.3636, 0.0900),
    "lattice": (1296, 6048, 0.0735, -0.4617),
    "hubble": (12096, 67824, -0.9902, -1.6502),
    "hubble-free": (524288, 4980736, -0.9902, -2.4350),
    "hubble-upc": (243787, 1906095, -0.9902, None),
}
WITHOUT_PRECEDENCE = {"2x3": (128, 448), "lattice": (4096, 24576), "hubble": (524288, 4980736)}
OBJECTIVES = ["cubesat_zone", "custom", "indexed", "time", "fuel", "completion"]
REWARDS = {
    "3piece": (0.831100, -1.700000, 3, -5, -0.400746, 1197),
    "4brick": (0.691000, -4.200000, 3, -6, -0.601120, 1297),
    "4piece": (0.691000, -4.300000, 5, -7, -0.601120, 1296),
    "2x3": (0.497600, -6.600000, 13, -12, -1.001866, 1493),
    "lattice": (0.207500, -10.100000, 34, -20, -1.602985, 1788),
    "hubble": (-0.856200, -21.800000, 91, -38, -3.807090, 2881),
}
OPTIMA = {"4brick": 0.5570, "2x3": 0.3636, "lattice": 0.0735, "hubble-upc": -0.9902, "iss-upc": -2.1506,
          "jwst-upc": -16.7118}
# What the paper prints: (seconds of ORASP Search, value iteration, Dijkstra, Bellman-Ford).
PRINTED_SECONDS = {
    "4brick": (0.001000, 0.002939, 0.001997, 0.001997),
    "2x3": (0.023030, 0.070786, 0.069553, 0.070827),
    "lattice": (0.472041, 1.354401, 1.322265, 1.345777),
    "hubble": (6.284114, 108.454639, 107.847125, 107.877225),
    "table-hemnes": (0.024000, 0.143997, 0.139000, 0.138998),
}
METHODS = ["orasp-search", "value-iteration", "dijkstra", "bellman-ford"]


def paper(folder, *options, **more):
    return subprocess.run([PROGRAM, "paper", "-o", str(folder), *options], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=240, **more)


def rows(markdown, heading, first_cell):
    """Cells of the rows below a heading whose first cell is this one."""
    section = markdown.split(f"\n## {heading}", 1)[1].split("\n## ", 1)[0]
    lines = re.findall(rf"^\| {re.escape(first_cell)} \|.*\|$", section, re.MULTILINE)
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


class Page(HTMLParser):
    """Elements of the page, and whatever it would load."""
    LOADING = {"src", "href", "xlink:href", "data", "poster", "srcset", "action"}

    def __init__(self):
        super().__init__()
        self.elements, self.loaded, self.ids, self.handlers = [], [], [], []

    def handle_starttag(self, tag, attributes):
        self.elements.append(tag)
        for name, value in attributes:
            if name in self.LOADING and not (value or "").startswith("#"):
                self.loaded.append((tag, name, value))
            if name == "id":
                self.ids.append(value)
            if name.startswith("on"):
                self.handlers.append(name)


class Quick(unittest.TestCase):
    """One run of `orasp paper --quick`."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name) / "new" / "paper"
        cls.answer = paper(cls.folder, "--quick", "--json")
        assert cls.answer.returncode == 0, cls.answer.stderr
        cls.numbers = json.loads((cls.folder / "paper.json").read_text(encoding="utf-8"))
        cls.markdown = (cls.folder / "paper.md").read_text(encoding="utf-8")
        cls.html = (cls.folder / "paper.html").read_text(encoding="utf-8")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_the_numbers_are_printed_too(self):
        self.assertEqual(json.loads(self.answer.stdout), self.numbers)

    def by_problem(self, table):
        return {row["problem"]: row for row in self.numbers[table]}

    def test_sizes_and_extreme_plans_are_those_of_the_reference(self):
        sizes = self.by_problem("sizes")
        for problem, (states, actions, best, worst) in SIZES.items():
            with self.subTest(problem=problem):
                row = sizes[problem]
                self.assertEqual((row["states"], row["actions"]), (states, actions))
                self.assertAlmostEqual(row["best"], best, delta=1e-9)
                if worst is not None:
                    self.assertAlmostEqual(row["worst"], worst, delta=1e-9)
                printed, = rows(self.markdown, "From the tree", problem)
                self.assertEqual(printed[1:3], [f"{states:,}", f"{actions:,}"])
                self.assertEqual(printed[6], f"{best:.4f}")
        self.assertEqual(sizes["4brick"]["tree_nodes"], "16")
        for problem in ("lattice", "hubble"):
            self.assertEqual(sizes[problem]["paper_states"], sizes[problem]["states"])
            self.assertEqual(sizes[problem]["paper_actions"], sizes[problem]["actions"])

    def test_rewards_under_other_objectives_are_those_of_the_reference(self):
        rewards = {(row["problem"], row["objective"]): row["reward"] for row in self.numbers["rewards"]}
        for problem, expected in REWARDS.items():
            for objective, reward in zip(OBJECTIVES, expected):
                with self.subTest(problem=problem, objective=objective):
                    self.assertAlmostEqual(rewards[problem, objective], reward, delta=5.1e-7)
            self.assertAlmostEqual(rewards[problem, "cubesat"], SIZES[problem][2], delta=1e-9)

    def test_every_printed_time_stands_beside_ours(self):
        times = {(row["problem"], row["method"]): row for row in self.numbers["times"]}
        self.assertEqual(len(times), 20)
        for problem, printed in PRINTED_SECONDS.items():
            for method, seconds in zip(METHODS, printed):
                with self.subTest(problem=problem, method=method):
                    row = times[problem, method]
                    self.assertEqual(row["paper_seconds"], seconds)
                    self.assertGreater(row["process_seconds"], row["solve_seconds"])
                    self.assertLessEqual(row["least_process_seconds"], row["process_seconds"])
                    self.assertGreater(row["solve_seconds"], 0)
                    self.assertEqual(row["status"], "optimal")
                    line = next(line for line in rows(self.markdown, "Runtimes", problem) if line[1] == method)
                    self.assertEqual(line[2], f"{seconds:.6f}")
                    ratio = float(line[6].replace(",", ""))
                    self.assertTrue(math.isclose(ratio, seconds / row["process_seconds"], rel_tol=0.01, abs_tol=0.5))
        for problem in ("4brick", "2x3", "lattice", "hubble"):
            for method in METHODS:
                self.assertAlmostEqual(times[problem, method]["reward"], SIZES[problem][2], delta=1e-9)
        self.assertEqual([line[2] for line in rows(self.markdown, "Runtimes", "hubble")[4:]], ["5000", "20000"])

    def test_the_integer_program_stands_beside_the_search_on_its_own_problem(self):
        found = {(row["problem"], row["objective"]): row for row in self.numbers["integer_program"]}
        self.assertEqual(len(found), 6)
        # Found by the search for fleets: four steps; 58 with five moves. 20 parts and 4 robots take 5 steps at least.
        for key, reward in {("lattice", "min-time"): -4, ("lattice", "min-travel"): -58, ("hubble", "min-time"): -5}.items():
            with self.subTest(key=key):
                self.assertEqual((found[key]["reward"], found[key]["status"]), (reward, "optimal"))
        self.assertEqual(found["hubble", "min-travel"]["status"], "optimal")
        self.assertNotIn("reward", found["4brick", "min-time"])

    def test_a_constraint_makes_h_smaller_and_changes_the_path(self):
        constraints = self.by_problem("constraints")
        ring = constraints["4piece"]
        self.assertEqual((ring["states_without"], ring["actions_without"]), (16, 32))
        self.assertEqual((ring["states"], ring["actions"]), (12, 20))
        self.assertIn("the best plan, in green, is another", self.markdown)
        for problem, (states, actions) in WITHOUT_PRECEDENCE.items():
            row = constraints[problem]
            self.assertEqual((row["states_without"], row["actions_without"]), (states, actions))
            self.assertEqual((row["states"], row["actions"]), SIZES[problem][:2])
            self.assertGreaterEqual(row["best_without"], row["best"])

    def test_two_objectives_have_two_paths_through_one_h(self):
        first, second = self.numbers["paths"]
        self.assertNotEqual(first["disassembly"], second["disassembly"])
        for path in (first, second):
            self.assertEqual(path["reward"], REWARDS["4piece"][OBJECTIVES.index(path["objective"])])
            self.assertEqual(sorted(path["disassembly"]), ["1-2", "1-4", "2-3", "3-4"])

    def test_growth_follows_the_formulas_and_limits_stay_below(self):
        free = {}
        for row in self.numbers["growth"]:
            n = row["connections"]
            key = row["family"].removesuffix(", limits"), n
            if row["family"].endswith("limits"):
                self.assertLessEqual(row["states"], free[key]["states"])
                continue
            free[key] = row
            self.assertEqual(row["states"], 2 ** n)
            self.assertEqual(row["actions"], n * 2 ** (n - 1))
            self.assertEqual(row["tree_nodes"], sum(math.perm(n, k) for k in range(n + 1)))
        self.assertEqual({family for family, _ in free}, {"chains", "grids", "trees"})
        self.assertIn(("chains", 12), free)

    def test_optima_are_proved_and_nothing_is_above_them(self):
        distributions = self.by_problem("distributions")
        self.assertIn("table-hemnes", distributions)
        for problem, row in distributions.items():
            with self.subTest(problem=problem):
                self.assertEqual(row["status"], "optimal")
                if problem in OPTIMA:
                    self.assertAlmostEqual(row["best"], OPTIMA[problem], delta=1e-9)
                self.assertEqual(len(row["rewards"]), 100)
                self.assertLessEqual(max(row["rewards"]), row["best"] + 1e-9)
                self.assertAlmostEqual(row["mean"], sum(row["rewards"]) / 100)
                self.assertLessEqual(row["greedy"], row["best"] + 1e-9)
                if row["learned"] is not None:
                    self.assertLessEqual(row["learned"], row["best"] + 1e-9)
                    self.assertLessEqual(row["final"], row["learned"] + 1e-9)
        self.assertEqual(distributions["hubble-upc"]["paper_reported"], -1.127)
        self.assertEqual(distributions["hubble-upc"]["paper_replayed"], -1.9118)
        self.assertEqual(distributions["iss-upc"]["paper_replayed"], -3.98)
        self.assertEqual(distributions["jwst-upc"]["paper_reported"], -22.311)
        sample = subprocess.run([PROGRAM, "sample", "lattice", "--json"], capture_output=True, text=True, check=True)
        self.assertEqual(json.loads(sample.stdout)["rewards"], distributions["lattice"]["rewards"])

    def test_learned_plans_stand_there_or_why_not(self):
        learned = [row["learned"] for row in self.numbers["distributions"]]
        if "learning_left_out" in self.numbers:
            self.assertEqual(set(learned), {None})
            self.assertIn("Learned plans are left out", self.markdown)
        else:
            self.assertTrue(any(reward is not None for reward in learned))

    def test_every_figure_that_is_linked_exists_and_is_xml(self):
        linked = re.findall(r"!\[[^\n]*\]\((figures/[\w.-]+)\)", self.markdown)
        self.assertGreaterEqual(len(linked), 20)
        self.assertEqual(len(linked), len(set(linked)))
        files = {f"figures/{path.name}" for path in (self.folder / "figures").iterdir()}
        self.assertEqual(set(linked), files)
        for name in files:
            with self.subTest(figure=name):
                root = xml.dom.minidom.parse(str(self.folder / name)).documentElement
                self.assertEqual(root.tagName, "svg")
        self.assertEqual(self.html.count("<svg"), len(files))
        self.assertEqual(self.html.count("<figcaption>"), len(files))

    def test_the_page_is_small_and_loads_nothing(self):
        self.assertLess(len(self.html), 3_000_000)
        page = Page()
        page.feed(self.html)
        self.assertEqual(page.loaded, [])
        self.assertEqual(page.handlers, [])
        self.assertEqual(set(page.elements) & {"script", "link", "iframe", "object", "embed", "img", "foreignobject"}, set())
        self.assertEqual(len(page.ids), len(set(page.ids)))
        self.assertNotIn("@import", self.html)
        self.assertEqual(re.findall(r"url\((?!#)", self.html), [])

    def test_html_and_markdown_hold_the_same_tables(self):
        tables = len(re.findall(r"^\|---", self.markdown, re.MULTILINE))
        self.assertEqual(self.html.count("<table>"), tables)
        self.assertEqual(self.html.count("<tr>"), len(re.findall(r"^\|", self.markdown, re.MULTILINE)) - tables)


class Words(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)

    def tearDown(self):
        self.temporary.cleanup()

    def refused(self, answer, sentence):
        self.assertEqual(answer.returncode, 30, answer.stderr)
        self.assertRegex(answer.stderr, rf"\Aorasp: [^\n]*{sentence}[^\n]*\n\Z")
        self.assertEqual(answer.stdout, "")

    def test_without_a_name_the_folder_is_called_orasp_paper(self):
        (self.folder / "orasp-paper").write_text("mine")
        self.refused(subprocess.run([PROGRAM, "paper"], capture_output=True, text=True, cwd=self.folder),
                     'cannot make the folder "orasp-paper": there is a file of that name')

    def test_a_file_in_the_place_of_the_folder_is_refused_and_kept(self):
        taken = self.folder / "taken"
        taken.write_text("mine")
        self.refused(paper(taken, "--quick"), 'cannot make the folder ".*taken": there is a file of that name')
        self.assertEqual(taken.read_text(), "mine")

    def test_missing_programs_are_named_with_their_package_at_once(self):
        (self.folder / "bin").mkdir()
        environment = dict(os.environ, PATH=str(self.folder / "bin"))
        self.refused(paper(self.folder / "out", "--quick", env=environment), "dot is missing; .* package graphviz")
        dot = subprocess.run(["sh", "-c", "command -v dot"], capture_output=True, text=True).stdout.strip()
        os.symlink(dot, self.folder / "bin" / "dot")
        self.refused(paper(self.folder / "out", "--quick", env=environment), "gnuplot is missing; .* package gnuplot-nox")

    def test_ctrl_c_ends_it_and_writes_nothing(self):
        # A terminal sends the signal to every process of the group, the programs that are run included.
        for name, effort, whole_group, after in [("alone", [], False, "other objectives"),
                                                 ("group", [], True, "table of runtimes"),
                                                 ("drawing", ["--quick", "--no-learning"], True, "figures")]:
            with self.subTest(name):
                out = self.folder / name
                process = subprocess.Popen([PROGRAM, "paper", "-o", str(out), *effort], stdout=subprocess.PIPE,
                                           stderr=subprocess.PIPE, text=True, start_new_session=True)
                for line in process.stderr:
                    if line == after + "\n":
                        break
                time.sleep(0.05)
                os.killpg(process.pid, signal.SIGINT) if whole_group else process.send_signal(signal.SIGINT)
                result, error = process.communicate(timeout=120)
                self.assertEqual(process.returncode, 20, error)
                self.assertEqual(result, "")
                self.assertEqual(error.splitlines()[-1], "orasp: interrupted; nothing was written")
                self.assertEqual([path for path in out.rglob("*") if path.is_file()], [])


class ReportFigures(unittest.TestCase):
    """`orasp report PROBLEM --svg DIR`: the figures of one problem as files."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)

    def tearDown(self):
        self.temporary.cleanup()

    def drawn(self, *words):
        done = subprocess.run([PROGRAM, "report", *words, "--svg", str(self.folder / "svg")], capture_output=True, text=True,
                              timeout=120)
        names = sorted(path.name for path in (self.folder / "svg").glob("*"))
        for name in names:
            xml.dom.minidom.parse(str(self.folder / "svg" / name))
        return done, names

    def test_figures_alone_and_beside_the_page(self):
        done, names = self.drawn("4piece", "--sample-count", "100")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(names, ["distribution.svg", "growth.svg", "state-graph.svg", "steps.svg", "structure.svg",
                                 "tree.svg"])
        self.assertIn("6 figures", done.stdout)
        page = self.folder / "page.html"
        done, _ = self.drawn("4piece", "-o", str(page))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("<html", page.read_text(encoding="utf-8"))

    def test_the_first_plan_that_breaks_no_rule_is_drawn(self):
        plans = []
        for name, order in [("wrong.txt", ["1-2"]), ("right.txt", ["3-4", "1-2", "2-3"])]:
            plans.append(self.folder / name)
            plans[-1].write_text("\n".join(order))
        done, _ = self.drawn("4brick", *map(str, plans))
        self.assertEqual(done.returncode, 10, done.stderr)
        steps = (self.folder / "svg" / "steps.svg").read_text(encoding="utf-8")
        self.assertIn("1. remove 3&#45;4", steps)

    def test_a_problem_without_a_plan_still_has_a_structure(self):
        done, names = self.drawn("4brick", "--max-moved-parts", "0")
        self.assertEqual(done.returncode, 10, done.stderr)
        self.assertIn("structure.svg", names)
        self.assertNotIn("steps.svg", names)

    def test_a_file_in_the_place_of_the_folder_is_refused(self):
        (self.folder / "svg").write_text("mine")
        done = subprocess.run([PROGRAM, "report", "4brick", "--svg", str(self.folder / "svg")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 30)
        self.assertRegex(done.stderr, r"\Aorasp: cannot make the folder [^\n]*\n\Z")


if __name__ == "__main__":
    PROGRAM = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()
