"""Training and policies; skipped where libtorch is missing."""
import json
import pickle
import tempfile
import unittest
from pathlib import Path

import numpy as np
import orasp
from program import program_answer_of_training, run, sentence


@unittest.skipUnless(orasp.learning_available(), "libtorch is not there")
class Training(unittest.TestCase):
    def test_trains_and_plans(self):
        rounds = []
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "policy.pt"
            training = orasp.train("4piece", episodes=60, hidden=[16, 16], seed=3, log=rounds.append, checkpoint=file)
            policy = training.policy
            self.assertEqual(orasp.Policy.read(file), policy)
            self.assertEqual(rounds[-1]["episodes"], training.record["episodes"])
            self.assertEqual([weights.shape for weights, _ in policy.layers], [(4, 16), (16, 16), (16, 4)])
            self.assertEqual(policy.layers[0][0].dtype, np.float32)
            planned = orasp.solve("4piece", "dqn", policy=file)
            self.assertEqual(planned.connections, orasp.solve("4piece", "dqn", policy=policy).connections)
            self.assertAlmostEqual(planned.reward, policy.reward)
            self.assertEqual(policy.follow("4piece").connections, planned.connections)
            self.assertEqual(pickle.loads(pickle.dumps(policy)), policy)
            said = program_answer_of_training("4piece", "--episodes", "60", "--hidden", "16,16", "--seed", "3")
            self.assertEqual(said["policy_reward"], policy.reward)
            self.assertEqual(said["sequence"], training.result.connections)
            code, _, error = run("solve", "lattice", "--method", "dqn", "--policy", str(file))
            self.assertEqual(code, 30)
            with self.assertRaises(orasp.InputError) as raised:
                orasp.solve("lattice", "dqn", policy=file)
            self.assertEqual(str(raised.exception), sentence(error))

    def test_what_log_raises_comes_out(self):
        with self.assertRaises(ZeroDivisionError):
            orasp.train("4piece", episodes=100, log=lambda record: 1 / 0)

    def test_faults(self):
        with self.assertRaisesRegex(orasp.InputError, "train has no option episode"):
            orasp.train("4piece", episode=3)
        with self.assertRaisesRegex(orasp.InputError, "policy belongs to the methods auto, beam and dqn, not to greedy"):
            orasp.solve("4piece", "greedy", policy="policy.pt")
        with self.assertRaisesRegex(orasp.InputError, "cannot read"):
            orasp.solve("4piece", "dqn", policy="policy.pt")


class General(unittest.TestCase):
    """Policies for many products, which need no libtorch."""

    def test_plans_for_problems_of_its_kind(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "general.pt"
            code, _, error = run("train", "--problems", "tree:8:1", "tree:9:2", "tree:10:3", "-o", str(file), "--quiet")
            self.assertEqual(code, 0, error)
            policy = orasp.GeneralPolicy.read(file)
            self.assertEqual(policy.direction, "disassembly")
            self.assertEqual(policy.keys, frozenset())
            self.assertIn("cubesat", policy.objective)
            self.assertEqual(pickle.loads(pickle.dumps(policy)), policy)
            planned = orasp.solve("tree:30:5", "dqn", policy=file)
            self.assertEqual(planned.connections, orasp.solve("tree:30:5", "dqn", policy=policy).connections)
            _, out, _ = run("solve", "tree:30:5", "--method", "dqn", "--policy", str(file), "--json", "--quiet")
            self.assertEqual(json.loads(out)["disassembly"], planned.connections)
            proved = orasp.solve("tree:30:5", "beam", policy=policy)
            self.assertEqual(proved.status, "optimal")
            self.assertGreaterEqual(proved.reward, planned.reward)
            with self.assertRaisesRegex(orasp.InputError, "was trained for the objective"):
                orasp.solve("tree:30:5", "dqn", policy=file, objective="completion")
            file.write_bytes(policy.to_bytes()[:-1])
            with self.assertRaisesRegex(orasp.InputError, "general.pt"):
                orasp.solve("tree:30:5", "dqn", policy=file)


class Without(unittest.TestCase):
    def test_says_how_to_get_it(self):
        if orasp.learning_available():
            self.skipTest("libtorch is there")
        with self.assertRaisesRegex(orasp.InputError, "libtorch-dev"):
            orasp.train("4piece", episodes=10)


if __name__ == "__main__":
    unittest.main()
