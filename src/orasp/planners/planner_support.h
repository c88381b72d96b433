#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/state_graph.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// The answer where none needs to be searched for: no plan exists by
/// TransitionSystem::infeasibility().
[[nodiscard]] std::optional<Result> settled(const TransitionSystem& system,
                                            std::string_view method);

/// The reward of a sequence of legal steps from the start. O(steps * (parts + connections)).
[[nodiscard]] double reward_of(const TransitionSystem& system,
                               std::span<const ConnectionIndex> sequence);

/// The answer of a method that was stopped before it had a plan of its own: a greedy plan, or any,
/// if one is found at once. `statistics` are those of the method.
[[nodiscard]] Result stopped(const TransitionSystem& system, std::string_view method, Stop stop,
                             const Statistics& statistics);

/// An upper bound on what any plan earns (BoundKind::Best); empty where none is known.
[[nodiscard]] std::optional<double> bound_of_start(const TransitionSystem& system);

/// Whether a plan earns all that `bound` allows, but for rounding. Not where there is no plan
/// (-infinity).
[[nodiscard]] bool meets(double reward, double bound);

/// Sets status and bound of a result that holds a plan: Optimal, and not stopped, if it meets the
/// bound; else Feasible.
void judge_by(std::optional<double> bound, Result& result);

/// "no plan exists: ..." for a method that looked at everything.
[[nodiscard]] Result exhausted(std::string_view method, const Statistics& statistics);

/// What a method says that needs a bound where `kind` knows nothing about the problem: a clause
/// that goes on from the method's name.
[[nodiscard]] std::string unknown_bound(const TransitionSystem& system, BoundKind kind);
/// The same where `bound`, made of that kind, knows nothing; empty where it is known.
[[nodiscard]] std::optional<std::string> bound_obstacle(const Bound& bound,
                                                        const TransitionSystem& system,
                                                        BoundKind kind);

/// Counters of a method that holds H.
[[nodiscard]] Statistics statistics_of(const StateGraph& graph);

/// Builds H within the budget and runs `plan(graph)` on it, with the refusals and endings that all
/// methods on H share. `other_bytes` as in graph_obstacle.
template <class Plan>
[[nodiscard]] Result on_graph(const TransitionSystem& system, const Budget& budget,
                              std::string_view method, Plan&& plan, double other_bytes = 0) {
  const Stopwatch watch;
  if (auto result = settled(system, method)) return *result;
  if (const auto reason = graph_obstacle(system, budget, other_bytes))
    throw Refusal(method, *reason);
  const StateGraph graph = StateGraph::build(system, budget);
  Result result = graph.stop() != Stop::None
                      ? stopped(system, method, graph.stop(), statistics_of(graph))
                      : plan(graph);
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp::detail
