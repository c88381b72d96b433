#!/usr/bin/env python3
"""Tests `orasp replan`.

    tests/cli/replan_test.py PROGRAM [unittest's arguments]
"""
import json
import unittest
from pathlib import Path

from program import CHAIN, Case, assembly, orasp, smoke


class Replan(Case):
    @smoke
    def test_the_steps_still_to_come_and_what_changes(self):
        path = self.file("chain.json", CHAIN)
        # All three: -(0.0967 + 0.1368) - (0.0967 + 0.1248) + 1; without 2-3 the two ends come off, the second completes.
        self.check(orasp("solve", path, "-o", str(self.folder / "plan.json")), 0)
        plan = str(self.folder / "plan.json")
        answer = orasp("replan", path, "--plan", plan, "--inaccessible", "2-3", "--json")
        self.check(answer, 0)
        found = json.loads(answer.out)
        self.assertEqual(found["format"], "orasp-plan/1")
        self.assertEqual(sorted(found["disassembly"]), ["1-2", "3-4"])
        self.assertAlmostEqual(found["reward"], 1 - 0.0967 - 0.1368)
        self.assertEqual(len(found["steps"]), 2)
        changes = found["changes"]
        self.assertEqual(changes["dropped"], ["2-3"])
        self.assertEqual(sorted(changes["kept"] + changes["moved"]), ["1-2", "3-4"])
        self.assertAlmostEqual(changes["price"], changes["reward_before"] - found["reward"])
        answer = orasp("replan", path, "--plan", plan, "--done", "1", "--json")
        found = json.loads(answer.out)
        old = json.loads(Path(plan).read_text())
        self.assertEqual(found["disassembly"], old["disassembly"][1:])
        self.assertEqual(found["changes"]["price"], 0)
        self.assertAlmostEqual(found["reward"], old["reward"] - old["steps"][0]["reward"])
        self.check(orasp("replan", path, "--removed", "1-2,2-3,3-4"), 0, out=r"reward   0\n")

    def test_what_cannot_be_next_is_late_or_lost(self):
        path = self.file("chain.json", CHAIN)

        def order(*more):
            return json.loads(orasp("replan", path, "--json", *more).out)["disassembly"]
        self.assertNotEqual(order("--not-next", order()[0])[0], order()[0])
        self.assertEqual(order("--late-part", "1")[-1], "1-2")
        self.assertEqual(sorted(order("--lost-part", "2")), ["3-4"])
        self.assertEqual(order("--direction", "assembly", "--made", "1-2", "--inaccessible", "3-4"), ["2-3"])

    @smoke
    def test_a_late_or_lost_part_shuts_no_door(self):
        # A pen: the ink lies between head and button, the cap goes over the head.
        pen = self.file("pen.json", json.dumps({
            "format": "orasp-problem/1", "direction": "assembly",
            "parts": [{"id": part} for part in ("body", "ink", "head", "button", "cap")],
            "connections": [{"parts": ["body", part]} for part in ("ink", "head", "button", "cap")],
            "precedence": [{"connection": "body-cap", "made_after": ["body-head"]}],
            "blocking": {"directions": ["+x", "-x"], "blocked": [{"part": "ink", "by": "head", "directions": ["+x"]},
                                                                {"part": "ink", "by": "button", "directions": ["-x"]}]}}))
        answer = orasp("replan", pen, "--lost-part", "head")
        self.check(answer, 0, out=r'waiting for "head": body-head, body-cap\n  once it is there, all of this can be done\n')
        found = json.loads(orasp("replan", pen, "--lost-part", "head", "--json").out)
        self.assertEqual(found["waiting"], ["body-head", "body-cap"])
        self.assertEqual(sorted(found["assembly"]), ["body-button", "body-ink"])
        answer = orasp("replan", pen, "--late-part", "head")
        self.check(answer, 0, out=r'2 steps before "head" must be there; step 3, "body-head", is the first that needs it\n')
        # Both ends are shut already: the ink can never go in, with or without it.
        answer = orasp("replan", pen, "--made", "body-head,body-button", "--lost-part", "ink")
        self.check(answer, 0, out=r'given up for "ink": body-ink\n  even with it the rest could not be finished\n')
        self.check(orasp("replan", pen, "--made", "body-head,body-button", "--late-part", "ink"), 10)

    def test_no_plan_is_ten_and_names_what_is_inaccessible(self):
        path = self.file("after.json", assembly(["1-2", "2-3"], precedence=[{"connection": "1-2", "after": ["2-3"]}]))
        answer = orasp("replan", path, "--inaccessible", "2-3")
        self.check(answer, 10, out=r'precedence\[0\]  "1-2" may be removed only after "2-3"\n +"2-3" is inaccessible\n')
        found = json.loads(orasp("replan", path, "--inaccessible", "2-3", "--json").out)
        self.assertEqual([item["constraint"] for item in found["conflict"]], ["precedence", "inaccessible"])
        both = orasp("replan", path, "--not-next", "2-3")
        self.check(both, 10, out='"2-3" cannot be the next step')

    def test_another_objective_reports_both_times(self):
        found = json.loads(orasp("replan", "lattice", "--objective", "time", "--removed", "1-2", "--json").out)
        self.assertEqual(set(found["reweighing"]), {"states", "generated", "reweighed"})
        again = json.loads(orasp("solve", "lattice", "--objective", "time", "--json").out)
        first = [step["reward"] for step in again["steps"]][0]
        self.assertGreaterEqual(found["reward"], again["reward"] - first)

    def test_what_is_wrong_is_said_in_a_sentence(self):
        for words in (["--removed", "1-9"], ["--lost-part", "Z"], ["--done", "1"], ["--inaccessible", "1-2,,2-3"],
                      ["--done", "x"], ["--not-next", ""]):
            self.check_sentence(orasp("replan", "lattice", *words))
        plan = self.file("plan.txt", "1-2\n2-3\n")
        self.check_sentence(orasp("replan", "lattice", "--plan", plan, "--done", "3"))
        self.check_sentence(orasp("replan", "lattice", "--plan", self.file("twice.txt", "1-2\n1-2\n")))


if __name__ == "__main__":
    unittest.main()
