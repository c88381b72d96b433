#!/usr/bin/env python3
"""Tests `orasp solve`: statuses, exit codes, changes to the problem, options of methods.

    tests/cli/solve_test.py PROGRAM [unittest's arguments]
"""
import json
import time
import unittest
from pathlib import Path

from program import CHAIN, CYCLE, Case, methods, orasp, smoke


class Solve(Case):
    @smoke
    def test_status_decides_the_exit_code(self):
        exact = [name for name in methods() if name not in ("auto", "greedy", "random")]
        for method in ["auto", *exact]:
            with self.subTest(method=method):
                answer = orasp("solve", "-", "--method", method, stdin=CHAIN)
                if "install the package" in answer.error and method in ("dqn", "mip"):
                    self.check_sentence(answer)  # built without the module of this method
                    continue
                self.check(answer, 0, out=r"status   optimal \(proved\)\nreward   0\.557\n")
        for method in ["greedy", "random"]:
            with self.subTest(method=method):
                self.check(orasp("solve", "-", "--method", method, stdin=CHAIN), 0,
                           out=r"status   feasible \(not proved best\)")

    @smoke
    def test_infeasible_is_ten_and_names_the_cycle(self):
        for method in methods():
            with self.subTest(method=method):
                answer = orasp("solve", "-", "--method", method, stdin=CYCLE)
                self.check(answer, 10, out=r"infeasible \(proved: no plan exists\)")
                self.assertRegex(answer.out, r'"1-2" after "2-3".*"2-3" after "1-2"')
        answer = orasp("solve", "-", "--json", stdin=CYCLE)
        self.check(answer, 10)
        plan = json.loads(answer.out)
        self.assertEqual((plan["status"], plan["reward"], plan["steps"]), ("infeasible", None, []))

    def test_without_a_plan_the_file_named_by_o_is_left_alone(self):
        for content in [None, "the plan of yesterday"]:
            with self.subTest(content=content):
                output = self.folder / f"{content}.json"
                if content is not None:
                    output.write_text(content)
                answer = orasp("solve", "-", "-o", str(output), stdin=CYCLE)
                self.check(answer, 10, out=r"infeasible", error=r"there is no plan, so .* is not written")
                self.assertEqual(output.read_text() if output.exists() else None, content)

    @smoke
    def test_the_json_has_the_keys_of_the_contract(self):
        plan = json.loads(orasp("solve", "hubble", "--json").out)
        self.assertLessEqual({"format", "problem", "problem_digest", "method", "status", "reward", "bound", "gap",
                              "disassembly", "assembly", "steps", "order", "statistics", "seed", "options"}, set(plan))
        self.assertEqual(plan["format"], "orasp-plan/1")
        self.assertEqual(plan["status"], "optimal")
        self.assertAlmostEqual(plan["reward"], -0.9902, places=9)
        self.assertEqual(len(plan["steps"]), 19)
        self.assertEqual(set(plan["steps"][0]),
                         {"step", "connection", "reward", "total", "separates", "pieces", "moved"})
        self.assertLessEqual({"states", "actions", "expanded", "generated", "pruned", "seconds", "peak_bytes"},
                             set(plan["statistics"]))
        self.assertEqual(plan["assembly"], plan["disassembly"][::-1])

    def test_the_same_seed_gives_the_same_bytes_times_aside(self):
        def plan(*more):
            found = json.loads(orasp("solve", "hubble-free", "--method", "random", "--json", *more).out)
            found["statistics"]["seconds"] = 0
            return found
        self.assertEqual(plan("--seed", "7"), plan("--seed", "7", "--threads", "1"))
        self.assertNotEqual(plan("--seed", "7")["disassembly"], plan("--seed", "8")["disassembly"])
        self.assertEqual(plan("--seed", "7")["seed"], 7)

    def test_changes_to_the_problem_are_applied_and_noted(self):
        answer = orasp("solve", "4brick", "--objective", "time", "--direction", "assembly", "--json")
        plan = json.loads(answer.out)
        self.assertEqual(plan["reward"], -6)
        self.assertEqual(plan["options"]["objective"], "time")
        self.assertEqual(plan["options"]["direction"], "assembly")
        self.check(orasp("solve", "4brick", "--max-moved-parts", "1"), 0, out=r"reward   0\.545\n")
        self.check(orasp("solve", "4brick", "--max-subassemblies", "0"), 10)
        self.check(orasp("solve", "4brick", "--max-moved-mass", "0.5"), 10)
        objective = self.file("objective.json", '{"type": "piece_cost", "operation": 2}')
        self.check(orasp("solve", "4brick", "--objective", objective), 0, out=r"reward   -4\n")

    def test_a_file_beats_a_scenario_only_if_it_looks_like_one(self):
        Path(self.folder / "hubble").write_text(CHAIN)
        Path(self.folder / "mine").write_text(CHAIN)
        self.check(orasp("solve", "hubble", cwd=self.folder), 0, out=r"\AHubble: 20 parts")
        self.check(orasp("solve", "./hubble", cwd=self.folder), 0, out=r"\Atest: 4 parts")
        self.check(orasp("solve", "mine", cwd=self.folder), 0, out=r"\Atest: 4 parts")

    def test_value_iteration_has_its_options(self):
        for more in [["--sweep-order", "textbook"], ["--initial-value", "-5.5"], ["--epsilon", "1e-6"]]:
            with self.subTest(more=more):
                self.check(orasp("solve", "lattice", "--method", "value-iteration", *more), 0, out=r"reward   0\.0735\n")
        answer = orasp("solve", "lattice", "--method", "value-iteration", "--sweep-order", "textbook",
                       "--max-sweeps", "1", "--json")
        self.assertEqual(json.loads(answer.out)["options"]["max-sweeps"], 1)
        self.assertNotEqual(json.loads(answer.out)["status"], "optimal")

    def test_a_bound_may_be_chosen(self):
        expanded = {}
        for method in ("orasp-search", "a-star", "beam"):
            for bound in ("none", "connections", "sizes", "best"):
                with self.subTest(method=method, bound=bound):
                    answer = orasp("solve", "lattice", "--method", method, "--bound", bound, "--json")
                    self.check(answer, 0)
                    plan = json.loads(answer.out)
                    self.assertEqual(plan["status"], "optimal")
                    self.assertAlmostEqual(plan["reward"], 0.0735, places=9)
                    self.assertEqual(plan["options"]["bound"], bound)
                    expanded[method, bound] = plan["statistics"]["expanded"]
            self.assertLess(10 * expanded[method, "sizes"], expanded[method, "none"])
            default = json.loads(orasp("solve", "lattice", "--method", method, "--json").out)
            self.assertEqual(default["statistics"]["expanded"], expanded[method, "best"])
        self.check(orasp("solve", "lattice", "--objective", "fuel", "--method", "a-star", "--bound", "parts"), 0)

    def test_too_large_for_a_method_is_refused_at_once(self):
        start = time.monotonic()
        answer = orasp("solve", "jwst", "--method", "dijkstra", "--quiet")
        self.check_sentence(answer)
        self.assertRegex(answer.error, r"orasp-search|greedy")
        self.assertLess(time.monotonic() - start, 30)

    def test_warnings_go_to_standard_error_unless_quiet(self):
        self.check(orasp("solve", "jwst", "--method", "greedy"), 0, error=r'orasp: warning: .*"161-161"')
        self.check(orasp("solve", "jwst", "--method", "greedy", "--quiet"), 0, error=r"\A\Z")

    def test_a_problem_without_connections_has_the_empty_plan(self):
        for connections in ([], None):
            problem = json.dumps({"format": "orasp-problem/1", "parts": [{"id": "1"}] if connections is None else [],
                                  "connections": []})
            self.check(orasp("solve", "-", stdin=problem), 0, out=r"optimal \(proved\)\nreward   0\n")


if __name__ == "__main__":
    unittest.main()
