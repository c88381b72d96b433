#!/usr/bin/env python3
"""Tests `orasp evaluate`.

    tests/cli/evaluate_test.py PROGRAM [unittest's arguments]
"""
import json
import unittest

from program import Case, assembly, orasp, smoke


class Evaluate(Case):
    def test_a_solved_plan_is_valid_whichever_way_it_comes(self):
        plan = orasp("solve", "lattice", "--json").out
        order = json.loads(plan)["disassembly"]
        for text in [plan, json.dumps(order), "# by hand\n" + "\n".join(order) + "\n"]:
            answer = orasp("evaluate", "lattice", "-", "--json", stdin=text)
            self.check(answer, 0, error=r"\A\Z")
            verdict = json.loads(answer.out)
            self.assertEqual(set(verdict), {"valid", "reward", "steps", "violations"})
            self.assertEqual((verdict["valid"], verdict["steps"], verdict["violations"]), (True, 12, []))
            self.assertAlmostEqual(verdict["reward"], 0.0735, places=9)
        self.check(orasp("evaluate", "lattice", self.file("plan", plan)), 0, out=r"the plan is valid\nreward   0\.0735\n")

    @smoke
    def test_every_violation_is_named(self):
        problem = self.file("p.json", assembly(["1-2", "2-3", "3-4"],
                                               precedence=[{"connection": "1-2", "after": ["3-4"]}],
                                               limits={"max_moved_parts": 1}))
        answer = orasp("evaluate", problem, "-", "--json", stdin='["1-2", "2-3", "2-3", "x"]')
        self.check(answer, 10)
        verdict = json.loads(answer.out)
        self.assertFalse(verdict["valid"])
        for violation in verdict["violations"]:
            self.assertEqual(set(violation), {"step", "connection", "constraint", "message"})
        found = [(v["step"], v["connection"], v["constraint"]) for v in verdict["violations"]]
        self.assertEqual(found[0], (1, "1-2", "precedence"))
        self.assertIn((4, "x"), [entry[:2] for entry in found])
        answer = orasp("evaluate", problem, "-", stdin='["2-3", "1-2", "3-4"]')
        self.check(answer, 10, out=r"step 1, 2-3: max_moved_parts: ")

    def test_a_plan_for_another_problem_is_worth_a_warning(self):
        plan = self.file("plan.json", orasp("solve", "4brick", "--json").out)
        answer = orasp("evaluate", "4brick", plan, "--objective", "time")
        self.check(answer, 0, out=r"reward   -6\n", error=r"\Aorasp: warning: .*problem_digest differs\n\Z")
        self.check(orasp("evaluate", "4brick", plan, "--objective", "time", "--quiet"), 0, error=r"\A\Z")

    def test_assembly_plans_are_read_in_their_own_direction(self):
        plan = orasp("solve", "hubble", "--direction", "assembly", "--objective", "indexed", "--json").out
        answer = orasp("evaluate", "hubble", "-", "--direction", "assembly", "--objective", "indexed", "--json", stdin=plan)
        self.check(answer, 0)
        self.assertAlmostEqual(json.loads(answer.out)["reward"], json.loads(plan)["reward"])

    def test_several_parts_of_one_product_are_counted(self):
        problem = json.loads(assembly(["1-2", "2-3", "3-4", "4-5", "5-6", "6-7"]))
        for part, product in zip(problem["parts"], ["M5 nut", "M5 nut", "plate", "", "", "plate"]):
            if product:
                part["product"] = product
        for order, row in [(["2-3", "1-2", "3-4", "4-5", "5-6", "6-7"], r"1  2-3 +2 x M5 nut "),  # both nuts
                           (["3-4", "1-2", "2-3", "4-5", "5-6", "6-7"], r"1  3-4 +2 x M5 nut, 3 "),  # and one plate alone
                           (["4-5", "1-2", "2-3", "3-4", "5-6", "6-7"], r"1  4-5 +5, 6, 7 ")]:  # neither is one of several here
            answer = orasp("evaluate", self.file("products.json", json.dumps(problem)), "-", stdin=json.dumps(order))
            self.check(answer, 0, out=row)

    def test_a_direction_that_is_not_free_is_named(self):
        problem = self.file("p.json", assembly(["1-2", "2-3"], blocking={
            "directions": ["+x", "-x", {"id": "slant", "vector": [0, 3, 4]}],
            "blocked": [{"part": "1", "by": "2", "directions": ["+x", "-slant"]}]}))
        plan = json.loads(orasp("solve", problem, "--json").out)
        step = next(step for step in plan["steps"] if step["connection"] == "1-2")
        self.assertEqual((step["moved"], step["direction"], step["free_directions"]),
                         (["1"], "-x", ["-x", "slant"]))
        step["direction"] = "slant"
        answer = orasp("evaluate", problem, "-", stdin=json.dumps(plan))
        self.check(answer, 0, out=r"separates  leaves along +reward.*\n.* 1-2 .* slant ")
        step["direction"] = "+x"
        for command in (["evaluate", problem, "-"], ["report", problem, "-", "-o", self.folder / "r.html"]):
            self.check(orasp(*command, stdin=json.dumps(plan)), 10)
        answer = orasp("evaluate", problem, "-", stdin=json.dumps(plan))
        self.check(answer, 10, out=r'step \d, 1-2: blocking: the plan states the direction \+x, in which "2" is in the '
                                   r'way of "1"; free are -x, slant\n')
        self.check(orasp("simulate", problem, "--plan", "-", stdin=json.dumps(plan)), 30)


if __name__ == "__main__":
    unittest.main()
