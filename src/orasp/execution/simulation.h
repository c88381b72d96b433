#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/graph/uncertain_graph.h"
#include "orasp/model/transition_system.h"
#include "orasp/model/validate.h"
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

/// Why attempts of this problem cannot be played, in one sentence; empty where they can.
[[nodiscard]] std::optional<std::string> simulation_obstacle(const TransitionSystem& system);

/// What a simulation followed, and what came of it.
struct Followed {
  std::vector<ConnectionIndex> plan;  ///< empty: none was given
  /// Feasible; Infeasible where what is followed may end in a dead end; Unknown where time or
  /// memory ended the work before the first run.
  Status status = Status::Unknown;
  double expected = 0;           ///< reward
  double expected_attempts = 0;  ///< a run
  bool proved_best = true;       ///< what was found to be followed, where nothing was given
  Simulation simulation;
  std::vector<std::string> notes;
};

/// Simulates. `plan`, the replay of a plan, and `policy` say what is followed, at most one of them;
/// null: what `find` finds in half of the time, the best policy where it proves that. Where every
/// attempt succeeds (TransitionSystem::wide(): a goal, part steps, costs between steps) all runs
/// are the same, and `find` has all of the time.
/// @throws InputError for a plan that is not legal, a policy where every attempt succeeds, and as
/// guide_by_policy.
[[nodiscard]] Followed follow(const TransitionSystem& system, const Evaluation* plan,
                              const std::vector<PolicyState>* policy,
                              const std::function<Result(const Budget&)>& find,
                              const SimulationOptions& options, const Budget& budget);

}  // namespace orasp
