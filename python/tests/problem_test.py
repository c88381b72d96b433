"""Problems as objects."""
import copy
import json
import math
import pickle
import tempfile
import unittest
import warnings
from pathlib import Path

import numpy as np
import orasp
from program import ROOT, random_problem


def shelf():
    problem = orasp.Problem("Shelf", objective="time")
    left, right, board = (problem.add_part(id, mass=2) for id in ("left", "right", "board"))
    problem.connect(left, board, duration=20)
    problem.connect(right, board, duration=20)
    return problem


def heavy(step):
    return -step.moved_mass


class Building(unittest.TestCase):
    maxDiff = None

    def test_says_what_a_file_says(self):
        problem = orasp.Problem("all", direction="disassembly")
        problem.add_part("a", name="A", mass=np.float64(2.5), position=np.array([0, 0, 1.5]), numbers={"value": 3})
        problem.add_part("b")
        problem.add_part("c", position=(1, 0, 0))
        self.assertEqual(problem.connect("a", "b", id="ab", duration=2, attributes={"tool": "M4"}, numbers={"value": 1}), "ab")
        self.assertEqual(problem.connect("b", "c", position=[0, 0, 0]), "b-c")
        problem.require("ab", after=["b-c"])
        problem.block("a", "b", ["+x"])
        problem.limit(max_moved_parts=2, grounded=True)
        problem.limit(max_moved_mass=50)
        problem.fix("b")
        problem.aim(free=["a"], stop="best")
        problem.objective = {"type": "expression", "formula": "-value"}
        problem["source"] = "made up"
        self.assertEqual(problem.check().to_dict(), {
            "format": "orasp-problem/1", "name": "all", "source": "made up",
            "parts": [{"id": "a", "name": "A", "mass": 2.5, "position": [0, 0, 1.5], "numbers": {"value": 3}},
                      {"id": "b"}, {"id": "c", "position": [1, 0, 0]}],
            "connections": [{"id": "ab", "parts": ["a", "b"], "duration": 2, "numbers": {"value": 1}, "attributes": {"tool": "M4"}},
                            {"parts": ["b", "c"], "position": [0, 0, 0]}],
            "precedence": [{"connection": "ab", "after": ["b-c"]}],
            "blocking": {"directions": ["+x", "-x", "+y", "-y", "+z", "-z"],
                         "blocked": [{"part": "a", "by": "b", "directions": ["+x"]}]},
            "limits": {"max_moved_parts": 2, "max_moved_mass": 50, "grounded": True},
            "base": ["b"],
            "goal": {"free": ["a"], "stop": "best"},
            "objective": {"type": "expression", "formula": "-value"},
        })

    def test_can_be_changed_after_solving(self):
        problem = shelf()
        self.assertEqual(orasp.solve(problem).reward, -42)
        problem.add_part("shelf", mass=1)
        problem.connect("shelf", "board", duration=5)
        self.assertEqual(orasp.solve(problem).reward, -48)
        del problem["objective"]
        self.assertEqual(problem.objective, {"type": "cubesat"})

    def test_finds_faults_when_it_is_used(self):
        problem = shelf()
        problem.connect("left", "door")
        with self.assertRaisesRegex(orasp.InputError, r'connections\[2\].parts\[1\]: no part "door"'):
            orasp.solve(problem)
        other = shelf()
        other.add_part("x", mass=math.nan)
        with self.assertRaisesRegex(orasp.InputError, r"parts\[3\].mass: it is not a finite number"):
            other.check()
        other = shelf()
        other.add_part("x", weight=3)
        with self.assertRaisesRegex(orasp.InputError, 'parts\\[3\\]: unknown key "weight"'):
            other.check()
        other["note"] = object()
        with self.assertRaisesRegex(orasp.InputError, "object is nothing that a problem can hold"):
            other.check()

    def test_one_id_needs_no_list(self):
        one, several = shelf(), shelf()
        one.require("left-board", after="right-board"), several.require("left-board", after=["right-board"])
        one.block("left", "right", "+x"), several.block("left", "right", ["+x"])
        one.aim(free="left"), several.aim(free=["left"])
        self.assertEqual(one, several)

    def test_fleets(self):
        problem = orasp.Problem("pair", objective="makespan")
        problem.add_part("1"), problem.add_part("2")
        problem.connect("1", "2", axis="+x")
        problem.fleet(2, [[1, 0], [2, 0]])
        result = orasp.solve(problem)
        self.assertEqual((result.makespan, len(result.fleet_steps), result.steps), (1, 1, []))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            problem.edited(objective="cubesat")
        self.assertEqual([str(w.message) for w in caught],
                         ["fleet: its 2 robots are not used: cubesat is an objective of one robot"])


class Version(unittest.TestCase):
    def test_is_that_of_the_project(self):
        project = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
        self.assertIn(f"project(orasp VERSION {orasp.__version__} ", project)


class Sources(unittest.TestCase):
    def test_files_names_dicts_and_texts(self):
        problem = shelf()
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "shelf.json"
            problem.save(file)
            for source in (file, str(file)):
                self.assertEqual(orasp.load(source), problem)
            self.assertEqual(orasp.Problem.read(file).name, "Shelf")
        self.assertEqual(orasp.load(problem.to_dict()), problem)
        self.assertEqual(orasp.Problem.from_json(problem.to_json()), problem)
        self.assertIs(orasp.load(problem), problem)
        self.assertEqual(orasp.Problem.scenario("grid:2x3").num_parts, 6)
        with self.assertRaisesRegex(orasp.InputError, "no built-in problem"):
            orasp.Problem.scenario("shelf")

    def test_keeps_what_is_not_for_the_library(self):
        content = {"format": "orasp-problem/1", "parts": [{"id": "a", "x-colour": "red", "note": "old"}], "connections": []}
        problem = orasp.load(content)
        problem.name = "n"
        self.assertEqual(problem["parts"], content["parts"])

    def test_the_examples_of_the_tree(self):
        for file in sorted((ROOT / "examples").glob("*.json")):
            content = json.loads(file.read_text())
            if content.get("format") == "orasp-problem/1":
                problem = orasp.load(file)
                self.assertEqual(orasp.load(problem.to_dict()).digest, problem.digest)

    def test_warns(self):
        with self.assertWarnsRegex(orasp.OraspWarning, "joins part .* to itself"):
            orasp.load("jwst")


    def test_a_byte_order_mark_is_passed_over(self):
        problem = orasp.Problem.from_json("\ufeff" + shelf().to_json())
        problem.name = "Shelf"
        self.assertEqual(problem, shelf())


class Values(unittest.TestCase):
    def test_equality_and_digest(self):
        self.assertEqual(shelf(), shelf())
        other = shelf()
        other.name = "Rack"
        self.assertNotEqual(shelf(), other)
        self.assertEqual(shelf().digest, other.digest)
        other.require("left-board", after=["right-board"])
        self.assertNotEqual(shelf().digest, other.digest)
        spelled_out = shelf().to_dict()
        spelled_out["parts"][0].update(name="", numbers={})
        self.assertEqual(orasp.load(spelled_out), shelf())
        self.assertNotEqual(shelf(), "Shelf")
        with self.assertRaises(TypeError):
            hash(shelf())

    def test_functions_count(self):
        one, same, other = shelf(), shelf(), shelf()
        one.objective = same.objective = orasp.Reward(heavy)
        other.objective = orasp.Reward(heavy, greatest=0)
        self.assertEqual(one, same)
        self.assertNotEqual(one, other)
        self.assertNotEqual(one, shelf())
        with self.assertRaisesRegex(orasp.InputError, "a callable is code"):
            one.to_json()
        self.assertEqual(one.edited(max_moved_parts=1).objective, one.objective)
        self.assertEqual(one.edited(max_moved_parts=1)["limits"], {"max_moved_parts": 1})
        self.assertEqual(one.edited(objective="time"), shelf())

    def test_pickle_and_copy(self):
        for seed in range(40):
            problem = orasp.load(random_problem(seed))
            again = pickle.loads(pickle.dumps(problem))
            self.assertEqual(again, problem)
            self.assertEqual(again.digest, problem.digest)
        problem = shelf()
        problem.objective = heavy
        again = pickle.loads(pickle.dumps(problem))
        self.assertEqual(orasp.solve(again).reward, orasp.solve(problem).reward)
        changed = copy.deepcopy(problem)
        changed.add_part("door")
        self.assertNotEqual(changed, problem)
        self.assertEqual(problem.num_parts, 3)
        self.assertEqual(orasp.load("hubble").copy(), orasp.load("hubble"))

    def test_repr_and_facts(self):
        self.assertEqual(repr(shelf()), "<orasp.Problem 'Shelf': 3 parts, 2 connections, time, disassembly>")
        self.assertEqual(shelf().ends.tolist(), [[0, 2], [1, 2]])
        self.assertEqual(shelf().connection_ids, ["left-board", "right-board"])
        self.assertEqual(shelf().part_ids, ["left", "right", "board"])


class Results(unittest.TestCase):
    def test_arrays_and_objects_agree(self):
        result = orasp.solve("table-hemnes", "greedy")
        content = result.to_dict()
        self.assertEqual([step.connection for step in result.steps], result.connections)
        self.assertEqual(result.connections, content[result.problem.direction])
        self.assertEqual(result.rewards.tolist(), [step.reward for step in result.steps])
        self.assertAlmostEqual(result.rewards.sum(), result.reward)
        self.assertEqual(result.sequence.dtype, np.int64)
        self.assertEqual([step for group in result.operations for step in group.steps],
                         list(range(1, len(result.steps) + 1)))
        self.assertEqual(result.order.tolist(), content["order"])
        self.assertEqual(result.statistics["expanded"], content["statistics"]["expanded"])
        self.assertEqual(result.gap, result.bound - result.reward if result.bound is not None else None)

    def test_without_a_plan(self):
        result = orasp.solve("4brick", max_moved_parts=0)
        self.assertEqual((result.status, result.reward, result.has_plan, result.gap), ("infeasible", -math.inf, False, None))
        self.assertEqual((result.connections, result.steps, len(result.rewards)), ([], [], 0))
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(orasp.InputError, "there is no plan"):
                result.save(Path(folder) / "plan.json")

    def test_other_plans(self):
        result = orasp.solve("lattice", count=True, alternatives=3)
        self.assertEqual(len(result.alternatives), 3)
        self.assertAlmostEqual(result.alternatives[0].reward, result.reward)
        self.assertGreater(result.optimal_sequences, 0)

    def test_expectations(self):
        problem = orasp.Problem(objective="time")
        problem.add_part("a"), problem.add_part("b")
        problem.connect("a", "b", success=0.25)
        result = orasp.solve(problem)
        self.assertEqual(result.expectation.attempts, 4)
        self.assertIn("orasp-state-policy/1", result.state_policy)

    def test_steps_of_parts(self):
        problem = shelf()
        problem.action = "part"
        problem.fix("board")
        result = orasp.solve(problem)
        self.assertEqual({step.connections for step in result.steps}, {("left-board",), ("right-board",)})


if __name__ == "__main__":
    unittest.main()
