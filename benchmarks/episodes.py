#!/usr/bin/env python3
"""Steps a second of the environments of the Python package, on one core.

    ./run python benchmarks/episodes.py [PROBLEM...]

For each problem: `VectorEnvironment` with 1,024 episodes, masks and observations included, with actions that were drawn
beforehand (states are then remembered, as far as memory allows), the same with `sample_actions` in the loop, the first round,
in which no state is known, and `Environment`, one episode. The best of five runs counts, in seconds of the processor.
"""

from __future__ import annotations

import sys
import time
from typing import Callable

import numpy as np

import orasp

EPISODES = 1024


def steps_a_second(steps: int, run: Callable[[], None], runs: int = 5) -> float:
    """The most of some runs."""
    best = float("inf")
    for _ in range(runs):
        begin = time.process_time()
        run()
        best = min(best, time.process_time() - begin)
    return steps / best


def measure(problem: str) -> list[float]:
    """The four figures of a problem."""
    rounds = max(1, 200 if len(orasp.Environment(problem).action_names) < 64 else 64)
    environment = orasp.VectorEnvironment(problem, EPISODES)
    actions = np.empty((rounds, EPISODES), np.int64)

    def first() -> None:
        environment.reset(seed=1)
        for row in actions:
            environment.sample_actions(row)
            environment.step(row)

    def drawn_beforehand() -> None:
        environment.reset()
        for row in actions:
            environment.step(row)

    drawn = np.empty(EPISODES, np.int64)

    def drawn_now() -> None:
        environment.reset(seed=1)
        for _ in range(rounds):
            environment.step(environment.sample_actions(drawn))

    steps = rounds * EPISODES
    new = steps_a_second(steps, first, 1)
    figures = [steps_a_second(steps, drawn_beforehand), steps_a_second(steps, drawn_now), new]

    one = orasp.Environment(problem)
    row = [int(action) for action in actions[:, 0]]

    def one_episode() -> None:
        one.reset()
        for action in row:
            _, _, terminated, truncated, _ = one.step(action)
            if terminated or truncated:
                one.reset()

    return [*figures, steps_a_second(len(row), one_episode)]


if __name__ == "__main__":
    print("problem  1024, drawn beforehand  1024, drawn now  1024, first round  one episode   [steps/s]")
    for name in sys.argv[1:] or ["hubble", "jwst"]:
        print(name, *(f"{figure:,.0f}" for figure in measure(name)), sep="  ")
