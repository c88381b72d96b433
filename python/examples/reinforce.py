#!/usr/bin/env python3
"""Learns the order of a product by REINFORCE (Williams 1992, Machine Learning 8, 229-256), with NumPy alone.

    ./run python python/examples/reinforce.py [PROBLEM [ROUNDS]]

A network with one hidden layer says how likely each legal action is. In each round some hundred episodes are
played by it, and its weights are moved so that actions after which more was earned than usual become
likelier. Usual is the mean of the states of the round with as many ones in what is observed. A bonus for
undecidedness, less of it each round, keeps it trying.
"""

from __future__ import annotations

import sys

import numpy as np
import numpy.typing as npt

import orasp

Floats = npt.NDArray[np.float32]

EPISODES, HIDDEN, RATE, UNDECIDED, DEAD_END = 512, 128, 1e-3, 0.1, -5.0


class Policy:
    """Masked softmax over the outputs of relu(observations @ w1 + b1) @ w2 + b2, trained by Adam (Kingma and Ba 2015)."""

    def __init__(self, inputs: int, outputs: int, random: np.random.Generator) -> None:
        scale = np.sqrt(2 / inputs)
        self.weights: list[Floats] = [
            (random.standard_normal((inputs, HIDDEN)) * scale).astype(np.float32),
            np.zeros(HIDDEN, np.float32),
            np.zeros((HIDDEN, outputs), np.float32),
            np.zeros(outputs, np.float32),
        ]
        self.means = [np.zeros_like(w) for w in self.weights]
        self.squares = [np.zeros_like(w) for w in self.weights]
        self.updates = 0

    def forward(self, observations: Floats, masks: npt.NDArray[np.int8]) -> tuple[Floats, Floats]:
        """The hidden layer, [rows, HIDDEN], and the log-probabilities, [rows, actions], for rows of states."""
        w1, b1, w2, b2 = self.weights
        hidden = np.maximum(observations @ w1 + b1, 0)
        scores = np.where(masks == 1, hidden @ w2 + b2, np.float32(-1e9))
        scores -= scores.max(axis=1, keepdims=True)
        return hidden, scores - np.log(np.exp(scores).sum(axis=1, keepdims=True))

    def ascend(self, observations: Floats, hidden: Floats, wanted: Floats) -> None:
        """One step up the gradient, given that of the scores, [rows, actions]."""
        back = (wanted @ self.weights[2].T) * (hidden > 0)
        gradients = [observations.T @ back, back.sum(axis=0), hidden.T @ wanted, wanted.sum(axis=0)]
        self.updates += 1
        for w, g, mean, square in zip(self.weights, gradients, self.means, self.squares):
            mean += 0.1 * (g - mean)
            square += 0.001 * (g * g - square)
            unbiased = np.sqrt(square / (1 - 0.999**self.updates)) + 1e-8
            w += RATE * mean / (1 - 0.9**self.updates) / unbiased


def learn(problem: str, rounds: int, seed: int = 1) -> tuple[orasp.VectorEnvironment, list[float]]:
    """Trains for so many rounds; the environment, which knows the best plan, and what episodes earned, the
    mean by round."""
    random = np.random.default_rng(seed)
    environment = orasp.VectorEnvironment(problem, EPISODES, copy=True)
    observations, info = environment.reset(seed=seed)
    policy = Policy(observations.shape[1], info["action_mask"].shape[1], random)
    steps = int(observations[0].sum())
    means: list[float] = []
    for number in range(rounds):
        seen, masks, taken, earned, ended = [], [], [], [], []
        for _ in range(steps):
            # The greatest of scores with Gumbel noise is a draw by the probabilities.
            logs = policy.forward(observations, info["action_mask"])[1]
            actions = (logs + random.gumbel(size=logs.shape)).argmax(axis=1)
            seen.append(observations)
            masks.append(info["action_mask"])
            taken.append(actions)
            observations, rewards, terminated, truncated, info = environment.step(actions)
            earned.append(rewards + DEAD_END * truncated)
            ended.append(terminated | truncated)
        # What was earned from each step to the end of its episode, where that was reached.
        returns, known = np.zeros((steps, EPISODES)), np.zeros((steps, EPISODES), bool)
        after, ends = np.zeros(EPISODES), np.zeros(EPISODES, bool)
        for t in reversed(range(steps)):
            after = earned[t] + np.where(ended[t], 0, after)
            ends = ends | ended[t]
            returns[t], known[t] = after, ends
        rows, legal, chosen = np.concatenate(seen), np.concatenate(masks), np.concatenate(taken)
        gain, weight = returns.ravel(), known.ravel().astype(np.float32)
        ones = rows.sum(axis=1).astype(int)
        gain = gain - (np.bincount(ones, gain * weight) / np.maximum(1, np.bincount(ones, weight)))[ones]
        gain = gain / (gain.std() + 1e-8)
        # The gradient of gain * log p(chosen) + UNDECIDED * entropy by the scores.
        hidden, logs = policy.forward(rows, legal)
        chance = np.exp(logs)
        entropy = -(chance * logs).sum(axis=1, keepdims=True)
        undecided = UNDECIDED * (1 - number / rounds) * chance * (-logs - entropy)
        wanted = -chance * gain[:, None]
        wanted[np.arange(len(rows)), chosen] += gain
        policy.ascend(rows, hidden, ((wanted + undecided) * weight[:, None] / len(rows)).astype(np.float32))
        means.append(float(returns[0].mean()))
        if number % 10 == 9:
            print(f"round {number + 1}: mean {means[-1]:.4f}, best {environment.best_reward}")
    return environment, means


if __name__ == "__main__":
    name = sys.argv[1] if len(sys.argv) > 1 else "hubble"
    trained, _ = learn(name, int(sys.argv[2]) if len(sys.argv) > 2 else 50)
    print(trained.best_reward, *(trained.best_plan or []))
