# %% [markdown]
# # H by hand
#
# The state-action graph H as arrays: states as bits, and actions in the layout of a CSR matrix. Nothing is copied.

# %%
import networkx
import numpy as np
import orasp

h = orasp.graph("hubble")
print(h, h.states.dtype, h.successors.dtype)
print("from the start:", h.successors[h.row_offsets[0] : h.row_offsets[1]], h.open_connections(0)[:3], "...")

# %% [markdown]
# Value iteration in a dozen lines: a state's successors are in later layers, so one sweep from the last layer is enough.

# %%
values = np.full(h.num_states, -np.inf)
if h.goal is not None:
    values[h.goal] = 0.0
rows = h.row_offsets.astype(np.int64)
for layer in range(len(h.layer_offsets) - 2, -1, -1):
    first, last = int(h.layer_offsets[layer]), int(h.layer_offsets[layer + 1])
    offsets = rows[first : last + 1]
    busy = np.flatnonzero(np.diff(offsets))
    if len(busy):
        worth = h.rewards[offsets[0] : offsets[-1]] + values[h.successors[offsets[0] : offsets[-1]]]
        values[first + busy] = np.maximum.reduceat(worth, offsets[:-1][busy] - offsets[0])
print("from the start:", values[0])
assert np.array_equal(values, h.values())

# %% [markdown]
# The plan that these values make, and that it is one.

# %%
ids = h.problem.connection_ids
plan = [ids[c] for c in h.best_sequence(values)]
print(plan[:4], "...", orasp.evaluate("hubble", plan))

# %% [markdown]
# The same by NetworkX (a shortest path; costs are minus rewards) and, as a matrix, for SciPy.

# %%
length = networkx.bellman_ford_path_length(h.to_networkx(), 0, h.goal, weight="cost")
print(-length)
assert abs(-length - orasp.solve("hubble").reward) < 1e-9
matrix = h.to_scipy()
print(matrix.shape, matrix.nnz)

# %% [markdown]
# How H grows, and how many orders it stands for.

# %%
for name in ("3piece", "2x3", "lattice", "hubble"):
    size = orasp.graph(name).size()
    print(f"{name:8} {size.states:6} states {size.actions:6} actions {size.sequences:.3g} orders")
