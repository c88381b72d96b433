# %% [markdown]
# # Learning
#
# Deep Q-learning trains a network that says in every state which connection to handle next. Training needs libtorch;
# to plan with a policy does not.

# %%
import orasp

if not orasp.learning_available():
    raise SystemExit("libtorch is not there: apt-get install libtorch-dev libopenblas0-pthread, and build again")

rounds: list[dict[str, object]] = []
training = orasp.train("2x3", episodes=300, hidden=[32, 32], seed=1, log=rounds.append)
print(training.policy, training.record["episodes"], "episodes")

# %% [markdown]
# The curve: what the network earns without random actions.

# %%
for line in rounds[:: max(1, len(rounds) // 5)]:
    print(line["episodes"], line["greedy"], line["best"])

# %% [markdown]
# What it learned against what is proved.

# %%
policy = training.policy
assert policy is not None
best = orasp.solve("2x3")
print(f"policy {policy.reward:.4f}, optimum {best.reward:.4f}")
assert policy.reward <= best.reward + 1e-9

# %% [markdown]
# The network is plain weights: NumPy can do what it does.

# %%
import numpy as np

h = orasp.graph("2x3")
numbers = np.ones(h.problem.num_connections, dtype=np.float32)  # everything is open
for layer, (weights, bias) in enumerate(policy.layers):
    numbers = numbers @ weights + bias
    if layer + 1 < len(policy.layers):
        numbers = np.maximum(numbers, 0)
row = slice(int(h.row_offsets[0]), int(h.row_offsets[1]))
worth = policy.scale * numbers[h.connections[row]] + (h.rewards[row] if policy.adds_reward else 0)
first = h.connections[row][int(np.argmax(worth))]
print("first:", h.problem.connection_ids[first])
assert h.problem.connection_ids[first] == policy.follow("2x3").connections[0]
