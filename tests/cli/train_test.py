#!/usr/bin/env python3
"""Tests `orasp train` and the method dqn.

    tests/cli/train_test.py PROGRAM [unittest's arguments]
"""
import json
import signal
import subprocess
import unittest
from pathlib import Path

from program import CHAIN, PROGRAM, ROOT, Case, orasp, smoke


class Train(Case):
    """Learning; where this build has no libtorch only what needs none."""

    @classmethod
    def setUpClass(cls):
        answer = orasp("train", "4brick", "--episodes", "1", "--quiet")
        cls.learns = "libtorch" not in answer.error
        if not cls.learns:
            assert answer.code == 30, answer.error

    def needs_libtorch(self):
        if not self.learns:
            self.skipTest("built without libtorch")

    def trained(self, problem="hubble-upc", *arguments):
        policy = self.folder / "policy.pt"
        answer = orasp("train", problem, "-o", policy, *arguments)
        self.assertIn(answer.code, (0, 20), answer.error)
        return policy

    @smoke
    def test_a_policy_is_written_and_plans_as_well_as_it_says(self):
        self.needs_libtorch()
        policy = self.folder / "policy.pt"
        answer = orasp("train", "2x3", "-o", policy, "--json", "--log", self.folder / "log")
        self.assertEqual(answer.code, 0, answer.error)
        outcome = json.loads(answer.out)
        self.assertEqual(outcome["status"], "optimal")
        self.assertAlmostEqual(outcome["policy_reward"], 0.3636)
        self.assertAlmostEqual(outcome["bound"], 0.3636)
        self.assertEqual(len(outcome["sequence"]), 7)
        self.assertRegex(answer.error, r"episodes .* updates +greedy .* best .* bound")
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["log", "policy.pt"])

        plan = orasp("solve", "2x3", "--method", "dqn", "--policy", policy, "--json")
        self.assertEqual(plan.code, 0, plan.error)
        self.assertEqual(json.loads(plan.out)["reward"], outcome["policy_reward"])
        self.assertEqual(orasp("evaluate", "2x3", "-", stdin=plan.out).code, 0)

        records = [json.loads(line) for line in (self.folder / "log").read_text().splitlines()]
        self.assertGreaterEqual(len(records), 1)
        for record in records:
            self.assertLessEqual(record["best"], record["bound"] + 1e-9)
        self.assertEqual(records[-1]["episodes"], outcome["episodes"])

    def test_goals_part_steps_and_costs_between_steps_are_learned(self):
        self.needs_libtorch()
        policy = self.folder / "policy.pt"
        for name, best in (("01_two_drivers", -2), ("07_worth_it", 4), ("12_heavy", -70)):
            with self.subTest(name):
                problem = ROOT / f"examples/modelling/{name}.json"
                answer = orasp("train", problem, "-o", policy, "--episodes", "200", "--json", "--quiet")
                self.assertIn(answer.code, (0, 20), answer.error)
                trained = json.loads(answer.out)
                self.assertAlmostEqual(trained["reward"], best)
                plan = orasp("solve", problem, "--method", "dqn", "--policy", policy, "--json", "--quiet")
                self.assertEqual(json.loads(plan.out)["reward"], trained["policy_reward"])
                self.assertEqual(orasp("evaluate", problem, "-", stdin=plan.out).code, 0)
        answer = orasp("train", problem, "--resume", policy, "--episodes", "300", "--json", "--quiet")
        self.assertGreaterEqual(json.loads(answer.out)["policy_reward"], trained["policy_reward"])
        self.check(orasp("train", problem, "--no-known-reward"), 30, error="known rewards cannot be left out here")

    def test_a_policy_beside_random_sequences(self):
        self.needs_libtorch()
        policy = self.trained()
        sample = json.loads(orasp("sample", "hubble-upc", "--policy", policy, "--json").out)
        self.assertEqual(sample["n"], 100)
        self.assertEqual(sample["best_status"], "optimal")
        self.assertAlmostEqual(sample["best_reward"], -0.9902)
        self.assertAlmostEqual(sample["bound"], -0.9902)
        self.assertGreater(sample["policy_reward"], sample["max"] + 0.2)
        text = orasp("sample", "hubble-upc", "--policy", policy).out
        self.assertIn("more than 100 of 100 random sequences", text)

    def test_the_same_seed_gives_the_same_policy(self):
        self.needs_libtorch()
        outcomes = []
        for seed in ("7", "7", "8"):
            out = orasp("train", "lattice", "--episodes", "200", "--to-the-end", "--seed", seed, "--json", "--log",
                        self.folder / "log").out
            outcome = json.loads(out)
            outcome.pop("seconds")
            losses = [json.loads(line)["loss"] for line in (self.folder / "log").read_text().splitlines()]
            outcomes.append((outcome, losses))
        self.assertEqual(outcomes[0], outcomes[1])
        self.assertNotEqual(outcomes[0], outcomes[2])

    def test_it_goes_on_where_it_stopped(self):
        self.needs_libtorch()
        policy = self.trained("lattice", "--episodes", "128", "--to-the-end", "--log", self.folder / "log")
        before = len((self.folder / "log").read_text().splitlines())
        answer = orasp("train", "lattice", "--resume", policy, "-o", policy, "--episodes", "256", "--to-the-end",
                       "--json", "--log", self.folder / "log")
        self.assertEqual(answer.code, 0, answer.error)
        self.assertEqual(json.loads(answer.out)["episodes"], 256)
        lines = [json.loads(line)["episodes"] for line in (self.folder / "log").read_text().splitlines()]
        self.assertGreater(len(lines), before)
        self.assertEqual(lines, sorted(lines))

    def test_limits_and_interrupts_keep_the_best(self):
        self.needs_libtorch()
        policy = self.trained("iss", "--time-limit", "10", "--to-the-end", "--quiet")
        self.assertEqual(orasp("solve", "iss", "--method", "dqn", "--policy", policy).code, 0)
        policy.unlink()
        process = self.not_beyond(subprocess.Popen([PROGRAM, "train", "iss", "--to-the-end", "-o", policy],
                                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)))
        process.stderr.readline()  # the first round is over
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 20)
        self.assertIn("interrupted", out.decode())
        self.assertEqual(orasp("solve", "iss", "--method", "dqn", "--policy", policy).code, 0)

    def test_solve_trains_where_no_policy_is_given(self):
        self.needs_libtorch()
        answer = orasp("solve", "hubble-upc", "--method", "dqn", "--json", "--time-limit", "60")
        self.assertIn(answer.code, (0, 20), answer.error)
        self.assertGreater(json.loads(answer.out)["reward"], -1.01)

    def test_no_plan_is_said_without_training(self):
        for command in (["train", "4brick"], ["solve", "4brick", "--method", "dqn"]):
            answer = orasp(*command, "--max-moved-parts", "0")
            self.assertEqual(answer.code, 10, answer.error)
            self.assertIn("infeasible", answer.out)

    def test_foreign_damaged_and_missing_policies_are_refused_in_a_sentence(self):
        self.needs_libtorch()
        policy = self.trained()
        good = policy.read_bytes()
        bad = self.folder / "bad.pt"
        for content, words in [(good[:1000], "damaged or cut off"), (good[:-1], "damaged or cut off"),
                               (b"", "no policy"), (b"PK\x03\x04", "no policy"), (CHAIN.encode(), "no policy"),
                               (good.replace(b"steps", b"stepz"), "damaged")]:
            bad.write_bytes(content)
            for command in (["solve", "hubble-upc", "--method", "dqn", "--policy", bad],
                            ["train", "hubble-upc", "--resume", bad], ["sample", "hubble-upc", "--policy", bad]):
                answer = orasp(*command)
                self.assertEqual(answer.code, 30, answer.error)
                self.assertEqual(answer.error.count("\n"), 1, answer.error)
                self.assertIn(words, answer.error)
                self.assertIn("bad.pt", answer.error)
            self.assertEqual(bad.read_bytes(), content)
        for command in (["solve", "iss-upc", "--method", "dqn", "--policy", policy],
                        ["solve", "hubble-upc", "--objective", "custom", "--method", "dqn", "--policy", policy],
                        ["train", "iss-upc", "--resume", policy]):
            answer = orasp(*command)
            self.assertEqual(answer.code, 30)
            self.assertIn("was trained on another problem", answer.error)
        self.assertEqual(orasp("solve", "hubble", "--method", "dqn", "--policy", "absent.pt").code, 30)
        answer = orasp("solve", "hubble-upc", "--method", "greedy", "--policy", policy)
        self.assertEqual(answer.code, 30)
        self.assertIn("--policy belongs to the methods auto, beam and dqn", answer.error)

    def test_a_network_over_pieces_needs_no_libtorch(self):
        policy = self.folder / "policy.pt"
        log = self.folder / "log"
        command = ["train", "hubble-upc", "--inputs", "pieces", "-o", policy, "--log", log, "--to-the-end", "--quiet"]
        answer = orasp(*command, "--episodes", "160", "--json")
        self.assertEqual(answer.code, 0, answer.error)
        outcome = json.loads(answer.out)
        records = [json.loads(line) for line in log.read_text().splitlines()]
        self.assertEqual(outcome["final_reward"], records[-1]["greedy"])
        self.assertEqual(outcome["policy_reward"], records[-1]["best_greedy"])
        self.assertGreaterEqual(outcome["policy_reward"], outcome["final_reward"])
        plan = orasp("solve", "hubble-upc", "--method", "dqn", "--policy", policy, "--json")
        self.assertEqual(json.loads(plan.out)["reward"], outcome["policy_reward"])
        self.assertEqual(orasp("sample", "hubble-upc", "--policy", policy).code, 0)

        answer = orasp("train", "hubble-upc", "--resume", policy, "--episodes", "168", "--to-the-end", "--quiet")
        self.assertEqual(answer.code, 0, answer.error)
        self.assertRegex(answer.out, r"\nepisodes +168\n")
        self.assertRegex(answer.out, r"\npolicy +-[0-9.]+ \(the best of the training, kept\)\n"
                                     r"final +-[0-9.]+ \(the network at the end\)\n")
        for arguments, words in [(["--inputs", "parts"], "auto, connections, pieces"),
                                 (["--inputs", "pieces", "--device", "cuda"], "is trained on the processor")]:
            answer = orasp("train", "4brick", *arguments)
            self.assertEqual(answer.code, 30, answer.error)
            self.assertIn(words, answer.error)
        answer = orasp("solve", "iss-upc", "--method", "dqn", "--policy", policy)
        self.assertEqual(answer.code, 30)
        self.assertIn("was trained on another problem", answer.error)

    def test_one_policy_for_many_products(self):
        policy = self.folder / "general.pt"
        answer = orasp("train", "--problems", "tree:8:1", "tree:9:2", "tree:10:3", "-o", policy, "--json", "--quiet")
        self.assertEqual(answer.code, 0, answer.error)
        learned = json.loads(answer.out)
        self.assertEqual((learned["problems"], learned["held_out_problems"]), (2, 1))
        rewards = {}
        for method in ("dqn", "beam", "auto"):
            answer = orasp("solve", "tree:30:5", "--method", method, "--policy", policy, "--json", "--quiet")
            self.assertEqual(answer.code, 0, answer.error)
            rewards[method] = json.loads(answer.out)["reward"]
        self.assertEqual(rewards["beam"], rewards["auto"])
        self.assertLessEqual(rewards["dqn"], rewards["beam"])
        for arguments, words in [(["--objective", "completion"], "was trained for the objective"),
                                 (["--direction", "assembly"], "was trained for disassembly, not for assembly"),
                                 (["--max-moved-parts", "3"], "was trained on problems without max_moved_parts")]:
            answer = orasp("solve", "tree:30:5", "--method", "beam", "--policy", policy, *arguments)
            self.assertEqual(answer.code, 30)
            self.assertIn(words, answer.error)

    def test_a_policy_for_many_products_learns_on(self):
        policy = self.folder / "general.pt"
        again = self.folder / "again.pt"
        log = self.folder / "log.jsonl"
        for file, arguments in [(policy, []), (again, ["--resume", policy])]:
            answer = orasp("train", "--problems", "tree:8:1", "tree:9:2", "tree:10:3", "-o", file, "--log", log, "--quiet", *arguments)
            self.assertEqual(answer.code, 0, answer.error)
        records = [json.loads(line) for line in log.read_text().splitlines()]
        begins = [record for record in records if record["epoch"] == 0 and not record["own"]]
        self.assertEqual(len(begins), 2, "the log goes on")
        self.assertLess(begins[1]["held_out_loss"], begins[0]["held_out_loss"])
        self.assertTrue(any(record["own"] for record in records))
        for arguments, words in [(["--objective", "completion"], "one policy is for one objective"),
                                 (["--direction", "assembly"], "one policy is for one direction")]:
            answer = orasp("train", "--problems", "tree:8:1", "tree:9:2", "--resume", policy, *arguments)
            self.assertEqual(answer.code, 30)
            self.assertIn(words, answer.error)
        other = self.folder / "other.pt"
        other.write_text("{}")
        answer = orasp("train", "--problems", "tree:8:1", "tree:9:2", "--resume", other)
        self.assertEqual(answer.code, 30)
        self.assertIn("other.pt: this is no policy of `orasp train --problems`", answer.error)

    def test_options_that_make_no_sense(self):
        for arguments, words in [(["--discount", "1.5"], "from 0 to 1"), (["--epsilon-end", "-1"], "from 0 to 1"),
                                 (["--imitation", "nan"], "from 0 to 1"), (["--hidden", "8,,8"], "whole number"),
                                 (["--hidden", "0"], "whole number"), (["--learning-rate", "0"], "above 0"),
                                 (["--environments", "0"], "whole number"), (["--episodes", "0"], "whole number")]:
            answer = orasp("train", "4brick", *arguments)
            self.assertEqual(answer.code, 30, arguments)
            self.assertIn(words, answer.error)
            self.assertIn(arguments[0], answer.error)
        if self.learns:
            answer = orasp("train", "4brick", "--device", "tpu")
            self.assertEqual(answer.code, 30)
            self.assertIn("none of auto, cpu, cuda", answer.error)
        answer = orasp("train", "4brick", "--log", self.folder / "no" / "log")
        self.assertEqual(answer.code, 30)
        self.assertIn("cannot write", answer.error)

    def test_a_folder_that_is_not_there_is_said_before_training(self):
        answer = orasp("train", "iss", "--to-the-end", "-o", self.folder / "no" / "policy.pt", "--time-limit", "60")
        self.assertEqual(answer.code, 30)
        self.assertIn("no/policy.pt", answer.error)

    def test_without_its_module_the_program_says_how_to_get_it_and_does_all_else(self):
        alone = self.folder / "bin" / "orasp"
        alone.parent.mkdir()
        alone.write_bytes(Path(PROGRAM).read_bytes())
        alone.chmod(0o755)

        def run(*arguments):
            return subprocess.run([alone, *arguments], capture_output=True, text=True, timeout=60)
        for command in (["train", "hubble"], ["solve", "hubble", "--method", "dqn"]):
            answer = run(*command)
            if "libtorch" not in answer.stderr and answer.returncode != 30:
                self.skipTest("a module is installed on this machine")
            self.assertEqual(answer.returncode, 30)
            self.assertIn("libtorch-dev and libopenblas0-pthread", answer.stderr)
            self.assertEqual(answer.stderr.count("\n"), 1)
        self.assertEqual(run("solve", "hubble").returncode, 0)
        if self.learns:  # planning with a policy needs no libtorch
            policy = self.trained()
            self.assertEqual(run("solve", "hubble-upc", "--method", "dqn", "--policy", policy).returncode, 0)

    def test_the_program_is_not_linked_to_libtorch(self):
        libraries = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout
        self.assertNotIn("torch", libraries)


if __name__ == "__main__":
    unittest.main()
