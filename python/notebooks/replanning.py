# %% [markdown]
# # Replanning in a cell
#
# A robot cell takes Hubble apart. Things go wrong, and the plan is asked for again, in microseconds.

# %%
import time

import orasp

cell = orasp.Replanner("hubble")
plan = cell.plan()
print(cell.held_states, "states are held;", plan)

# %% [markdown]
# The cell works off the plan. At the third step a connection turns out to be stuck.

# %%
for connection in plan.connections[:2]:
    cell.done(connection)
stuck = cell.plan().connections[0]
cell.set_accessible(stuck, False)
began = time.perf_counter()
rest = cell.plan()
print(f"without {stuck}: {rest.status}, {len(rest.connections)} steps, found in {(time.perf_counter() - began) * 1e6:.0f} us")

# %% [markdown]
# It is repaired; then a part arrives late, and all that needs it comes last.

# %%
cell.set_accessible(stuck, True)
cell.set_late("7", True)
late = cell.plan()
print(late.connections)
needs_7 = [c for c in late.connections if "7" in c.split("-")]
print("needs the late part:", needs_7)

# %% [markdown]
# The same in one call, with what it changes against the old plan.

# %%
answer = orasp.replan("hubble", plan=plan, done=2, inaccessible=stuck)
print(answer.status, answer.reward, answer.changes)

# %% [markdown]
# Where attempts may fail, a plan becomes a policy, and a simulation shows what to expect.

# %%
risky = orasp.load("4piece").copy()
risky["connections"] = [dict(connection, success=0.9) for connection in risky["connections"]]
risky.objective = "time"
policy = orasp.solve(risky)
simulation = orasp.simulate(risky, 2000, policy=policy)
assert simulation.statistics is not None and policy.expectation is not None
print(f"expected {policy.reward:.3f}, simulated {simulation.statistics.mean:.3f}, {policy.expectation.attempts:.2f} attempts")
