#!/usr/bin/env python3
"""No wrong plan leaves the program, by any way: text, --json, -o, replan, compare, report.

    tests/cli/false_methods_test.py PROGRAM

PROGRAM is the command line linked with methods that answer wrongly (tests/cli/false_methods.cpp).
"""
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM = ""
INTERNAL_ERROR = 40
# A line of three connections, of which the first must go first: the opposite order breaks a rule.
PROBLEM = {
    "format": "orasp-problem/1",
    "parts": [{"id": part} for part in "abcd"],
    "connections": [{"parts": ["a", "b"]}, {"parts": ["b", "c"]}, {"parts": ["c", "d"]}],
    "precedence": [{"connection": "b-c", "after": ["a-b"]}, {"connection": "c-d", "after": ["b-c"]}],
}


class FalseMethods(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.problem = self.folder / "problem.json"
        self.problem.write_text(json.dumps(PROBLEM), encoding="utf-8")

    def run_program(self, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=120)

    def expect_refused(self, *arguments, says):
        before = sorted(self.folder.iterdir())
        done = self.run_program(*arguments)
        self.assertEqual(done.returncode, INTERNAL_ERROR, done.stdout + done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, "internal error: .* returned a plan that " + says)
        self.assertEqual(sorted(self.folder.iterdir()), before, "a file was left behind")

    def test_an_honest_method_is_let_through(self):
        output = self.folder / "plan.json"
        done = self.run_program("solve", self.problem, "--method", "greedy", "-o", output)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(output.exists())

    def test_solve(self):
        for method, says in (("unfinished", "breaks a rule"), ("backwards", "breaks a rule"), ("boastful", "earns")):
            for more in ([], ["--json"], ["-o", self.folder / "plan.json"], ["--json", "-o", self.folder / "plan.json"]):
                with self.subTest(method=method, more=more):
                    self.expect_refused("solve", self.problem, "--method", method, *more, says=says)

    def test_solve_in_assembly(self):
        for method, says in (("unfinished", "breaks a rule"), ("backwards", "breaks a rule"), ("boastful", "earns")):
            with self.subTest(method=method):
                self.expect_refused("solve", self.problem, "--direction", "assembly", "--method", method, says=says)

    def test_fleets(self):
        for method, says in (("unfinished", "breaks a rule"), ("boastful", "earns")):
            for objective in ("makespan", "fleet_travel"):
                for more in ([], ["--json"], ["-o", self.folder / "plan.json"]):
                    with self.subTest(method=method, objective=objective, more=more):
                        self.expect_refused("solve", "fleet-lattice", "--objective", objective, "--method", method, *more,
                                            says=says)

    def test_compare(self):
        for method, says in (("unfinished", "breaks a rule"), ("backwards", "breaks a rule"), ("boastful", "earns")):
            for more in ([], ["--json"], ["--csv"], ["--markdown", "-o", self.folder / "table"]):
                with self.subTest(method=method, more=more):
                    self.expect_refused("compare", self.problem, "--methods", method, *more, says=says)
        self.expect_refused("compare", "fleet-lattice", "--methods", "boastful", says="earns")

    def test_replan_and_report(self):
        plan = self.folder / "plan.json"
        for more in ([], ["--json"], ["-o", plan], ["--removed", "a-b", "-o", plan]):
            with self.subTest(more=more):
                self.expect_refused("replan", self.problem, *more, says="breaks a rule")
        self.expect_refused("report", self.problem, "-o", self.folder / "page.html", says="breaks a rule")
        self.expect_refused("report", "fleet-lattice", "-o", self.folder / "page.html", says="breaks a rule")


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
