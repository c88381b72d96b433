"""Rewards that are functions of Python, one step or many at a time."""
import math
import unittest
import warnings

import numpy as np
import orasp
from program import random_problem

FORMULA = ("-moved_parts * before - 0.5 * kept_parts + 3 * completes - 0.25 * separates - subassemblies - 0.125 * duration"
           " + 0.01 * moved_mass - 0.02 * kept_mass - 0.001 * index - 0.1 * after - 0.05 * distance - 0.03 * elapsed")


def many(s):
    return (-s.moved_parts * s.before - 0.5 * s.kept_parts + 3 * s.completes - 0.25 * s.separates - s.subassemblies
            - 0.125 * s.duration + 0.01 * s.moved_mass - 0.02 * s.kept_mass - 0.001 * s.index - 0.1 * s.after
            - 0.05 * s.distance - 0.03 * s.elapsed)


def one(step):
    return -len(step.moved) * step.before - 0.5 * len(step.kept) - 0.001 * step.index


def one_many(s):
    return -s.moved_parts * s.before - 0.5 * s.kept_parts - 0.001 * s.index


class Agreement(unittest.TestCase):
    def test_many_steps_see_what_formulas_see(self):
        """The same plans and rewards as a formula, in both directions, by methods that build H and that search."""
        for seed in range(60):
            content = random_problem(seed)
            content["objective"] = {"type": "expression", "formula": FORMULA}
            for method in ("value-iteration", "dijkstra", "exhaustive", "greedy"):
                with self.subTest(seed=seed, method=method):
                    formula = orasp.solve(content, method)
                    function = orasp.solve(content, method, objective=orasp.Reward(many, vectorized=True))
                    self.assertEqual(function.status, formula.status)
                    self.assertEqual(function.connections, formula.connections)
                    if formula.has_plan:
                        self.assertAlmostEqual(function.reward, formula.reward, places=9)

    def test_one_step_at_a_time(self):
        for seed in range(30):
            content = random_problem(seed)
            content.pop("base", None)
            with self.subTest(seed=seed):
                single = orasp.solve(content, "value-iteration", objective=one)
                vectorised = orasp.solve(content, "value-iteration", objective=orasp.Reward(one_many, vectorized=True))
                self.assertEqual(single.connections, vectorised.connections)

    def test_numbers_of_ones_own(self):
        problem = orasp.Problem()
        for name, value in (("a", 2), ("b", 5), ("c", 11)):
            problem.add_part(name, numbers={"price": value})
        problem.connect("a", "b", numbers={"price": 100}), problem.connect("b", "c")
        formula = "-price - moved_price * before + 0.5 * kept_price"
        problem.objective = {"type": "expression", "formula": formula}
        expected = orasp.solve(problem).reward
        problem.objective = orasp.Reward(lambda s: -s.price - s["moved_price"] * s.before + 0.5 * s.kept_price, vectorized=True)
        self.assertAlmostEqual(orasp.solve(problem).reward, expected)

    def test_a_sum_over_the_plan(self):
        result = orasp.solve("hubble", objective=one)
        self.assertAlmostEqual(result.rewards.sum(), result.reward)
        self.assertEqual(orasp.evaluate(result.problem, result).reward, result.reward)

    def test_wide_steps(self):
        """Where a step takes several connections, or the goal stops early, steps come one by one."""
        problem = orasp.load("lattice").copy()
        problem["goal"] = {"free": ["1", "9"]}
        reward = orasp.Reward(lambda s: -1.0 - s.moved_parts, vectorized=True)
        expected = orasp.solve(problem, objective={"type": "expression", "formula": "-1 - moved_parts"})
        self.assertEqual(orasp.solve(problem, objective=reward).reward, expected.reward)

    def test_a_range_makes_bounds(self):
        reward = orasp.Reward(one_many, vectorized=True, greatest=0)
        best = orasp.solve("lattice", objective=one).reward
        result = orasp.solve("lattice", "orasp-search", objective=reward)
        self.assertEqual(result.status, "optimal")
        self.assertAlmostEqual(result.reward, best)
        with self.assertRaises(orasp.InputError):
            orasp.solve("lattice", "orasp-search", objective=one)

    def test_other_commands_take_it(self):
        reward = orasp.Reward(one_many, vectorized=True)
        self.assertEqual(len(orasp.sample("lattice", 10, objective=reward).rewards), 10)
        h = orasp.graph("lattice", objective=reward)
        self.assertAlmostEqual(h.values()[0], orasp.solve("lattice", objective=one).reward)
        cell = orasp.Replanner("lattice", objective=one)
        self.assertAlmostEqual(cell.plan().reward, h.values()[0])
        self.assertEqual(orasp.replan("lattice", objective=one).status, "optimal")
        self.assertTrue(orasp.report("lattice", objective=one).html)


class Faults(unittest.TestCase):
    def test_an_exception_comes_out_as_itself(self):
        class Mine(Exception):
            pass

        def bad(step):
            if step.before < 5:
                raise Mine("no more")
            return 0.0

        def bad_many(steps):
            raise Mine("no more")

        for method in ("auto", "value-iteration", "dijkstra", "a-star", "beam", "greedy", "random", "bellman-ford"):
            for reward in (orasp.Reward(bad, greatest=0), orasp.Reward(bad_many, vectorized=True, greatest=0)):
                with self.subTest(method=method), self.assertRaisesRegex(Mine, "no more"):
                    orasp.solve("lattice", method, objective=reward, threads=2)

    def test_not_a_number(self):
        sentence = 'objective: the reward of removing "[^"]+" with 12 connections present is '
        for value in (math.nan, math.inf, -math.inf):
            for reward in (orasp.Reward(lambda step, v=value: v), orasp.Reward(lambda s, v=value: np.full(len(s), v), vectorized=True)):
                with self.subTest(value), self.assertRaisesRegex(orasp.InputError, sentence):
                    orasp.solve("lattice", "value-iteration", objective=reward)

    def test_wrong_answers(self):
        with self.assertRaisesRegex(TypeError, "the reward of a step must be a number, not str"):
            orasp.solve("lattice", objective=lambda step: "much")
        with self.assertRaisesRegex(ValueError, r"the rewards of 8 steps must be an array of shape \(8,\), not \(3,\)"):
            orasp.solve("lattice", "value-iteration", objective=orasp.Reward(lambda s: [1, 2, 3], vectorized=True))
        with self.assertRaisesRegex(TypeError, "must be an array of numbers, not str"):
            orasp.solve("lattice", objective=orasp.Reward(lambda s: "much", vectorized=True))
        with self.assertRaisesRegex(AttributeError, "steps have no column mass; they have before, after, "):
            orasp.solve("lattice", objective=orasp.Reward(lambda s: -s.mass, vectorized=True))
        with self.assertRaisesRegex(orasp.InputError, "least 1 and greatest 0 are not a range"):
            orasp.solve("lattice", objective=orasp.Reward(one, least=1, greatest=0))

    def test_kept_steps_are_gone(self):
        kept = []
        orasp.solve("lattice", objective=orasp.Reward(lambda s: (kept.append(s), -s.before)[1], vectorized=True))
        with self.assertRaisesRegex(RuntimeError, "the steps are gone"):
            kept[0].before

    def test_steps_may_be_kept_one_by_one(self):
        kept = []
        orasp.solve("4piece", objective=lambda step: (kept.append(step), 0.0)[1])
        self.assertTrue(all(set(step.moved) <= {"1", "2", "3", "4"} for step in kept))


class Cost(unittest.TestCase):
    def test_many_steps_come_at_once(self):
        sizes = []
        orasp.solve("lattice", "value-iteration", objective=orasp.Reward(lambda s: (sizes.append(len(s)), -s.before)[1], vectorized=True))
        self.assertGreater(max(sizes), 500)
        self.assertLess(len(sizes), 60)


if __name__ == "__main__":
    warnings.simplefilter("ignore", orasp.OraspWarning)
    unittest.main()
