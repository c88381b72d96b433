#!/usr/bin/env python3
"""Tests `orasp solve --certificate` and `orasp check`.

    tests/cli/check_test.py PROGRAM [unittest's arguments]
"""
import json
import unittest

from program import Case, assembly, orasp, smoke

CYCLE = assembly(["1-2", "2-3"], precedence=[{"connection": "1-2", "after": ["2-3"]},
                                             {"connection": "2-3", "after": ["1-2"]}])


class Check(Case):
    def certified(self, *words, stdin=""):
        """Solves, and returns the files of plan and certificate."""
        plan, certificate = str(self.folder / "plan.json"), str(self.folder / "certificate.json")
        self.check(orasp("solve", *words, "-o", plan, "--certificate", certificate, stdin=stdin), 0, error=r"\A\Z")
        return plan, certificate

    @smoke
    def test_an_optimal_plan_is_proved_in_both_directions(self):
        for objective, kind in [("cubesat", "sizes"), ("indexed", "states")]:
            for direction in ["disassembly", "assembly"]:
                with self.subTest(objective=objective, direction=direction):
                    changes = ["--objective", objective, "--direction", direction]
                    plan, certificate = self.certified("lattice", *changes)
                    answer = orasp("check", "lattice", plan, certificate, *changes)
                    self.check(answer, 0, out=rf"proved: no plan is better\nreward .*\nbound .*\nchecked .* of the kind {kind}\n",
                               error=r"\A\Z")
                    answer = orasp("check", "lattice", plan, certificate, *changes, "--json")
                    self.check(answer, 0)
                    verdict = json.loads(answer.out)
                    self.assertEqual(set(verdict), {"proved", "claim", "kind", "reward", "bound", "tolerance", "inequalities"})
                    self.assertEqual((verdict["proved"], verdict["claim"], verdict["kind"]), (True, "optimal", kind))
                    self.assertAlmostEqual(verdict["reward"], verdict["bound"], places=9)

    def test_attempts_made_again_until_they_succeed_are_proved_by_policy_and_by_plan(self):
        problem = json.loads(assembly(["1-2", "2-3", "3-4"], objective={"type": "piece_cost", "operation": 1}))
        for connection, success in zip(problem["connections"], (1, 0.5, 0.25), strict=True):
            connection["success"] = success
        problem = self.file("p.json", json.dumps(problem))
        policy, certificate = self.certified(problem)
        # One attempt and two; the last step costs nothing, however often it is tried.
        self.check(orasp("check", problem, policy, certificate), 0, out=r"proved: no plan is better\nreward +-3\n")
        self.check(orasp("check", problem, "-", certificate, stdin='["2-3", "1-2", "3-4"]'), 0, out=r"reward +-3\n")
        self.check(orasp("check", problem, "-", certificate, stdin='["3-4", "2-3", "1-2"]'), 10, out="the plan earns -6, ")
        half = json.loads(self.read(policy))
        del half["states"][1]
        self.check(orasp("check", problem, "-", certificate, stdin=json.dumps(half)), 30,
                   error="standard input: the policy says nothing of the state after step 1")
        problem = json.loads(self.read(problem))
        problem["connections"][1]["on_failure"] = {"abort": -1}
        self.check(orasp("solve", "-", "--certificate", "x.json", stdin=json.dumps(problem)), 30,
                   error="try until they succeed; here an attempt that fails may do more")

    def test_pieces_prove_what_their_sizes_do_not(self):
        # By sizes four parts come apart as two and two; with one subassembly at a time three are left together.
        problem = self.file("p.json", assembly(["1-2", "2-3", "3-4", "4-5"], limits={"max_subassemblies": 1},
                                               objective={"type": "piece_cost", "pieces": {"3": 1}}))
        for direction in ["disassembly", "assembly"]:
            with self.subTest(direction=direction):
                plan, certificate = self.certified(problem, "--direction", direction)
                answer = orasp("check", problem, plan, certificate, "--direction", direction)
                self.check(answer, 0, out=r"proved: no plan is better\nreward .*\nbound .*\nchecked .* of the kind pieces\n")
                document = json.loads(self.read(certificate))
                self.assertTrue(document["pieces"])
                for parts, allowed, value in document["pieces"]:
                    self.assertRegex(parts, r"\A[0-9a-f][01]\Z")
                    self.assertGreaterEqual(allowed, 1)
                for change, sentence in [
                    ([["f1", 1, -9]], r"pieces\[0\]: -9 is less than a cut into \d and \d parts, .* is worth"),
                    ([["f1", 7, 0]], r"pieces\[0\]: 7 is not a number of subassemblies that it can make use of"),
                    ([["10", 1, 0]], r"pieces\[0\]: two parts or more of one piece of the product are wanted"),
                    ([], r"it proves that no plan earns more than"),
                ]:
                    false = json.dumps(dict(document, pieces=change))
                    self.check(orasp("check", problem, plan, "-", "--direction", direction, stdin=false), 10, out=sentence)
                for change, sentence in [
                    ([["g0", 1, 0]], r'pieces\[0\]\[0\]: "g0" is no set of 5 parts'),
                    ([["f1", 0.5, 0]], r"pieces\[0\]\[1\]: expected a number of subassemblies"),
                    ([["f1", 1]], r"pieces\[0\]: expected a set of parts, a number of subassemblies and a value, found 2 values"),
                ]:
                    false = json.dumps(dict(document, pieces=change))
                    answer = orasp("check", problem, plan, "-", "--direction", direction, stdin=false)
                    self.check_sentence(answer)
                    self.assertRegex(answer.error, sentence)

    def test_that_there_is_no_plan_is_proved(self):
        problem = self.file("p.json", CYCLE)
        certificate = str(self.folder / "certificate.json")
        self.check(orasp("solve", problem, "--certificate", certificate), 10)
        self.assertEqual(json.loads(self.read(certificate))["kind"], "waits")
        self.check(orasp("check", problem, "none", certificate), 0, out=r"proved: there is no plan\nchecked  2 inequalities")
        answer = orasp("check", problem, "none", certificate, "--json")
        verdict = json.loads(answer.out)
        self.assertEqual((verdict["claim"], verdict["reward"], verdict["bound"]), ("infeasible", None, None))
        plan, certificate = self.certified("4brick")
        self.check(orasp("check", "4brick", "none", certificate), 10, out=r"not proved: .*does not say that there is none")

    def read(self, file):
        with open(file, encoding="utf-8") as stream:
            return stream.read()

    def test_a_worse_plan_an_illegal_one_and_a_false_bound_are_not_proved(self):
        plan, certificate = self.certified("lattice")
        order = json.loads(self.read(plan))["disassembly"]
        worse = json.loads(orasp("solve", "lattice", "--method", "random", "--json").out)["disassembly"]
        self.check(orasp("check", "lattice", "-", certificate, stdin=json.dumps(worse)), 10,
                   out=r"not proved: the plan earns .*, and the certificate bounds plans by 0\.0735")
        self.check(orasp("check", "lattice", "-", certificate, stdin=json.dumps(order[1:])), 10,
                   out=r"not proved: the plan is not legal: ")
        document = json.loads(self.read(certificate))
        false = dict(document, bound=document["bound"] - 1e-12)
        answer = orasp("check", "lattice", plan, "-", stdin=json.dumps(false))
        self.check(answer, 10, out=r"not proved: the certificate does not hold: it proves that no plan earns more than")
        false = dict(document, sizes=[value - 0.01 if n == 5 else value for n, value in enumerate(document["sizes"])])
        answer = orasp("check", "lattice", plan, "-", "--json", stdin=json.dumps(false))
        self.check(answer, 10)
        self.assertRegex(json.loads(answer.out)["fault"], r"sizes\[5\]: .* is less than a cut into \d and \d parts is worth")

    def test_a_price_too_low_is_not_proved(self):
        plan, certificate = self.certified("4brick", "--objective", "indexed")
        document = json.loads(self.read(certificate))
        self.assertEqual(document["kind"], "places")
        document["places"][0] -= 0.5
        self.check(orasp("check", "4brick", plan, "-", "--objective", "indexed", stdin=json.dumps(document)), 10,
                   out=r"places\[0\]: .* is less than what \".*\" earns there beyond its own, ")

    def test_a_lost_state_is_not_proved(self):
        changes = ["--objective", "indexed", "--max-subassemblies", "1"]
        plan, certificate = self.certified("4brick", *changes)
        document = json.loads(self.read(certificate))
        document["layers"][1].pop()
        self.check(orasp("check", "4brick", plan, "-", *changes, stdin=json.dumps(document)), 10,
                   out=r"layers\[1\]: a step out of layer 0, at \".*\", leads to a state that is not listed")

    @smoke
    def test_wrong_files_are_refused_in_one_sentence(self):
        plan, certificate = self.certified("4brick")
        text = self.read(certificate)
        document = json.loads(text)
        for content, sentence in [
            (text[:len(text) // 2], r"line \d+, column \d+"),
            ("[1]", r"expected an object, found an array"),
            (json.dumps(dict(document, format="orasp-plan/1")), r'format: "orasp-plan/1" is not the format of a certificate'),
            (json.dumps(dict(document, problem_digest="0" * 64)), r"problem_digest: .*another problem"),
            (json.dumps(dict(document, kind="magic")), r'kind: "magic" is none; kinds are "sizes"'),
            (json.dumps(dict(document, kind="states")), r'the key "layers" is missing'),
            (json.dumps(dict(document, bund=1)), r'unknown key "bund"'),
            (json.dumps(dict(document, sizes=["1"])), r'sizes\[0\]: expected a number or null, found the string "1"'),
            (json.dumps(dict(document, kind="states", layers=[[["g", 0]]])), r'layers\[0\]\[0\]\[0\]: "g" is no set of 3 connections'),
            (json.dumps(dict(document, kind="waits", end="first removed", waiting=["1-9"])), r'waiting\[0\]: no connection "1-9"'),
        ]:
            with self.subTest(sentence=sentence):
                answer = orasp("check", "4brick", plan, self.file("wrong.json", content))
                self.check_sentence(answer)
                self.assertRegex(answer.error, sentence)
        self.check_sentence(orasp("check", "4brick", "-", "-"))
        # The objective and the limits are part of the problem.
        self.check_sentence(orasp("check", "4brick", plan, certificate, "--objective", "time", "--quiet"))

    def test_what_has_no_certificate_is_said(self):
        goal = assembly(["1-2", "2-3"], goal={"removed": ["1-2"]})
        certificate = self.folder / "certificate.json"
        answer = orasp("solve", "-", "--certificate", str(certificate), stdin=goal)
        self.check_sentence(answer)
        self.assertRegex(answer.error, r"--certificate: certificates are for plans .*; the problem has a goal")
        # A plan that is not the best is printed, and has none.
        answer = orasp("solve", "lattice", "--method", "random", "--certificate", str(certificate))
        self.check(answer, 20, out=r"status   feasible", error=r"certificate.json is not written: ")
        self.assertFalse(certificate.exists())
        self.check_sentence(orasp("solve", "lattice", "--method", "mip", "--write-model", "m.lp", "--certificate", str(certificate)))


if __name__ == "__main__":
    unittest.main()
