"""H as arrays."""
import gc
import unittest

import numpy as np
import orasp
from program import random_problem


try:
    import networkx
except ImportError:
    networkx = None
try:
    import scipy.sparse.csgraph as csgraph
except ImportError:
    csgraph = None


def value_iteration(h):
    """Backward induction with NumPy alone, layer by layer."""
    values = np.full(h.num_states, -np.inf)
    if h.goal is not None:
        values[h.goal] = 0
    offsets = h.row_offsets.astype(np.int64)
    for layer in range(len(h.layer_offsets) - 2, -1, -1):
        first, last = h.layer_offsets[layer], h.layer_offsets[layer + 1]
        rows = offsets[first : last + 1]
        with_actions = np.flatnonzero(np.diff(rows))
        if len(with_actions) == 0:
            continue
        actions = slice(rows[0], rows[-1])
        worth = h.rewards[actions] + values[h.successors[actions]]
        values[first + with_actions] = np.maximum.reduceat(worth, rows[:-1][with_actions] - rows[0])
    return values


class Arrays(unittest.TestCase):
    def test_show_the_memory_of_h(self):
        h = orasp.graph("hubble")
        for name in ("states", "row_offsets", "successors", "connections", "reward_numbers", "reward_table"):
            with self.subTest(name):
                one, two = getattr(h, name), getattr(h, name)
                self.assertFalse(one.flags.owndata)
                self.assertFalse(one.flags.writeable)
                self.assertEqual(one.__array_interface__["data"], two.__array_interface__["data"])
                with self.assertRaises(ValueError):
                    one[0] = 0
        self.assertEqual(h.states.shape, (h.num_states, 1))
        self.assertEqual(h.row_offsets.shape, (h.num_states + 1,))
        self.assertEqual((h.row_offsets[0], h.row_offsets[-1]), (0, h.num_actions))
        self.assertEqual(h.successors.shape, h.connections.shape)
        np.testing.assert_array_equal(h.rewards, h.reward_table[h.reward_numbers])

    def test_arrays_keep_h_alive(self):
        h = orasp.graph("hubble")
        successors = h.successors
        total = int(successors.sum())
        del h
        gc.collect()
        orasp.graph("lattice")
        self.assertEqual(int(successors.sum()), total)
        values = orasp.solve("hubble", "bellman-ford").values
        gc.collect()
        self.assertEqual(values[0], 0)

    def test_states_and_actions_are_what_they_say(self):
        for seed in range(60):
            h = orasp.graph(random_problem(seed))
            with self.subTest(seed=seed):
                sources = h.sources()
                self.assertTrue((h.successors > sources).all())
                taken = h.states[sources, 0] ^ h.states[h.successors, 0]
                np.testing.assert_array_equal(taken, np.uint64(1) << h.connections.astype(np.uint64))
                self.assertEqual(len(h.open_connections(0)), h.problem.num_connections)

    def test_wide_numbers(self):
        """More than 64 connections take two words, and a function has more rewards than a byte numbers."""
        problem = orasp.load("chain:70").copy()
        ids = problem.connection_ids
        for before, after in zip(ids, ids[1:]):
            problem.require(after, after=[before])
        h = orasp.graph(problem)
        self.assertEqual(h.states.shape, (h.num_states, 2))
        self.assertEqual(h.open_connections(0), ids)
        varied = orasp.Reward(lambda s: np.sin(7.1 * s.index + 3.3 * s.before + 1.7 * s.moved_parts + s.subassemblies), vectorized=True)
        h = orasp.graph("hubble", objective=varied)
        self.assertEqual(h.reward_numbers.dtype, np.uint16)
        np.testing.assert_array_equal(h.rewards, h.reward_table[h.reward_numbers])


class OwnAlgorithms(unittest.TestCase):
    def test_value_iteration_in_numpy(self):
        for name in ("hubble", "hubble-free", "lattice"):
            h = orasp.graph(name)
            with self.subTest(name):
                np.testing.assert_array_equal(value_iteration(h), h.values())
                self.assertAlmostEqual(h.values()[0], orasp.solve(name).reward, places=9)
        for seed in range(100):
            h = orasp.graph(random_problem(seed))
            result = orasp.solve(random_problem(seed), "value-iteration")
            values = value_iteration(h)
            self.assertAlmostEqual(values[0], result.reward, places=9)
            if h.goal is not None and result.has_plan:
                plan = [h.problem.connection_ids[c] for c in h.best_sequence(values)]
                self.assertAlmostEqual(orasp.evaluate(random_problem(seed), plan).reward, result.reward, places=9)

    @unittest.skipIf(networkx is None, "NetworkX is not there")
    def test_networkx(self):
        h = orasp.graph("hubble")
        length = networkx.bellman_ford_path_length(h.to_networkx(), 0, h.goal, weight="cost")
        self.assertAlmostEqual(-length, orasp.solve("hubble").reward, places=9)
        np.testing.assert_allclose(h.values(from_start=True)[h.goal], -length)

    @unittest.skipIf(csgraph is None, "SciPy is not there")
    def test_scipy(self):
        h = orasp.graph("2x3")
        matrix = h.to_scipy()
        self.assertEqual((matrix.shape, matrix.nnz), ((h.num_states,) * 2, h.num_actions))
        self.assertTrue(np.shares_memory(matrix.indices, h.successors))
        self.assertTrue(np.shares_memory(matrix.data, h.rewards))
        costs = matrix.copy()
        costs.data = 10 - costs.data  # every path has as many steps
        found = csgraph.dijkstra(costs, indices=0)[h.goal]
        steps = h.problem.num_connections
        self.assertAlmostEqual(10 * steps - found, orasp.solve("2x3").reward, places=9)

    @unittest.skipIf(csgraph is None, "SciPy is not there")
    def test_one_action_between_two_states(self):
        """Costs between steps: a move may leave along several directions to the same state."""
        problem = orasp.load("lattice").copy()
        problem["blocking"] = {"directions": ["+x", "-x"], "blocked": []}
        problem.objective = {"type": "changeover", "attribute": "direction", "cost": 1}
        h = orasp.graph(problem, time_limit=60)
        matrix = h.to_scipy()
        pairs = {}
        for source, target, reward in zip(h.sources().tolist(), h.successors.tolist(), h.rewards.tolist()):
            pairs[source, target] = max(reward, pairs.get((source, target), -np.inf))
        self.assertEqual(matrix.nnz, len(pairs))
        self.assertTrue(all(matrix[pair] == reward for pair, reward in list(pairs.items())[:500]))


class Cost(unittest.TestCase):
    def test_arrays_are_no_copies(self):
        """What `orasp graph` holds is what the arrays show: see benchmarks/python_costs.py for the time."""
        h = orasp.graph("hubble-free")
        for array in (h.states, h.row_offsets, h.successors, h.connections, h.reward_numbers, h.reward_table):
            self.assertFalse(array.flags.owndata)

    def test_limits(self):
        h = orasp.graph("hubble-free", time_limit=1e-4)
        self.assertEqual(h.stopped, "time limit")
        self.assertIsNone(h.goal)
        with self.assertRaisesRegex(orasp.InputError, "several"):
            orasp.graph("fleet-hubble")


if __name__ == "__main__":
    unittest.main()
