#!/usr/bin/env python3
"""Tests problems of several robots, in every command that takes them.

    tests/cli/fleet_test.py PROGRAM [unittest's arguments]
"""
import json
import unittest

from program import CHAIN, Case, assembly, orasp, smoke


class Fleets(Case):
    def solve(self, *arguments):
        answer = orasp("solve", *arguments, "--json", "--quiet")
        return answer.code, json.loads(answer.out)

    def test_auto_plans_for_the_robots_of_a_fleet_and_says_so(self):
        self.check(orasp("solve", "fleet-lattice"), 0, error=r"\A\Z",
                   out=r"objective makespan.*\nstatus    optimal \(proved\)\nmakespan  4 steps\n[^$]*auto: fleet-search, since")
        code, plan = self.solve("fleet-lattice")
        self.assertEqual((code, plan["reward"], plan["fleet"]["makespan"]), (0, -4, 4))

    def test_published_values(self):
        for steps, travel in [("4", 81), ("5", 58), ("6", 54)]:
            with self.subTest(steps=steps):
                code, plan = self.solve("fleet-lattice", "--method", "fleet-search", "--objective", "fleet_travel", "--steps", steps)
                self.assertEqual((code, plan["status"], plan["reward"]), (0, "optimal", -travel))
        for robots, sites, steps in [(3, 2, 5), (3, 4, 5), (4, 2, 5), (4, 3, 4), (3, 1, None), (4, 1, None), (2, 4, None)]:
            with self.subTest(robots=robots, sites=sites):
                code, plan = self.solve("fleet-lattice", "--robots", str(robots), "--sites", str(sites))
                self.assertEqual((code, plan["fleet"]["makespan"]), (10 if steps is None else 0, steps))
        code, plan = self.solve("fleet-lattice", "--steps", "3")
        self.assertEqual((code, plan["status"]), (10, "infeasible"))

    @smoke
    def test_a_plan_is_evaluated_and_its_violations_are_named_by_step(self):
        output = self.folder / "plan.json"
        self.check(orasp("solve", "fleet-lattice", "-o", str(output)), 0)
        answer = orasp("evaluate", "fleet-lattice", str(output), "--json")
        self.check(answer, 0, error=r"\A\Z")
        verdict = json.loads(answer.out)
        self.assertEqual((verdict["valid"], verdict["reward"], verdict["makespan"], verdict["travel"]), (True, -4, 4, 81))
        answer = orasp("evaluate", "fleet-lattice", str(output), "--objective", "fleet_travel", "--json")
        self.assertEqual(json.loads(answer.out)["reward"], -81)
        self.check_sentence(orasp("evaluate", "fleet-lattice", str(output), "--objective", "cubesat", "--quiet"))
        self.check(orasp("solve", "fleet-lattice", "--robots", "2"), 10, out=r"with 2 robots and 4 sites every order of steps ends")
        self.check(orasp("evaluate", "fleet-lattice", str(output), "--robots", "3"), 10,
                   out=r"the plan is not valid[^$]*step 2: robots: there is no robot 4; robots are 1 to 3")
        plan = json.loads(output.read_text())
        plan["steps"][2]["moves"][0]["motion"] = "+y"
        plan["steps"][3]["connections"].pop()
        answer = orasp("evaluate", "fleet-lattice", "-", "--json", stdin=json.dumps(plan))
        self.check(answer, 10)
        found = [(violation["step"], violation["constraint"]) for violation in json.loads(answer.out)["violations"]]
        self.assertEqual(found[0], (3, "cut"))
        self.assertIn((5, "end"), found)

    def test_what_does_not_fit_is_a_sentence(self):
        axes = assembly(["1-2"], fleet={"robots": 2, "sites": [[1, 0]]})
        sites = axes.replace('"parts": ["1", "2"]', '"parts": ["1", "2"], "axis": "+x"').replace("[[1, 0]]", "[]")
        for arguments, problem, sentence in [
            ("solve - --method fleet-search", CHAIN, r"fleet-search plans for several robots, and cubesat is an objective of one"),
            ("solve - --method fleet-search", axes, r'connections\[0\]\.axis: connection "1-2" has no axis'),
            ("solve - --method fleet-search", sites, r"fleet\.sites: there is no site"),
            ("solve -", axes.replace('"robots": 2', '"robots": 0'), r"fleet\.robots: 0 is not allowed"),
            ("solve fleet-lattice --direction assembly", "", r'"assembly" is not allowed in a fleet problem'),
            ("solve fleet-lattice --objective makespan --method dijkstra", "", r"dijkstra plans for one robot, and makespan is an objective of several; use auto or fleet-search"),
            ("solve lattice --objective makespan", "", r'the problem has no "fleet"'),
            ("solve lattice --robots 2", "", r'--robots: the problem has no "fleet"'),
            ("solve lattice --steps 2", "", r"a horizon of 2 steps is for the objectives makespan and fleet_travel"),
            ("solve lattice --method greedy --steps 2", "", r"a horizon of 2 steps"),
            ("solve fleet-lattice --sites 5", "", r"--sites: 5 is more than the 4 sites"),
            ("solve fleet-lattice --robots 0", "", r'--robots: "0" is not a whole number'),
            ("solve fleet-lattice --count", "", r"--count lists plans of one robot, and makespan is an objective of several"),
            ("solve fleet-lattice --objective travel --robots 3", "", r"--robots: an objective of one robot leaves the fleet out"),
            ("graph fleet-lattice", "", r"graph answers for one robot, and the objective of this problem is makespan"),
            ("explain fleet-lattice", "", r"explain answers for one robot"),
            ("replan fleet-lattice", "", r"replan answers for one robot"),
            ("sample fleet-lattice", "", r"sample answers for one robot"),
            ("simulate fleet-lattice", "", r"simulate answers for one robot"),
            ("train fleet-lattice", "", r"train answers for one robot"),
            ("solve -", axes.replace('"parts": ["1", "2"]', '"parts": ["1", "2"], "axis": "+x", "duration": 2'),
             r"connections\[0\]\.duration: robots of a fleet work in steps"),
            ("solve -", axes[:-1] + ', "objective": {"type": "time"}}', r'objective\.type: "time" judges plans of one robot'),
        ]:
            with self.subTest(arguments=arguments, sentence=sentence):
                answer = orasp(*arguments.split(), stdin=problem)
                self.check_sentence(answer)
                self.assertRegex(answer.error, sentence)

    def test_an_objective_of_one_robot_leaves_the_fleet_out_with_a_warning(self):
        for arguments in [["--objective", "cubesat", "--method", "dijkstra"], ["--objective", "cubesat"]]:
            with self.subTest(arguments=arguments):
                answer = orasp("solve", "fleet-lattice", *arguments)
                self.check(answer, 0, out=r"reward   0\.0735\n", error=r"warning: fleet: its 4 robots are not used")

    def test_a_limit_leaves_a_plan_a_bound_and_a_gap(self):
        chain = json.dumps({"format": "orasp-problem/1", "parts": [{"id": str(i)} for i in range(100)],
                            "connections": [{"parts": [str(i), str(i + 1)], "axis": "-x"} for i in range(99)],
                            "fleet": {"robots": 10, "sites": [[1, 0], [0, 1], [2, 0], [0, 2]]}})
        answer = orasp("solve", "-", "--time-limit", "2", "--json", stdin=chain)
        self.check(answer, 20)
        plan = json.loads(answer.out)
        self.assertEqual((plan["status"], plan["stopped"]), ("feasible", "time limit"))
        self.assertLessEqual(plan["fleet"]["makespan"], 25)  # 19, unless the machine is very busy
        self.assertGreaterEqual(plan["bound"], plan["reward"])
        self.assertEqual(plan["gap"], plan["bound"] - plan["reward"])
        self.check(orasp("evaluate", "-", self.file("plan.json", answer.out), stdin=chain), 0)

    def test_compare_shows_makespan_and_travel(self):
        answer = orasp("compare", "fleet-lattice", "fleet-hubble", "lattice", "--objective", "fleet_travel", "--json")
        rows = json.loads(answer.out)["rows"]
        self.check(answer, 0)
        found = {(row["problem"], row["method"]): row for row in rows}
        self.assertEqual(found["fleet-lattice", "fleet-search"]["travel"], 81)
        self.assertEqual(found["fleet-hubble", "fleet-search"]["makespan"], 5)
        self.assertEqual({row["status"] for row in rows if row["problem"] == "lattice"}, {"refused"})  # no fleet
        table = orasp("compare", "fleet-lattice", "--methods", "fleet-search,dijkstra", "--csv").out.splitlines()
        self.assertTrue(table[0].endswith(",message,makespan,travel"))
        self.assertTrue(table[1].endswith(",4,81"))
        self.assertTrue(table[2].endswith(",,"))


if __name__ == "__main__":
    unittest.main()
