#!/usr/bin/env python3
"""Tests `orasp scenarios`.

    tests/cli/scenarios_test.py PROGRAM [unittest's arguments]
"""
import json
import re
import unittest

from program import Case, orasp, smoke


class Scenarios(Case):
    def test_each_can_be_printed_and_solved_from_standard_input(self):
        listing = json.loads(orasp("scenarios", "--json").out)
        names = [entry["name"] for entry in listing]
        self.assertLessEqual({"lattice", "hubble", "jwst-upc", "chain:N"}, set(names))
        human = orasp("scenarios").out
        for entry in listing:
            self.assertEqual(set(entry), {"name", "parts", "connections", "summary", "generator"})
            self.assertRegex(human, rf"(?m)^{re.escape(entry['name'])} ")
            if entry["generator"]:
                continue
            with self.subTest(name=entry["name"]):
                problem = json.loads(orasp("scenarios", entry["name"]).out)
                self.assertEqual(len(problem["parts"]), entry["parts"])
                self.assertEqual(len(problem["connections"]), entry["connections"])
        text = orasp("scenarios", "grid:3x3").out
        by_name = json.loads(orasp("solve", "grid:3x3", "--json").out)
        by_file = json.loads(orasp("solve", "-", "--json", stdin=text).out)
        self.assertEqual(by_name["problem_digest"], by_file["problem_digest"])
        self.assertEqual(by_name["disassembly"], by_file["disassembly"])

    @smoke
    def test_it_can_be_written_to_a_file(self):
        path = self.folder / "lattice.json"
        answer = orasp("scenarios", "lattice", "-o", str(path))
        self.assertEqual(path.read_text(), answer.out)


if __name__ == "__main__":
    unittest.main()
