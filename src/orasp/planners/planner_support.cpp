#include "orasp/planners/planner_support.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "orasp/bounds/companion_bound.h"
#include "orasp/bounds/wide_bound.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/error.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/peeled_plan.h"
#include "orasp/planners/detail/quick_plan.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/feasibility.h"
#include "orasp/planners/greedy.h"

namespace orasp::detail {

std::optional<Result> infeasible_at_once(const TransitionSystem& system, std::string_view method) {
  const auto reason = system.infeasibility();
  if (!reason) return std::nullopt;
  Result result;
  result.method = method;
  result.status = Status::Infeasible;
  result.notes.push_back("no plan exists: " + reason->message);
  return result;
}

void take_walk(PlanWalk walk, Result& result) {
  result.sequence.clear();
  for (const PlanStep& step : walk.steps)
    result.sequence.insert(result.sequence.end(), step.connections.begin(), step.connections.end());
  result.steps = std::move(walk.steps);
  result.reward = walk.reward;
}

void take_path(const StateGraph& graph, std::span<const StateId> parent, Result& result) {
  std::vector<StateId> path{*graph.goal()};
  while (path.back() != 0) path.push_back(parent[path.back()]);
  std::ranges::reverse(path);
  take_walk(graph.steps_along(path), result);
}

namespace {

/// The seconds that a quick plan may take after a limit has ended a method.
constexpr double kAtOnce = 0.02;
constexpr double kAtOnceByPart = 0.08;

}  // namespace

double reward_of(const TransitionSystem& system, std::span<const ConnectionIndex> sequence) {
  Expander expander(system);
  ConnectionSet open = system.start();
  double reward = 0;
  for (const ConnectionIndex c : sequence) {
    reward += expander.step(open.view(), c).reward;
    open.erase(c);
  }
  return reward;
}

Result any_plan(const TransitionSystem& system, const Budget& budget) {
  Result result;
  if (system.ordered()) return result;
  const bool makes = !system.takes_apart();
  const ConnectionSet none(system.num_connections());
  const ConnectionSet start = system.present(system.start().view());
  const ConnectionSet goal = system.present(none.view());
  Feasibility found =
      find_order(system.problem(), makes ? goal : start, makes ? start : goal, budget);
  result.stop = found.stop;
  result.statistics.expanded = found.expanded;
  if (found.status != Status::Feasible) {
    result.status = found.status;
    return result;
  }
  if (makes) std::ranges::reverse(found.order);
  result.sequence = std::move(found.order);
  result.status = Status::Feasible;
  result.reward = reward_of(system, result.sequence);
  return result;
}

namespace {

/// A plan where a step handles one connection and nothing else, as quickly as there is one.
Result quick_narrow_plan(const TransitionSystem& system, Budget at_once) {
  // A quick plan of few takes some milliseconds at most, and no limit is needed.
  const bool small = system.num_connections() <= kManyConnections;
  if (!small) at_once.set_time_limit(kAtOnce);
  Result result = small ? greedy(system, at_once) : from_the_end(system, quick_plan);
  if (!small && !result.has_plan())
    result = from_the_end(system, [](const TransitionSystem& from) { return peeled_plan(from); });
  if (!small && !result.has_plan()) result = greedy(system, at_once);
  if (!result.has_plan()) {
    if (!small) at_once.set_time_limit(kAtOnce);
    result = any_plan(system, at_once);
  }
  return result;
}

/// The same for TransitionSystem::wide().
Result quick_wide_plan(const TransitionSystem& system, Budget at_once) {
  if (!system.rules().by_part) return greedy(system, at_once);
  at_once.set_time_limit(kAtOnceByPart);
  return plan_of_few_moves(system, at_once);
}

}  // namespace

Result stopped_with_quick_plan(const TransitionSystem& system, std::string_view method, Stop stop,
                               const Statistics& statistics) {
  Budget at_once;
  at_once.max_expansions = std::max<std::uint64_t>(2 * system.num_steps(), 2000);
  Result result =
      system.wide() ? quick_wide_plan(system, at_once) : quick_narrow_plan(system, at_once);
  // A proof by greedy is none of the method that was asked.
  if (result.status == Status::Infeasible) result.status = Status::Unknown;
  result.method = method;
  result.stop = stop;
  result.statistics = statistics;
  result.notes.clear();
  if (result.has_plan())
    result.notes.emplace_back(
        "the plan is a quick one: the method was stopped before it had its own");
  return result;
}

Result or_quick_plan(const TransitionSystem& system, Result result) {
  const bool spent = result.stop == Stop::TimeLimit || result.stop == Stop::MemoryLimit;
  if (result.has_plan() || !spent) return result;
  return stopped_with_quick_plan(system, result.method, result.stop, result.statistics);
}

Result exhausted(std::string_view method, const Statistics& statistics) {
  Result result;
  result.method = method;
  result.status = Status::Infeasible;
  result.statistics = statistics;
  result.notes.push_back(
      "no plan exists: every legal sequence ends in a state from which no step is legal");
  return result;
}

std::string unknown_bound(const TransitionSystem& system, BoundKind kind) {
  const std::string& objective = system.problem().objective().stated_type();
  if (kind == BoundKind::Best) {
    return "needs a bound on what a step can earn, and none is known for the objective '" +
           objective + "'";
  }
  return "needs a bound, and '" + std::string(kBoundNames[static_cast<std::size_t>(kind)]) +
         "' knows nothing about this problem under the objective '" + objective +
         "' (the bound 'best' takes what is known)";
}

std::optional<std::string> bound_obstacle(const Bound& bound, const TransitionSystem& system,
                                          BoundKind kind) {
  if (bound.known()) return std::nullopt;
  return unknown_bound(system, kind);
}

Statistics statistics_of(const StateGraph& graph) {
  Statistics statistics;
  statistics.states = graph.num_states();
  statistics.actions = graph.num_actions();
  statistics.expanded = graph.num_states();
  statistics.generated = graph.num_actions();
  statistics.peak_bytes = graph.peak_bytes();
  return statistics;
}

std::optional<double> bound_of_start(const TransitionSystem& system) {
  if (system.wide()) {
    WideBound bound(system);
    const double most = bound.known() ? bound(system.start_state()) : kInfinity;
    return std::isfinite(most) ? std::optional(most) : std::nullopt;
  }
  if (!system.takes_apart() && !system.ordered()) return bound_of_start(system.backwards());
  const std::unique_ptr<Bound> bound = make_bound(system, BoundKind::Best);
  if (!bound->known()) return std::nullopt;
  const double most = std::min({(*bound)(system.start().view()), start_by_places(*bound).most,
                                CompanionBound(system).most()});
  return std::isfinite(most) ? std::optional(most) : std::nullopt;
}

std::optional<Result> checked_plan(const TransitionSystem& system,
                                   std::vector<ConnectionIndex> order) {
  if (system.ordered()) return std::nullopt;
  const bool backwards = system.completes_first();
  if (backwards) std::ranges::reverse(order);
  PlanCheck check;
  try {
    check = check_plan(system.problem(), system.situation(), order);
  } catch (const InputError&) {
    return std::nullopt;  // a formula without a value for one of the steps
  }
  if (!check.legal) return std::nullopt;
  if (backwards) std::ranges::reverse(order);
  Result result;
  result.status = Status::Feasible;
  result.reward = check.reward;
  result.sequence = std::move(order);
  return result;
}

bool meets(double reward, double bound) {
  return bound <= reward + kRewardTolerance * std::max(1.0, std::abs(reward));
}

void judge_by(std::optional<double> bound, Result& result) {
  if (bound && meets(result.reward, *bound)) {
    result.status = Status::Optimal;
    result.stop = Stop::None;
    result.bound = result.reward;
  } else {
    result.status = Status::Feasible;
    if (bound) result.bound = std::max(*bound, result.reward);
  }
}

}  // namespace orasp::detail
