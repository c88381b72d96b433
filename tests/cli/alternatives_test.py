#!/usr/bin/env python3
"""Tests other best plans and the order that a plan needs.

    tests/cli/alternatives_test.py PROGRAM [unittest's arguments]
"""
import json
import unittest

from program import CYCLE, Case, assembly, orasp, smoke


class OtherPlans(Case):
    def test_optimal_sequences_are_counted(self):
        plan = json.loads(orasp("solve", "4brick", "--count", "--json").out)
        self.assertEqual(plan["optimal_sequences"], 2)
        self.assertNotIn("alternatives", plan)
        self.assertIs(plan["options"]["count"], True)
        self.check(orasp("solve", "4brick", "--count", "--method", "greedy"), 0, out=r"\n2 optimal sequences(, 1 up to symmetry)?\n")
        flat = self.file("flat.json", json.dumps({"type": "completion", "join": 0}))
        plan = json.loads(orasp("solve", "hubble-free", "--count", "--objective", flat, "--json").out)
        self.assertEqual(plan["optimal_sequences"], "121645100408832000")  # 19!, past 2^53
        self.assertNotIn("optimal_sequences", json.loads(orasp("solve", "4brick", "--json").out))

    @smoke
    def test_the_best_plans_are_listed(self):
        plan = json.loads(orasp("solve", "4brick", "--alternatives", "4", "--json").out)
        self.assertEqual([round(other["reward"], 9) for other in plan["alternatives"]], [0.557, 0.557, 0.545, 0.545])
        self.assertEqual(len({tuple(other["disassembly"]) for other in plan["alternatives"]}), 4)
        for other in plan["alternatives"]:
            self.assertEqual(other["assembly"], other["disassembly"][::-1])
            answer = orasp("evaluate", "4brick", "-", "--json", stdin=json.dumps(other["disassembly"]))
            self.assertAlmostEqual(json.loads(answer.out)["reward"], other["reward"], places=9)
        self.check(orasp("solve", "4brick", "--alternatives", "2"), 0, out=r"the 2 best plans\n   1  reward 0\.557\n      2-3, ")
        self.check(orasp("solve", "4brick", "--alternatives", "100"), 0, out=r"all 6 plans\n")
        forward = json.loads(orasp("solve", "4brick", "--alternatives", "1", "--direction", "assembly", "--json").out)
        self.assertEqual(forward["alternatives"][0]["disassembly"], forward["alternatives"][0]["assembly"][::-1])
        self.check(orasp("evaluate", "4brick", "-", "--direction", "assembly",
                         stdin=json.dumps(forward["alternatives"][0]["assembly"])), 0, out="is valid")

    def test_where_there_is_no_plan_there_is_none(self):
        plan = orasp("solve", "4brick", "--max-moved-parts", "0", "--count", "--alternatives", "3", "--json")
        self.assertEqual(plan.code, 10)
        self.assertEqual((json.loads(plan.out)["optimal_sequences"], json.loads(plan.out)["alternatives"]), (0, []))
        cycle = orasp("solve", "-", "--count", "--alternatives", "3", "--json", stdin=CYCLE)
        self.assertEqual(cycle.code, 10)
        self.assertEqual((json.loads(cycle.out)["optimal_sequences"], json.loads(cycle.out)["alternatives"]), (0, []))

    def test_a_graph_too_large_is_refused_at_once(self):
        for words in (["--count"], ["--alternatives", "2"]):
            answer = orasp("solve", "jwst", *words, "--quiet")
            self.check_sentence(answer)
            self.assertRegex(answer.error, rf"{words[0]} needs the whole state-action graph: .* are allowed\n")

    def test_a_limit_leaves_the_plan_and_says_what_is_missing(self):
        answer = orasp("solve", "random:12:22:1", "--method", "greedy", "--count", "--time-limit", "0.2", "--json")
        plan = json.loads(answer.out)
        self.assertEqual(answer.code, 20)
        self.assertNotIn("optimal_sequences", plan)
        self.assertEqual(len(plan["disassembly"]), 22)
        self.assertIn("building H for other plans was stopped by the time limit", plan["notes"])


class Order(Case):
    def test_every_order_that_keeps_the_pairs_of_a_plan_is_valid(self):
        for problem, words in [("lattice", []), ("hubble-upc", []), ("lattice", ["--direction", "assembly"]),
                               ("grid:3x4", ["--max-moved-parts", "2", "--max-subassemblies", "2"])]:
            with self.subTest(problem=problem, words=words):
                plan = json.loads(orasp("solve", problem, *words, "--json").out)
                ids = [step["connection"] for step in plan["steps"]]
                waits = {step: {early for early, late in plan["order"] if late == step}
                         for step in range(1, len(ids) + 1)}
                order = []
                while waits:  # the last step that may come now: as far from the plan's own order as can be
                    order.append(max(step for step, before in waits.items() if before <= set(order)))
                    del waits[order[-1]]
                self.assertNotEqual(order, sorted(order))
                mine = self.file("order.json", json.dumps([ids[step - 1] for step in order]))
                self.check(orasp("evaluate", problem, mine, *words), 0, out="the plan is valid")

    @smoke
    def test_a_plan_with_its_order_is_read_again_and_an_empty_one_has_none(self):
        plan = orasp("solve", "lattice", "--json").out
        self.check(orasp("evaluate", "lattice", "-", stdin=plan), 0, out="the plan is valid")
        self.assertEqual(json.loads(orasp("solve", "-", "--json", stdin=assembly([])).out)["order"], [])
        self.assertEqual(json.loads(orasp("solve", "4brick", "--max-moved-parts", "0", "--json").out)["order"], [])


if __name__ == "__main__":
    unittest.main()
