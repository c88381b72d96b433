#!/usr/bin/env python3
"""Tests the method mip: models that are written, and the solver.

    tests/cli/integer_program_test.py PROGRAM [unittest's arguments]
"""
import json
import signal
import subprocess
import unittest

from program import PROGRAM, Case, assembly, orasp, smoke, wait_for_work


class IntegerProgram(Case):
    @smoke
    def test_a_model_is_written_and_not_solved(self):
        for ending, begin in (("lp", "\\ connection 1 is 1-2"), ("mps", "* connection 1 is 1-2")):
            file = self.folder / f"model.{ending}"
            answer = orasp("solve", "4brick", "--method", "mip", "--write-model", file, "--quiet")
            self.assertEqual((answer.code, answer.error), (0, ""))
            self.assertRegex(answer.out, rf"model\.{ending}: \d+ columns \(\d+ whole\), \d+ rows, \d+ terms; its objective")
            self.assertTrue(file.read_text(encoding="ascii").startswith(begin))

    def test_ids_are_printable_ascii_in_their_remark(self):
        text = assembly(["1-2"]).replace('"parts": ["1", "2"]', '"id": "a End \u00e4", "parts": ["1", "2"]')
        file = self.folder / "model.lp"
        answer = orasp("solve", "-", "--method", "mip", "--write-model", file, stdin=text)
        self.assertEqual(answer.code, 0, answer.error)
        self.assertTrue(file.read_text(encoding="ascii").startswith("\\ connection 1 is a End ??\nMinimize\n"))

    def test_a_model_of_a_fleet_has_as_many_steps_as_asked(self):
        sizes = []
        for steps in (4, 5):
            file = self.folder / "model.mps"
            answer = orasp("solve", "fleet-lattice", "--objective", "fleet_travel", "--steps", str(steps), "--method", "mip",
                           "--write-model", file, "--json")
            self.assertEqual(answer.code, 0, answer.error)
            sizes.append(json.loads(answer.out)["columns"])
        self.assertLess(sizes[0], sizes[1])

    def test_what_makes_no_model_is_refused_before_anything_is_written(self):
        for words, sentence in [
            (["4brick", "--write-model", "m.txt"], r"m\.txt: a model is written as FILE\.lp or FILE\.mps"),
            (["4brick", "--write-model", "m.lp", "-o", "plan.json"], r"--write-model solves nothing, so --output has no plan"),
            (["4brick", "--write-model", "m.lp", "--count"], r"--write-model solves nothing, so --count has no plan"),
            (["iss", "--write-model", "m.lp", "--objective", "travel"], r"'travel'|position"),
            (["chain:40", "--write-model", "m.lp"], r"mip takes at most 32 connections for its integer program; this problem has 39"),
            (["fleet-lattice", "--write-model", "m.lp", "--objective", "fleet_travel"], r"needs --steps"),
        ]:
            with self.subTest(words=words):
                answer = orasp("solve", *words, "--method", "mip", cwd=self.folder)
                self.assertEqual(answer.code, 30, answer.out)
                self.assertRegex(answer.error, sentence)
                self.assertEqual(list(self.folder.iterdir()), [])
        answer = orasp("solve", "4brick", "--write-model", "m.lp")
        self.assertEqual(answer.code, 30)
        self.assertIn("--write-model belongs to the method mip, not to auto", answer.error)

    def test_it_solves_one_robot_and_a_fleet_or_says_how_to_get_the_solver(self):
        answer = orasp("solve", "4brick", "--method", "mip", "--json")
        if answer.code == 30:
            self.assertIn("install the package coinor-libcbc-dev", answer.error)
            self.skipTest("built without CBC")
        self.assertEqual(json.loads(answer.out)["reward"], 0.557)
        answer = orasp("solve", "fleet-lattice", "--method", "mip", "--json")
        self.assertEqual((answer.code, json.loads(answer.out)["status"]), (0, "optimal"), answer.error)

    def test_ctrl_c_ends_the_solver_with_the_best_plan_so_far(self):
        process = self.not_beyond(subprocess.Popen([PROGRAM, "solve", "hubble", "--method", "mip", "--json"],
                                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
        wait_for_work(process, 1.2)
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=60)
        if process.returncode == 30:
            self.skipTest("built without CBC")
        self.assertEqual(process.returncode, 20, error)
        self.assertEqual(json.loads(out)["stopped"], "interrupted")


if __name__ == "__main__":
    unittest.main()
