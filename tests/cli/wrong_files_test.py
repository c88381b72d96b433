#!/usr/bin/env python3
"""Tests files that are no problem and no plan.

    tests/cli/wrong_files_test.py PROGRAM [unittest's arguments]
"""
import unittest

from program import CHAIN, Case, orasp, smoke


class WrongFiles(Case):
    def test_a_file_that_is_no_problem_is_refused_in_a_sentence(self):
        million = '{"format": "orasp-problem/1", "parts": [{"id": "1"}, {"id": "2"}], "connections": [' + ",".join(
            f'{{"id": "{i}", "parts": ["1", "2"]}}' for i in range(10**6)) + "]}"
        for name, content, sentence in [
            ("empty", "", r"the file is empty"),
            ("blank", " \n", r"empty"),
            ("not JSON", "hello", r"line 1, column 1"),
            ("cut off", CHAIN[:-1], r"line 1, column"),
            ("not UTF-8", b'{"name": "\xff"}', r"0xff is not valid UTF-8"),
            ("NaN", CHAIN.replace('{"id": "1"}', '{"id": "1", "mass": NaN}'), r"NaN"),
            ("an infinite number", CHAIN.replace('{"id": "1"}', '{"id": "1", "mass": 1e999}'), r"1e999|finite"),
            ("an unknown key", CHAIN.replace('"parts": [{', '"prats": 1, "parts": [{'), r'"prats"'),
            ("an unknown key inside", CHAIN.replace('{"id": "1"}', '{"id": "1", "weight": 1}'), r'parts\[0\].*"weight"'),
            ("a wrong type", CHAIN.replace('{"id": "1"}', '{"id": 1}'), r"parts\[0\]\.id"),
            ("an id twice", CHAIN.replace('{"id": "2"}', '{"id": "1"}'), r"parts\[1\]"),
            ("a missing part", CHAIN.replace('["3", "4"]', '["3", "5"]'),
             r'connections\[2\]\.parts\[1\]: no part "5"'),
            ("a million connections", million, r"1,?000,?000|16,?384"),
        ]:
            with self.subTest(fault=name):
                for problem, stdin in [(self.file("problem.json", content), ""), ("-", content)]:
                    output = self.folder / "plan.json"
                    answer = orasp("solve", problem, "-o", str(output), stdin=stdin)
                    self.check_sentence(answer)
                    self.assertIn("standard input" if problem == "-" else "problem.json", answer.error)
                    self.assertRegex(answer.error, sentence)
                    self.assertLess(len(answer.error), 500)
                    self.assertFalse(output.exists())

    def test_what_cannot_be_read_is_named(self):
        plan = self.file("plan.json", "[]")
        for arguments in [["solve", str(self.folder)], ["solve", str(self.folder / "none.json")],
                          ["evaluate", "4brick", str(self.folder)], ["evaluate", "4brick", str(self.folder / "none")],
                          ["evaluate", str(self.folder), plan], ["graph", str(self.folder)],
                          ["compare", "4brick", str(self.folder)], ["sample", str(self.folder)],
                          ["solve", "4brick", "--objective", str(self.folder / "none.json")]]:
            with self.subTest(arguments=arguments):
                answer = orasp(*arguments)
                self.check_sentence(answer)
                self.assertIn(str(self.folder), answer.error)

    @smoke
    def test_a_plan_that_is_none_is_refused(self):
        for content in ["", "{}", "[1]", '{"format": "orasp-plan/1"}', b"\xff\n"]:
            with self.subTest(content=content):
                answer = orasp("evaluate", "4brick", self.file("plan.json", content))
                self.check_sentence(answer)
                self.assertIn("plan.json", answer.error)

    def test_control_characters_do_not_reach_the_terminal(self):
        problem = CHAIN.replace('"name": "test"', '"name": "\\u001b[31mred"')
        answer = orasp("solve", "-", stdin=problem)
        self.assertNotIn("\x1b", answer.out + answer.error)
        self.assertNotIn("\x1b", orasp("solve", "\x1b[31mred").error)


if __name__ == "__main__":
    unittest.main()
