# %% [markdown]
# # A first plan
#
# A shelf: three parts, two connections. Which connection is made first, and what does it cost?
#
# Each `# %%` begins a cell: VS Code, Spyder and Jupyter (with jupytext) open this file as a notebook.

# %%
import orasp

shelf = orasp.Problem("Shelf", objective="time")
left = shelf.add_part("left", mass=4, position=[0, 0, 0])
right = shelf.add_part("right", mass=4, position=[1, 0, 0])
board = shelf.add_part("board", mass=2, position=[0.5, 0, 0.4])
shelf.connect(left, board, duration=20)
shelf.connect(right, board, duration=35)
shelf

# %% [markdown]
# The drawing above is the assembly graph. A plan is an order of the connections, and the result says what is proved.

# %%
plan = orasp.solve(shelf)
print(plan.status, plan.reward, plan.connections)
for step in plan.steps:
    print(step.number, step.connection, step.reward, "moves", ", ".join(step.moved) or "nothing")

# %% [markdown]
# The same forwards: what may be made only after what is said by precedence.

# %%
shelf.direction = "assembly"
shelf.require("left-board", made_after=["right-board"])
forward = orasp.solve(shelf)
print(forward.connections)
assert forward.connections == ["right-board", "left-board"]

# %% [markdown]
# Limits, and why there is no plan. `explain` names a smallest set of constraints that conflict.

# %%
stuck = shelf.edited(max_moved_parts=0)
print(orasp.solve(stuck).status)
for item in orasp.explain(stuck).conflict:
    print(item.where, "-", item.message)

# %% [markdown]
# A larger product, and all methods that prove something.

# %%
for row in orasp.compare("hubble", time_limit=10):
    print(f"{row.method:16} {row.status:10} {row.reward}")

# %% [markdown]
# In arrays, for statistics: what random orders earn.

# %%
best = orasp.solve("hubble")
sample = orasp.sample("hubble", 500)
print(f"best {best.reward:.4f}, random {sample.rewards.mean():.4f} on average, {sample.rewards.max():.4f} at most")
assert sample.rewards.max() <= best.reward + 1e-9
