#!/usr/bin/env python3
"""Other solvers read the models that `orasp solve --method mip --write-model` writes, and find the optimum of `auto`.

    tests/io/mip_file_test.py PROGRAM

CBC's own program (Debian: coinor-cbc) reads both formats; HiGHS, a second opinion, comes with python3-scipy (MPS, through
the reader below) and, where it is installed, with npm's `highs` (LP). What is missing is skipped with a word.
"""
import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import numpy
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_matrix
except ImportError:
    milp = None

PROGRAM = sys.argv[1]
LATTICE = {"1-2": "-x", "2-3": "-x", "1-4": "+y", "2-5": "+y", "3-6": "+y", "4-5": "-x", "5-6": "-x"}


def orasp(*arguments, given=None):
    done = subprocess.run([PROGRAM, *arguments, "--quiet"], input=given, capture_output=True, text=True)
    if done.returncode not in (0, 10):
        raise AssertionError(f"{arguments}: {done.returncode}: {done.stderr}")
    return done.stdout


def raster():
    """Six parts, two by three, and three robots."""
    return json.dumps({
        "format": "orasp-problem/1", "parts": [{"id": str(i)} for i in range(1, 7)],
        "connections": [{"parts": pair.split("-"), "axis": axis} for pair, axis in LATTICE.items()],
        "fleet": {"robots": 3, "depot": [0, 0], "sites": [[1, 0], [-1, -2], [-2, 2]]}})


def cases():
    """Name, words of the command, and the problem on standard input."""
    yield "4brick", ["4brick"], None
    yield "2x3", ["2x3"], None
    yield "4piece, custom", ["4piece", "--objective", "custom"], None
    yield "3piece, no plan", ["3piece", "--max-moved-parts", "0"], None
    yield "fleet, 4 steps", ["-", "--objective", "makespan", "--steps", "4"], raster()
    yield "fleet, travel", ["-", "--objective", "fleet_travel", "--steps", "3"], raster()


def by_cbc(file):
    """The optimum, None where there is no solution."""
    text = subprocess.run(["cbc", file, "-solve"], capture_output=True, text=True, timeout=200).stdout
    if re.search("infeasible", text, re.IGNORECASE):
        return None
    return float(re.search(r"Objective value:\s+(\S+)", text)[1])


def by_scipy(file):
    """The same by HiGHS, from free MPS."""
    rows, columns, objective, entries, right, section, whole = {}, {}, {}, [], {}, "", False
    bounds = {}
    for line in Path(file).read_text(encoding="ascii").splitlines():
        words = line.split()
        if line.startswith("*"):
            continue
        if not line.startswith(" "):
            section = words[0]
        elif section == "ROWS" and words[0] != "N":
            rows[words[1]] = (len(rows), words[0])
        elif section == "COLUMNS" and words[1] == "'MARKER'":
            whole = words[2] == "'INTORG'"
        elif section == "COLUMNS":
            column = columns.setdefault(words[0], (len(columns), whole))[0]
            if words[1] == "objective":
                objective[column] = float(words[2])
            else:
                entries.append((rows[words[1]][0], column, float(words[2])))
        elif section == "RHS":
            right[words[1]] = float(words[2])
        elif section == "BOUNDS":
            low, high = bounds.get(words[2], (0, numpy.inf))
            value = float(words[3]) if len(words) > 3 else 0
            bounds[words[2]] = {"FX": (value, value), "BV": (0, 1), "FR": (-numpy.inf, numpy.inf), "MI": (-numpy.inf, high),
                                "LO": (value, high), "UP": (low, value), "PL": (low, numpy.inf)}[words[0]]
    at = list(zip(*entries))
    matrix = csr_matrix((at[2], (at[0], at[1])), shape=(len(rows), len(columns)))
    low = [right.get(name, 0) if sense in "EG" else -numpy.inf for name, (_, sense) in rows.items()]
    high = [right.get(name, 0) if sense in "EL" else numpy.inf for name, (_, sense) in rows.items()]
    limits = [bounds.get(name, (0, numpy.inf)) for name in columns]
    found = milp([objective.get(c, 0) for c in range(len(columns))], constraints=LinearConstraint(matrix, low, high),
                 bounds=Bounds([b[0] for b in limits], [b[1] for b in limits]),
                 integrality=[int(w) for _, w in columns.values()])
    return found.fun if found.status == 0 else None


def by_npm(file):
    """The same by npm's highs, from the LP format."""
    script = ("require('highs')().then(h => { const r = h.solve(require('fs').readFileSync(process.argv[1], 'utf8'));"
              "console.log(r.Status === 'Optimal' ? r.ObjectiveValue : 'none'); })")
    text = subprocess.run(["node", "-e", script, file], capture_output=True, text=True, timeout=200, check=True).stdout
    return None if text.strip() == "none" else float(text)


def has_npm_highs():
    return shutil.which("node") and subprocess.run(["node", "-e", "require('highs')"], capture_output=True).returncode == 0


class WrittenModels(unittest.TestCase):
    def check(self, solve, ending):
        for name, words, given in cases():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                file = str(Path(folder) / f"model.{ending}")
                size = json.loads(orasp("solve", *words, "--method", "mip", "--write-model", file, "--json", given=given))
                self.assertGreater(size["columns"], 0)
                plan = json.loads(orasp("solve", *words, "--json", given=given))
                best = solve(file)
                if plan["status"] == "infeasible":
                    self.assertIsNone(best)
                else:
                    self.assertEqual(plan["status"], "optimal")
                    reward = plan["reward"] if "reward" in plan else -plan["makespan"]
                    self.assertAlmostEqual(best, -reward, 6)

    @unittest.skipUnless(shutil.which("cbc"), "coinor-cbc is not installed")
    def test_cbc_reads_the_lp_format(self):
        self.check(by_cbc, "lp")

    @unittest.skipUnless(shutil.which("cbc"), "coinor-cbc is not installed")
    def test_cbc_reads_mps(self):
        self.check(by_cbc, "mps")

    @unittest.skipUnless(milp, "python3-scipy is not installed")
    def test_highs_solves_the_mps_model(self):
        self.check(by_scipy, "mps")

    @unittest.skipUnless(has_npm_highs(), "npm's highs is not installed")
    def test_highs_reads_the_lp_format(self):
        self.check(by_npm, "lp")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
