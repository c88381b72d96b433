# %% [markdown]
# # An objective of your own
#
# What a step earns may be any function of the step. Here: lifting is cheap up to 3 kg, and dear beyond.

# %%
import time

import numpy as np
import numpy.typing as npt
import orasp

problem = orasp.load("lattice")


def lifting(step: orasp.Step) -> float:
    return -1.0 - 10.0 * max(0.0, step.moved_mass - 3.0)


plan = orasp.solve(problem, objective=lifting)
print(plan.status, plan.reward)

# %% [markdown]
# A function that is called for each step costs a microsecond or more each time. One that takes many steps at once
# gets arrays, and is called a few times.


# %%
def lifting_many(steps: orasp.Steps) -> npt.NDArray[np.float64]:
    return np.asarray(-1.0 - 10.0 * np.maximum(0.0, steps.moved_mass - 3.0))


def seconds(objective: orasp.ObjectiveLike) -> float:
    began = time.perf_counter()
    orasp.solve(problem, "value-iteration", objective=objective)
    return time.perf_counter() - began


many = orasp.Reward(lifting_many, vectorized=True)
assert orasp.solve(problem, objective=many).reward == plan.reward
print(f"built in {seconds('cubesat') * 1e3:.1f} ms, one by one {seconds(lifting) * 1e3:.1f} ms, many {seconds(many) * 1e3:.1f} ms")

# %% [markdown]
# Methods that prove with bounds must know the greatest reward that a step can earn. It is taken at its word.

# %%
bounded = orasp.Reward(lifting_many, vectorized=True, greatest=-1.0)
proved = orasp.solve(problem, "orasp-search", objective=bounded)
print(proved.status, proved.reward, proved.bound)
assert proved.reward == plan.reward

# %% [markdown]
# What a formula can say is better a formula: it is part of the problem, can be saved, and is as fast as C++.

# %%
formula = {"type": "expression", "formula": "-1 - 10 * max(0, moved_mass - 3)"}
assert orasp.solve(problem, objective=formula).reward == plan.reward
