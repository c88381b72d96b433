#!/usr/bin/env python3
"""Tests `orasp explain`.

    tests/cli/explain_test.py PROGRAM [unittest's arguments]
"""
import json
import unittest
from pathlib import Path

from program import CYCLE, Case, assembly, orasp, smoke


class Explain(Case):
    def test_a_conflict_is_named_by_place_and_word(self):
        path = self.file("cycle.json", CYCLE)
        answer = orasp("explain", path)
        self.check(answer, 10, out=r"test: no plan exists\n\n2 constraints conflict; any 1 of them alone")
        self.assertRegex(answer.out, r'\n  precedence\[0\]  "1-2" may be removed only after "2-3"\n'
                                     r'  precedence\[1\]  "2-3" may be removed only after "1-2"\n')
        found = json.loads(orasp("explain", path, "--json").out)
        self.assertEqual(found["status"], "infeasible")
        self.assertTrue(found["minimal"])
        self.assertEqual([(item["constraint"], item["where"]) for item in found["conflict"]],
                         [("precedence", "precedence[0]"), ("precedence", "precedence[1]")])
        self.assertEqual(set(found["conflict"][0]), {"constraint", "where", "message"})

    def test_a_limit_from_the_command_line_is_a_constraint_too(self):
        found = json.loads(orasp("explain", "4brick", "--max-moved-parts", "0", "--json").out)
        self.assertEqual([item["where"] for item in found["conflict"]], ["limits.max_moved_parts"])
        self.check(orasp("explain", "4brick", "--max-moved-parts", "0"), 10, out="one constraint alone")
        self.check(orasp("explain", "4brick", "--max-moved-parts", "0", "--direction", "assembly"), 10,
                   out=r"limits\.max_moved_parts")

    def test_too_many_subassemblies_to_begin_with(self):
        path = self.file("two.json", assembly(["1-2", "3-4"], limits={"max_subassemblies": 1}))
        self.check(orasp("explain", path), 10, out=r"limits\.max_subassemblies  the whole product is 2 subassemblies")

    def test_a_problem_with_a_plan_is_zero_and_says_what_cannot_go_first(self):
        answer = orasp("explain", "lattice")
        self.check(answer, 0, out=r"a plan exists\n\n8 connections may go first, 4 may not:\n", error=r"\A\Z")
        found = json.loads(orasp("explain", "lattice", "--json").out)
        self.assertEqual((found["status"], found["conflict"]), ("feasible", []))
        self.check(orasp("explain", "3piece"), 0, out="every connection may go first")
        self.check(orasp("explain", "-", stdin=assembly([])), 0, out="the plan is empty")

    def test_of_steps_that_take_parts_off_it_says_which_parts_cannot_come_off_first(self):
        product = {
            "format": "orasp-problem/1", "action": "part", "base": ["box"], "limits": {"max_moved_parts": 2},
            "parts": [{"id": name} for name in ("box", "lid", "screw", "pin", "plate", "loose")],
            "connections": [{"id": "hinge", "parts": ["box", "lid"]}, {"id": "thread", "parts": ["box", "screw"]},
                            {"id": "head", "parts": ["screw", "lid"]}, {"id": "press", "parts": ["box", "pin"]},
                            {"id": "seat", "parts": ["box", "plate"]}],
            "precedence": [{"connection": "press", "after": ["hinge"]}],
            "blocking": {"directions": ["+z", "-z"],
                         "blocked": [{"part": "lid", "by": "screw", "directions": ["+z"]},
                                     {"part": "lid", "by": "box", "directions": ["-z"]}]}}
        answer = orasp("explain", self.file("box.json", json.dumps(product)))
        self.check(answer, 0, out=r"a plan exists\n\n2 parts may come off first, each by itself, 2 may not:\n")
        self.assertIn('  lid  blocking: no direction is free; in the way: "box", "screw"\n', answer.out)
        self.assertIn('  pin  precedence: "press" must go after "hinge", against precedence[0]\n', answer.out)
        self.check(orasp("explain", self.file("box.json", json.dumps({**product, "limits": {"max_moved_parts": 0}}))), 10)
        del product["precedence"], product["blocking"]
        self.check(orasp("explain", self.file("box.json", json.dumps(product))), 0, out="every part may come off first, each by itself")

    def test_a_connection_that_cannot_go_first(self):
        answer = orasp("explain", "lattice", "--connection", "4-5")
        self.check(answer, 10, out=r'"4-5" cannot be removed first\n\n  precedence\[1\]: .*\n    remove first "7-8"\n')
        self.assertRegex(answer.out, r"legal after 1 other step, and after no fewer:\n  7-8\n")
        found = json.loads(orasp("explain", "lattice", "--connection", "4-5", "--json").out)
        self.assertEqual(found["status"], "illegal")
        self.assertEqual(found["changes"][0]["first"], ["7-8"])
        self.assertEqual((found["legal_later"], found["legal_after"], found["fewest"]), (True, ["7-8"], True))

    def test_the_least_limit_would_do(self):
        words = ["explain", "chain:6", "--connection", "3-4", "--max-subassemblies", "1", "--max-moved-parts", "2"]
        found = json.loads(orasp(*words, "--json").out)
        self.assertEqual({change["where"]: change["least"] for change in found["changes"]},
                         {"limits.max_subassemblies": 2, "limits.max_moved_parts": 3})
        self.check(orasp("explain", "chain:6", "--connection", "3-4", "--max-subassemblies", "2",
                         "--max-moved-parts", "3"), 0, out="a plan goes on from there")

    def test_parts_in_the_way_are_named_for_each_direction(self):
        path = self.file("slot.json", assembly(
            ["1-2", "2-3"], blocking={"directions": ["+x", "-x"], "blocked": [
                {"part": "2", "by": "1", "directions": ["+x", "-x"]}, {"part": "3", "by": "1", "directions": ["-x"]}]}))
        found = json.loads(orasp("explain", path, "--connection", "1-2", "--json").out)
        self.assertEqual(found["status"], "illegal")
        self.assertFalse(found["legal_later"])
        directions = {entry["direction"]: entry for entry in found["changes"][0]["directions"]}
        self.assertEqual(set(directions), {"+x", "-x"})
        for entry in directions.values():
            self.assertIn("blocking.blocked[0]", entry["entries"])
        self.check(orasp("explain", path), 10, out=r'blocking\.blocked\[0\]  "2" cannot leave "1" along \+x and -x')

    @smoke
    def test_in_the_middle_of_a_plan(self):
        plan = self.file("plan.json", orasp("solve", "lattice", "--json").out)
        steps = json.loads(Path(plan).read_text())["disassembly"]
        place = steps.index("4-5") + 1
        self.check(orasp("explain", "lattice", "--connection", "4-5", "--plan", plan, "--step", str(place)), 0,
                   out=rf'"4-5" may be removed at step {place}\na plan goes on', error=r"\A\Z")
        answer = orasp("explain", "lattice", "--connection", steps[0], "--plan", plan, "--step", "3")
        self.check(answer, 10, out="was removed before")
        self.check_sentence(orasp("explain", "lattice", "--connection", "4-5", "--plan", plan, "--step", "40"))
        twice = self.file("twice.json", '["1-2", "1-2", "1-4"]')
        self.check_sentence(orasp("explain", "lattice", "--connection", "4-5", "--plan", twice, "--step", "3"))
        wrong = self.file("wrong.json", '["4-5"]')
        self.check(orasp("explain", "lattice", "--connection", "1-2", "--plan", wrong, "--step", "2"), 0,
                   error="step 1 of the plan is not legal")

    def test_a_dead_end_is_legal_and_said_to_be_one(self):
        path = self.file("sandwich.json", assembly(
            ["1-3", "1-2", "2-3"], precedence=[{"connection": "2-3", "after": ["1-2"]}],
            blocking={"directions": ["+x", "-x"], "blocked": [{"part": "1", "by": "2", "directions": ["+x"]},
                                                              {"part": "1", "by": "3", "directions": ["-x"]}]}))
        self.check(orasp("explain", path, "--connection", "1-3"), 0, out="but no plan goes on from there: it is a dead end")
        self.assertIs(json.loads(orasp("explain", path, "--connection", "1-3", "--json").out)["plan_exists"], False)

    def test_what_is_not_decided_is_twenty(self):
        loops = [{"id": f"loop{i}", "parts": ["1", "1"]} for i in range(40)]
        problem = json.loads(assembly(["1-2", "2-3"]))
        problem["connections"] += loops
        # Each part is held by the other two, and no two of them lock each other, which would be seen at once.
        problem["blocking"] = {"directions": ["+x", "-x"],
                               "blocked": [{"part": "2", "by": "1", "directions": ["+x"]},
                                           {"part": "2", "by": "3", "directions": ["-x"]},
                                           {"part": "1", "by": "3", "directions": ["+x"]}]}
        answer = orasp("explain", "-", "--time-limit", "0.3", "--quiet", stdin=json.dumps(problem))
        self.check(answer, 20, out="not decided whether a plan exists: stopped by the time limit", error=r"\A\Z")

    def test_two_parts_that_lock_each_other_are_named_at_once(self):
        problem = json.loads(assembly(["1-2"]))
        problem["connections"] += [{"id": f"loop{i}", "parts": ["1", "1"]} for i in range(40)]
        problem["blocking"] = {"directions": ["+x", "-x"],
                               "blocked": [{"part": "1", "by": "2", "directions": ["+x", "-x"]}]}
        text = json.dumps(problem)
        self.check(orasp("explain", "-", stdin=text), 10, out='"1" cannot leave "2" along \+x and -x')
        self.check(orasp("solve", "-", stdin=text), 10,
                   out='parts "1" and "2" block each other in every direction of blocking.directions')

    def test_the_explanation_is_written_too(self):
        path = self.folder / "why.json"
        self.check(orasp("explain", "4brick", "--max-moved-parts", "0", "-o", str(path)), 10, out="no plan exists")
        self.assertEqual(json.loads(path.read_text())["status"], "infeasible")


if __name__ == "__main__":
    unittest.main()
