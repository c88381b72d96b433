#!/usr/bin/env python3
"""Tests `orasp graph`.

    tests/cli/graph_test.py PROGRAM [unittest's arguments]
"""
import json
import os
import unittest

from program import CYCLE, Case, orasp, smoke


class Graph(Case):
    def test_sizes_are_those_of_the_reference(self):
        for name, states, actions in [("lattice", 1296, 6048), ("hubble", 12096, 67824), ("2x3", 96, 304)]:
            with self.subTest(name=name):
                answer = orasp("graph", name, "--json")
                self.check(answer, 0)
                size = json.loads(answer.out)
                self.assertEqual(set(size), {"states", "actions", "layers", "dead_ends", "tree_nodes", "sequences",
                                             "seconds"})
                self.assertEqual((size["states"], size["actions"], size["dead_ends"]), (states, actions, 0))
                self.assertEqual(sum(layer["states"] for layer in size["layers"]), states)
                self.assertEqual(sum(layer["actions"] for layer in size["layers"]), actions)
        self.check(orasp("graph", "lattice"), 0, out=r"1,296 states, 6,048 actions, 0 dead ends")

    def test_numbers_past_two_to_the_53_are_strings(self):
        small = json.loads(orasp("graph", "4brick", "--json").out)
        self.assertEqual((small["tree_nodes"], small["sequences"]), (16, 6))  # 1 + 3 + 6 + 6
        large = json.loads(orasp("graph", "hubble-free", "--json").out)
        self.assertEqual(large["sequences"], str(121645100408832000))  # 19!

    def test_an_infeasible_problem_is_ten(self):
        self.check(orasp("graph", "-", stdin=CYCLE), 10, out=r"infeasible \(proved\)")
        size = json.loads(orasp("graph", "-", "--json", stdin=CYCLE).out)
        self.assertEqual((size["states"], size["dead_ends"], size["sequences"]), (1, 1, 0))

    @smoke
    def test_drawings_are_written(self):
        dot, svg = self.folder / "h.dot", self.folder / "h.svg"
        self.check(orasp("graph", "4piece", "--dot", str(dot), "--svg", str(svg)), 0, out=r"16 states, 32 actions")
        self.assertEqual(dot.read_text().count(" -> "), 32)
        self.assertEqual(svg.read_text().count('class="edge"'), 32)
        self.assertEqual(orasp("graph", "4piece", "--dot", "-").out, dot.read_text())
        self.assertEqual(orasp("graph", "4piece", "--svg", "-").out, svg.read_text())

    def test_too_large_to_draw_and_no_program_to_draw_with(self):
        svg = self.folder / "h.svg"
        self.check_sentence(orasp("graph", "hubble", "--svg", str(svg)))
        answer = orasp("graph", "4piece", "--svg", str(svg), environment={"PATH": "/nonexistent"})
        self.check_sentence(answer)
        self.assertIn("Debian package graphviz", answer.error)
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_program_that_fails_to_draw(self):
        dot = self.folder / "dot"
        dot.write_text("#!/bin/sh\necho 'no such luck' >&2\nexit 3\n")
        dot.chmod(0o755)
        answer = orasp("graph", "4piece", "--svg", str(self.folder / "h.svg"),
                       environment={"PATH": f"{self.folder}:{os.environ['PATH']}"})
        self.check_sentence(answer)
        self.assertRegex(answer.error, r"exit code 3: no such luck")
        self.assertEqual(os.listdir(self.folder), ["dot"])

    def test_a_limit_gives_the_layers_so_far(self):
        answer = orasp("graph", "chain:27", "--time-limit", "1", "--json")
        self.check(answer, 20)
        size = json.loads(answer.out)
        self.assertEqual((size["stopped"], size["sequences"], size["tree_nodes"]), ("time limit", None, None))
        self.assertGreater(size["states"], 1)


if __name__ == "__main__":
    unittest.main()
