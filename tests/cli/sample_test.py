#!/usr/bin/env python3
"""Tests `orasp sample`.

    tests/cli/sample_test.py PROGRAM [unittest's arguments]
"""
import json
import statistics
import unittest

from program import CYCLE, Case, orasp, smoke


class Sample(Case):
    @smoke
    def test_the_figures_are_those_of_the_rewards(self):
        answer = orasp("sample", "hubble-free", "-n", "101", "--seed", "3", "--json")
        self.check(answer, 0)
        sample = json.loads(answer.out)
        self.assertEqual(list(sample), ["n", "seed", "mean", "deviation", "min", "quartiles", "max", "rewards"])
        rewards = sample["rewards"]
        self.assertEqual((sample["n"], sample["seed"], len(rewards)), (101, 3, 101))
        self.assertAlmostEqual(sample["mean"], statistics.mean(rewards))
        self.assertAlmostEqual(sample["deviation"], statistics.stdev(rewards))
        self.assertEqual((sample["min"], sample["max"]), (min(rewards), max(rewards)))
        for ours, theirs in zip(sample["quartiles"], statistics.quantiles(rewards, n=4, method="inclusive")):
            self.assertAlmostEqual(ours, theirs)

    def test_the_same_seed_gives_the_same_bytes_and_longer_samples_begin_alike(self):
        first = orasp("sample", "hubble", "-n", "20", "--json").out
        self.assertEqual(first, orasp("sample", "hubble", "-n", "20", "--seed", "1", "--json").out)
        longer = json.loads(orasp("sample", "hubble", "-n", "30", "--json").out)
        self.assertEqual(longer["rewards"][:20], json.loads(first)["rewards"])

    def test_evaluate_agrees_with_each_sampled_sequence(self):
        for changes in ([], ["--direction", "assembly"]):
            sample = json.loads(orasp("sample", "hubble-upc", "-n", "5", "--json", "--sequences", *changes).out)
            self.assertEqual(len(sample["sequences"]), 5)
            for reward, sequence in zip(sample["rewards"], sample["sequences"]):
                answer = orasp("evaluate", "hubble-upc", "-", "--json", *changes, stdin=json.dumps(sequence))
                self.check(answer, 0)
                self.assertAlmostEqual(json.loads(answer.out)["reward"], reward)

    def test_one_reward_has_no_deviation(self):
        sample = json.loads(orasp("sample", "hubble", "-n", "1", "--json").out)
        self.assertEqual(sample["deviation"], 0)
        self.assertEqual(sample["quartiles"], sample["rewards"] * 3)

    def test_an_infeasible_problem_is_ten(self):
        self.check(orasp("sample", "-", stdin=CYCLE), 10, out=r'"1-2" after "2-3"')
        answer = orasp("sample", "-", "--json", stdin=CYCLE)
        self.check(answer, 10, error=r'"1-2" after "2-3"')
        self.assertEqual(json.loads(answer.out)["n"], 0)

    def test_people_see_a_histogram(self):
        self.check(orasp("sample", "hubble", "-n", "200"), 0, out=r"mean +-\d.*\n(.*\n)+rewards from\n(.*#.*\n)+")


if __name__ == "__main__":
    unittest.main()
