#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/graph/uncertain_graph.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// A guide that follows a plan: it names the first connection of the plan that is still open. Where
/// that is not legal, the graph keeps all attempts, and the best is chosen knowing that the plan is
/// taken up again.
[[nodiscard]] UncertainGraph::Guide guide_by_plan(std::span<const ConnectionIndex> sequence);

/// A guide that follows a policy.
/// @throws InputError, when it is asked, where the policy has no entry for a state that is not the
/// goal, or names a connection that is not legal there.
[[nodiscard]] UncertainGraph::Guide guide_by_policy(const TransitionSystem& system,
                                                    std::span<const PolicyState> policy);

struct SimulationOptions {
  std::uint64_t runs = 10'000;
  std::uint64_t seed = 1;
};

/// What random runs came to.
struct Simulation {
  /// What each run earned, and how many attempts it made.
  std::vector<double> rewards;
  std::vector<std::uint64_t> attempts;
  /// How many runs a failure ended.
  std::uint64_t aborted = 0;
  /// How often the plan could not go on: its next connection was not legal, or had come off.
  std::uint64_t replanned = 0;
  /// What ended the simulation before its last run; the run under way is then dropped.
  Stop stop = Stop::None;
};

/// Executes `choice` (of solve_uncertain on this graph; the start must have a finite value) with
/// random failures. `plan`, if there is one, is what guides the graph. Run i draws from SplitMix64
/// seeded with the i-th number of SplitMix64(seed), so a longer simulation begins with the shorter
/// one, and the same seed gives the same runs on every machine. O(attempts made).
[[nodiscard]] Simulation simulate(const UncertainGraph& graph,
                                  std::span<const std::uint32_t> choice,
                                  std::span<const ConnectionIndex> plan,
                                  const SimulationOptions& options, const Budget& budget);

/// Runs where every attempt succeeds, as with a goal, part steps and costs between steps
/// (TransitionSystem::wide()): each takes the same steps and earns the same. `stop` is what ended
/// the search for them. O(runs).
[[nodiscard]] Simulation certain_runs(double reward, std::size_t attempts, Stop stop,
                                      const SimulationOptions& options);

/// Why attempts of this problem cannot be played, in one sentence; empty where they can.
[[nodiscard]] std::optional<std::string> simulation_obstacle(const TransitionSystem& system);

}  // namespace orasp
