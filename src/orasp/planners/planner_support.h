#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/state_graph.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// The answer "no plan exists" where TransitionSystem::infeasibility() shows that without a search;
/// empty elsewhere.
[[nodiscard]] std::optional<Result> infeasible_at_once(const TransitionSystem& system,
                                                       std::string_view method);

/// The reward of a sequence of legal steps from the start. O(steps * (parts + connections)).
[[nodiscard]] double reward_of(const TransitionSystem& system,
                               std::span<const ConnectionIndex> sequence);

/// Sets the plan of a result, and its reward, to this walk.
void take_walk(PlanWalk walk, Result& result);

/// Sets the plan of a result, and what it earns, to the path in H that ends at the goal, which is
/// reached, and comes from each state's parent. Where steps are wide.
void take_path(const StateGraph& graph, std::span<const StateId> parent, Result& result);

/// Runs `plan(system)`, which returns a Result. Where steps make connections it is run backwards,
/// from the product to where the work stands, and its sequence is turned round: from there more is
/// known about what is still to come, and there are no dead ends of precedence. Not where the order
/// of the work matters in itself (TransitionSystem::ordered). Notes how long it took.
template <class Plan>
[[nodiscard]] Result from_the_end(const TransitionSystem& system, Plan&& plan) {
  const Stopwatch watch;
  Result result;
  if (system.takes_apart() || system.ordered() || system.wide()) {
    result = plan(system);
  } else {
    const TransitionSystem backwards = system.backwards();
    result = plan(backwards);
    std::ranges::reverse(result.sequence);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}
/// The same for plan(system, options) whose options hold an incumbent: that is turned as well.
template <class Options, class Plan>
[[nodiscard]] Result from_the_end(const TransitionSystem& system, const Options& options,
                                  Plan&& plan) {
  return from_the_end(system, [&](const TransitionSystem& from) {
    if (&from == &system || options.incumbent == nullptr) return plan(from, options);
    Result incumbent = *options.incumbent;
    std::ranges::reverse(incumbent.sequence);
    Options turned = options;
    turned.incumbent = &incumbent;
    return plan(from, turned);
  });
}

/// The plan that handles connections in this order, from the start of `system` on, with what it
/// earns; empty where that breaks a rule. By check_plan, not by the rules of the planners; since it
/// does not ask what else could be done instead, it is empty where the order of the work matters in
/// itself (TransitionSystem::ordered).
[[nodiscard]] std::optional<Result> checked_plan(const TransitionSystem& system,
                                                 std::vector<ConnectionIndex> order);

/// The first legal order that is found, whatever it earns (planners/feasibility.h): for problems in
/// which others run into dead ends. Infeasible where it is proved that there is none.
[[nodiscard]] Result any_plan(const TransitionSystem& system, const Budget& budget);

/// The answer of a method that was stopped before it had a plan of its own. It runs greedy, and if
/// that fails looks for any plan, for some milliseconds: a user who set a limit still gets a plan
/// where one is found so quickly. `statistics` are those of the method that was stopped.
[[nodiscard]] Result stopped_with_quick_plan(const TransitionSystem& system,
                                             std::string_view method, Stop stop,
                                             const Statistics& statistics);
/// What a method found that has no plan before it is done; where time or memory ended it, a quick
/// one.
[[nodiscard]] Result or_quick_plan(const TransitionSystem& system, Result result);

/// An upper bound on what any plan earns (BoundKind::Best); empty where none is known.
[[nodiscard]] std::optional<double> bound_of_start(const TransitionSystem& system);

/// Whether a plan of that reward earns all that `bound` allows, but for rounding. False where there
/// is no plan, whose reward is -infinity.
[[nodiscard]] bool meets(double reward, double bound);

/// Sets status and bound of a result that holds a plan: Optimal, and not stopped, if it meets the
/// bound; else Feasible.
void judge_by(std::optional<double> bound, Result& result);

/// The answer "no plan exists" of a method that has looked at everything.
[[nodiscard]] Result exhausted(std::string_view method, const Statistics& statistics);

/// What a method says that needs a bound where `kind` knows nothing about the problem: a clause
/// that goes on from the method's name.
[[nodiscard]] std::string unknown_bound(const TransitionSystem& system, BoundKind kind);
/// The same where `bound`, made of that kind, knows nothing; empty where it is known.
[[nodiscard]] std::optional<std::string> bound_obstacle(const Bound& bound,
                                                        const TransitionSystem& system,
                                                        BoundKind kind);

/// The counters of a method that builds H and goes through all of it.
[[nodiscard]] Statistics statistics_of(const StateGraph& graph);

/// Builds H within the budget and runs `plan(graph)` on it, with the refusals and endings that all
/// methods on H share. `other_bytes` as in graph_obstacle.
template <class Plan>
[[nodiscard]] Result on_graph(const TransitionSystem& system, const Budget& budget,
                              std::string_view method, Plan&& plan, double other_bytes = 0) {
  const Stopwatch watch;
  if (auto result = infeasible_at_once(system, method)) return *result;
  if (const auto reason = graph_obstacle(system, budget, other_bytes))
    throw Refusal(method, *reason);
  const StateGraph graph = StateGraph::build(system, budget);
  Result result = graph.stop() != Stop::None
                      ? stopped_with_quick_plan(system, method, graph.stop(), statistics_of(graph))
                      : plan(graph);
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp::detail
