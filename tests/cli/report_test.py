#!/usr/bin/env python3
"""Tests `orasp report`.

    tests/cli/report_test.py PROGRAM [unittest's arguments]
"""
import json
import os
import re
import unittest

from program import CYCLE, ROOT, Case, orasp, smoke


class Report(Case):
    def data_of(self, page):
        """The data that a page holds."""
        return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1])

    @smoke
    def test_the_page_is_written_whole_and_said_to_be(self):
        path = self.folder / "page.html"
        self.check(orasp("report", "2x3", "-o", path), 0, out=r"\A2x3: 1 plan, written to .*page\.html \(\d+ kB\)\n\Z")
        page = path.read_text(encoding="utf-8")
        self.assertTrue(page.startswith("<!doctype html>") and page.rstrip().endswith("</html>"))
        self.assertLess(len(page.encode()), 2 << 20)
        self.assertNotRegex(page, r"orasp:(title|style|data|3d|script|policy)")
        data = self.data_of(page)
        self.assertEqual(data["plans"][0]["status"], "optimal")
        self.assertEqual(orasp("report", "2x3", "-o", "-").out.count("</html>"), 1)

    def test_what_makes_no_sense_is_refused_in_a_sentence(self):
        sample = self.file("sample.json", "[1, 2]")
        page = str(self.folder / "page.html")
        for words, said in [
            (["2x3"], "-o FILE is missing"),
            (["2x3", "-o", page, "--sample", sample, "--sample-count", "3"], "exclude each other"),
            (["-", "-", "-o", page], "one thing only"),
            (["2x3", "-o", page, "--sample", self.file("bad.json", "{}")], 'bad.json: the key "rewards" is missing'),
            (["2x3", "-o", page, "--log", self.file("log", "{}\n")], "log: training log, line 1: the key"),
            (["2x3", "no-such-plan", "-o", page], "cannot read"),
            (["chain:1500", *[self.file("long.txt", "\n".join(f"{i}-{i + 1}" for i in range(1, 1500)))] * 8,
              "--time-limit", "0.1", "-o", page], "the report would take"),
        ]:
            with self.subTest(words=words):
                answer = orasp("report", *words)
                self.check_sentence(answer)
                self.assertIn(said, answer.error)
                self.assertFalse(os.path.exists(page))

    def test_a_plan_that_breaks_rules_is_shown_and_ten(self):
        page = self.folder / "page.html"
        self.check(orasp("report", ROOT / "examples/shelf.json", ROOT / "examples/shelf-wrong-order.txt", "-o", page), 10)
        plan = self.data_of(page.read_text(encoding="utf-8"))["plans"][0]
        self.assertEqual(plan["status"], "not valid")
        self.assertEqual([violation[2] for violation in plan["violations"]], ["precedence", "blocking"])

    def test_a_problem_without_a_plan_is_shown_with_the_conflict_and_ten(self):
        page = self.folder / "page.html"
        self.check(orasp("report", self.file("cycle.json", CYCLE), "-o", page), 10)
        data = self.data_of(page.read_text(encoding="utf-8"))
        self.assertEqual(data["plans"], [])
        self.assertEqual(len(data["best"]["conflict"]), 2)

    def test_steps_that_take_parts_off_are_shown(self):
        page = self.folder / "page.html"
        problem = {"format": "orasp-problem/1", "action": "part", "parts": [{"id": name} for name in "abcd"],
                   "connections": [{"parts": [a, b]} for a, b in ("ab", "bc", "cd", "ad")], "objective": {"type": "completion"}}
        path = self.file("square.json", json.dumps(problem))
        self.check(orasp("report", path, "-o", page), 0)
        solved = orasp("solve", path, "--json").out
        plan = self.data_of(page.read_text(encoding="utf-8"))["plans"][0]
        cuts = [[problem["connections"][c]["parts"] for c in step["cut"]] for step in plan["steps"]]
        self.assertEqual([["-".join(parts) for parts in cut] for cut in cuts], json.loads(solved)["disassembly"])
        self.check(orasp("report", path, self.file("plan.json", solved), "-o", page), 0)
        self.assertEqual(self.data_of(page.read_text(encoding="utf-8"))["plans"][0]["status"], "optimal")
        wrong = self.file("wrong.json", json.dumps([["a-b", "a-d"], ["b-c"], ["c-d"], ["a-b"]]))
        self.check(orasp("report", path, wrong, "-o", page), 10)
        answer = orasp("report", path, "--svg", self.folder / "svg")
        self.check_sentence(answer)
        self.assertIn('with "action": "part" a step takes several', answer.error)

    def test_without_the_file_of_shapes_the_report_is_as_before_with_a_warning(self):
        os.mkfifo(self.folder / "pipe.glb")
        problem = json.loads(orasp("scenarios", "3piece").out)
        pages = {}
        for name, content, said in [
            (None, None, None),
            ("missing.glb", None, r"warning: geometry: cannot read .*missing\.glb.*: No such file or directory; the report does without"),
            (".", None, r"warning: geometry: cannot read .*: Is a directory; the report does without"),
            ("pipe.glb", None, r'warning: geometry: ".*pipe\.glb" is no file; the report does without'),  # without a writer
            ("bad.glb", "solid cube", r'warning: geometry: "bad\.glb": it is not a binary glTF file; the report does without'),
        ]:
            with self.subTest(name=name):
                if content:
                    self.file(name, content)
                if name:
                    problem["geometry"] = {"file": name}
                page = self.folder / "page.html"
                answer = orasp("report", self.file("problem.json", json.dumps(problem)), "-o", page)
                self.check(answer, 0, **({"error": said} if said else {}))
                data = self.data_of(page.read_text(encoding="utf-8"))
                shapes = data.pop("shapes")
                self.assertEqual(shapes is None, name is None)
                if shapes:
                    self.assertTrue(shapes["fault"].startswith("The true parts are not shown: "))
                    self.assertNotIn(str(self.folder), shapes["fault"])
                del data["best"]["effort"]
                pages[name] = data
        self.assertEqual(pages["missing.glb"], pages[None])
        self.assertEqual(pages["bad.glb"], pages[None])

    def test_claims_of_a_plan_file_are_not_believed(self):
        plan = json.loads(orasp("solve", "lattice", "--method", "greedy", "--json").out)
        plan.update(status="optimal", bound=plan["reward"])
        page = self.folder / "page.html"
        self.check(orasp("report", "lattice", self.file("claim.json", json.dumps(plan)), "-o", page), 0)
        shown = self.data_of(page.read_text(encoding="utf-8"))["plans"][0]
        self.assertEqual(shown["status"], "feasible")
        self.assertAlmostEqual(shown["gap"], 0.012)

    def test_a_plan_for_another_problem_is_worth_a_warning(self):
        plan = json.loads(orasp("solve", "2x3", "--json").out)
        plan["problem_digest"] = "0" * 64
        answer = orasp("report", "2x3", self.file("plan.json", json.dumps(plan)), "-o", self.folder / "page.html")
        self.check(answer, 0, error=r"warning: .*plan\.json was made for another problem")

    def test_a_sample_is_that_of_sample(self):
        page = self.folder / "page.html"
        self.check(orasp("report", "hubble", "--sample-count", "50", "--seed", "3", "-o", page), 0)
        sample = self.data_of(page.read_text(encoding="utf-8"))["sample"]
        expected = json.loads(orasp("sample", "hubble", "-n", "50", "--seed", "3", "--json").out)
        for name in ("n", "mean", "deviation", "min", "quartiles", "max"):
            self.assertEqual(sample[name], expected[name])

    def test_a_fleet_is_shown_robot_by_robot(self):
        page = self.folder / "page.html"
        self.check(orasp("report", "fleet-lattice", "-o", page), 0)
        data = self.data_of(page.read_text(encoding="utf-8"))
        solved = json.loads(orasp("solve", "fleet-lattice", "--json").out)
        self.assertEqual(data["fleet"]["robots"], 4)
        self.assertEqual(len(data["plans"][0]["steps"]), len(solved["steps"]))
        travel = self.file("travel.json", orasp("solve", "fleet-lattice", "--objective", "fleet_travel", "--json").out)
        self.check(orasp("report", "fleet-lattice", travel, "-o", page), 0)
        self.assertEqual(self.data_of(page.read_text(encoding="utf-8"))["plans"][0]["status"], "optimal")
        one = self.file("one.txt", "")
        self.check_sentence(orasp("report", "fleet-lattice", travel, one, "-o", page))
        self.check_sentence(orasp("report", "fleet-lattice", "--sample-count", "3", "-o", page))


if __name__ == "__main__":
    unittest.main()
