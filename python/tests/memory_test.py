"""Problems, plans and graphs that are dropped leave memory as it was."""
import gc
import unittest

import orasp
from program import random_problem


def held():
    """The bytes of memory that this process holds."""
    gc.collect()
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096


def go_round(seed):
    problem = orasp.load(random_problem(seed % 50))
    orasp.solve(problem).to_dict()
    orasp.solve(problem, "greedy", objective=lambda step: -float(step.before)).to_dict()
    orasp.graph(problem, objective=orasp.Reward(lambda s: -s.before, vectorized=True)).values()


class Memory(unittest.TestCase):
    def test_a_thousand_problems(self):
        for seed in range(200):
            go_round(seed)
        before = held()
        for seed in range(1000):
            go_round(seed)
        grown = held() - before
        print(f"after 1,000 problems: {grown / 2**20:.2f} MiB more")
        self.assertLess(grown, 4 << 20)

    def test_a_thousand_faults(self):
        def fault(seed):
            with self.assertRaises(orasp.InputError):
                orasp.load({"format": "orasp-problem/1", "parts": [], "connections": [{"parts": ["a", str(seed)]}]})
            with self.assertRaises(ZeroDivisionError):
                orasp.solve("2x3", "greedy", objective=lambda step: 1 / 0)

        for seed in range(100):
            fault(seed)
        before = held()
        for seed in range(1000):
            fault(seed)
        self.assertLess(held() - before, 4 << 20)


if __name__ == "__main__":
    unittest.main()
