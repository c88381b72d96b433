#!/usr/bin/env python3
"""Tests `orasp compare`.

    tests/cli/compare_test.py PROGRAM [unittest's arguments]
"""
import csv
import io
import json
import unittest

from program import CHAIN, Case, orasp, smoke


class Compare(Case):
    KEYS = ["problem", "method", "status", "reward", "bound", "seconds", "states", "actions", "expanded", "generated",
            "pruned", "message"]

    def test_every_exact_method_agrees_and_is_there_by_default(self):
        answer = orasp("compare", "2x3", "4brick", "--json")
        self.check(answer, 0, error=r"\A\Z")
        document = json.loads(answer.out)
        self.assertEqual(list(document), ["rows"])
        rows = document["rows"]
        for row in rows:
            self.assertEqual(list(row), self.KEYS)
            self.assertEqual(row["status"], "optimal")
            self.assertAlmostEqual(row["reward"], {"2x3": 0.3636, "4brick": 0.557}[row["problem"]], places=9)
        self.assertLessEqual({"value-iteration", "dijkstra", "bellman-ford", "orasp-search", "exhaustive"},
                             {row["method"] for row in rows})

    def test_a_method_that_refuses_has_a_row_where_it_was_named(self):
        answer = orasp("compare", "jwst", "--methods", "dijkstra,greedy", "--json", "--quiet")
        self.check(answer, 0)
        refused, greedy = json.loads(answer.out)["rows"]
        self.assertEqual((refused["method"], refused["status"], refused["reward"]), ("dijkstra", "refused", None))
        self.assertIn("state-action graph", refused["message"])
        self.assertEqual(greedy["status"], "feasible")
        rows = json.loads(orasp("compare", "grid:4x3", "--json", "--time-limit", "20").out)["rows"]  # 17 connections
        self.assertNotIn("exhaustive", [row["method"] for row in rows])

    @smoke
    def test_the_table_in_other_forms(self):
        name = self.folder / 'a, "b".json'
        name.write_text(CHAIN)
        answer = orasp("compare", str(name), "jwst", "--methods", "dijkstra,greedy", "--csv", "--quiet")
        rows = list(csv.DictReader(io.StringIO(answer.out)))
        self.assertEqual(list(rows[0]), self.KEYS)
        self.assertEqual([row["problem"] for row in rows], [str(name)] * 2 + ["jwst"] * 2)
        self.assertAlmostEqual(float(rows[0]["reward"]), 0.557)
        self.assertEqual(rows[2]["status"], "refused")
        lines = orasp("compare", "4brick", "--methods", "greedy,dijkstra", "--markdown").out.splitlines()
        self.assertEqual(len(lines), 4)
        self.assertRegex(lines[0], r"^\| problem +\| method +\| status +\| reward +\| seconds +\| states")
        self.assertEqual(len({line.count("|") for line in lines}), 1)

    def test_a_limit_holds_for_each_run_and_is_no_failure(self):
        answer = orasp("compare", "grid:10x10", "--methods", "orasp-search,greedy", "--objective", "time",
                       "--time-limit", "0.3", "--json")
        self.check(answer, 0)
        self.assertEqual(json.loads(answer.out)["rows"][0]["message"].split(";")[0], "stopped by the time limit")

    def test_the_table_is_written_too(self):
        path = self.folder / "table"
        answer = orasp("compare", "4brick", "--methods", "greedy", "--csv", "-o", str(path))
        self.assertEqual(path.read_text(), answer.out)
        orasp("compare", "4brick", "--methods", "greedy", "-o", str(path))
        self.assertEqual(json.loads(path.read_text())["rows"][0]["method"], "greedy")


if __name__ == "__main__":
    unittest.main()
