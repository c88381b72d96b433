#!/usr/bin/env python3
"""Tests `orasp simulate`.

    tests/cli/simulate_test.py PROGRAM [unittest's arguments]
"""
import json
import unittest

from program import Case, orasp, smoke

UNCERTAIN = json.dumps({
    "format": "orasp-problem/1", "name": "test", "parts": [{"id": part} for part in "abc"],
    "connections": [{"parts": ["a", "b"], "success": 0.8, "on_failure": {"breaks": ["b-c"]}},
                    {"parts": ["b", "c"], "success": 0.5}],
    "objective": {"type": "expression", "formula": "0 - 1 - after"}})


class Simulate(Case):
    """The problem worked out by hand in tests/planners/uncertain_value_iteration_test.cpp: -3.85 in 2.85 attempts."""

    def setUp(self):
        super().setUp()
        self.problem = self.file("uncertain.json", UNCERTAIN)

    def figures(self, *arguments):
        answer = orasp("simulate", self.problem, "--json", *arguments)
        self.check(answer, 0)
        return json.loads(answer.out)

    def test_the_mean_agrees_with_the_expectation(self):
        found = self.figures()
        self.assertEqual((found["n"], found["seed"], found["aborted"], found["replanned"]), (10000, 1, 0, 0))
        self.assertAlmostEqual(found["expected"], -3.85)
        self.assertLess(abs(found["mean"] - found["expected"]), 3 * found["standard_error"])
        self.assertLess(abs(found["attempts"]["mean"] - 2.85), 0.1)
        self.assertLessEqual(found["min"], found["percentiles"]["5"])

    def test_a_policy_from_solve_is_followed_and_a_worse_plan_costs_more(self):
        policy = str(self.folder / "policy.json")
        answer = orasp("solve", self.problem, "-o", policy)
        self.check(answer, 0, out=r"expected reward -3\.85\n")
        self.assertIn("most likely sequence (probability 0.8)", answer.out)
        self.assertAlmostEqual(self.figures("--policy", policy, "-n", "100")["expected"], -3.85)
        plan = self.file("plan.txt", "b-c\na-b\n")
        self.assertAlmostEqual(self.figures("--plan", plan, "-n", "100")["expected"], -5.25)

    def test_a_problem_whose_states_are_too_many_to_be_listed(self):
        problem = json.loads(orasp("scenarios", "iss-upc").out)
        for connection in problem["connections"]:
            connection["success"] = 0.9
        self.problem = self.file("large.json", json.dumps(problem))
        found = self.figures("-n", "2000", "--time-limit", "20")
        self.assertEqual(found["n"], 2000)
        self.assertAlmostEqual(found["expected"], -2.389556, places=6)
        self.assertLess(abs(found["mean"] - found["expected"]), 3 * found["standard_error"])

    @smoke
    def test_the_same_seed_gives_the_same_bytes(self):
        runs = [orasp("simulate", self.problem, "-n", "500", "--seed", seed, "--json").out for seed in "778"]
        self.assertEqual(runs[0], runs[1])
        self.assertNotEqual(runs[0], runs[2])

    def test_wrong_input_is_refused_in_a_sentence(self):
        other = self.file("other.json", orasp("solve", "lattice", "--json").out)
        self.check(orasp("simulate", self.problem, "--plan", other), 30,
                   error='the plan cannot be followed: step 1, "1-2": the problem has no connection "1-2"')
        for arguments in [("--policy", other), ("--plan", "x", "--policy", "y"), ("-n", "0"), ("-n", "-3"),
                          ("--plan", str(self.folder / "none.json"))]:
            with self.subTest(arguments=arguments):
                self.check_sentence(orasp("simulate", self.problem, *arguments))

    def test_goals_part_steps_and_costs_between_steps_take_the_plan_as_it_stands(self):
        parts = [{"id": part} for part in "abcd"]
        joined = [{"parts": pair, "attributes": {"tool": tool}} for pair, tool in (("ab", "x"), ("bc", "y"), ("cd", "x"))]
        for connection in joined:
            connection["parts"] = list(connection["parts"])
        plain = {"format": "orasp-problem/1", "parts": parts, "connections": joined, "objective": {"type": "cubesat"}}
        for change in ({"goal": {"free": ["d"]}}, {"action": "part"},
                       {"objective": {"type": "changeover", "attribute": "tool", "cost": 2}}):
            with self.subTest(change):
                self.problem = self.file("wide.json", json.dumps(plain | change))
                plan = json.loads(orasp("solve", self.problem, "--json").out)
                attempts = len(plan["steps"])
                found = self.figures("-n", "7")
                self.assertEqual((found["n"], found["attempts"], found["deviation"]), (7, {"mean": attempts, "max": attempts}, 0))
                self.assertAlmostEqual(found["expected"], plan["reward"])
                self.assertAlmostEqual(found["mean"], plan["reward"])
                other = json.loads(orasp("solve", self.problem, "--method", "random", "--seed", "3", "--json").out)
                file = self.file("plan.json", json.dumps(other))
                self.assertAlmostEqual(self.figures("--plan", file, "-n", "7")["mean"], other["reward"])
                self.check_sentence(orasp("simulate", self.problem, "--policy", file))
        # Where the best plan is not proved, the one that was found is followed, and said to be no more.
        parts = [{"id": f"p{i}", "mass": 1 + i % 3} for i in range(26)]
        joined = [{"parts": [f"p{i * i % (i + 1) if i % 2 else i // 2}", f"p{i + 1}"]} for i in range(25)]
        large = {"format": "orasp-problem/1", "action": "part", "parts": parts, "connections": joined, "objective": {"type": "fuel"}}
        self.problem = self.file("large.json", json.dumps(large))
        answer = orasp("simulate", self.problem, "-n", "7", "--time-limit", "2")
        self.assertIn(answer.code, (0, 20))
        self.assertIn("7 of 7 runs with a plan, not proved best, found first", answer.out)
        self.assertNotRegex(answer.out, r"expected reward +0\n")
        uncertain = json.loads(json.dumps(plain | {"goal": {"free": ["d"]}}))
        uncertain["connections"][0]["success"] = 0.5
        self.check(orasp("simulate", self.file("both.json", json.dumps(uncertain))), 30, error="here a goal or costs between steps")

    def test_other_methods_say_that_they_do_not_apply(self):
        answer = orasp("solve", self.problem, "--method", "dijkstra")
        self.check_sentence(answer)
        self.assertIn("dijkstra plans for attempts that always succeed", answer.error)


if __name__ == "__main__":
    unittest.main()
