#include "orasp/planners/exhaustive.h"

#include <optional>
#include <string>
#include <vector>

#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

std::optional<std::string> exhaustive_obstacle(const TransitionSystem& system) {
  if (system.num_steps() <= kExhaustiveMaxConnections) return std::nullopt;
  return "tries every sequence and takes at most " + std::to_string(kExhaustiveMaxConnections) +
         " connections; this problem has " + std::to_string(system.num_steps());
}

Result exhaustive(const TransitionSystem& system, const Budget& budget) {
  // Depth first over the tree H~ with nothing but a stack.
  constexpr std::uint64_t kPollEvery = 4096;
  const Stopwatch watch;
  if (const auto reason = exhaustive_obstacle(system)) throw Refusal("exhaustive", *reason);
  if (system.wide()) return detail::wide_exhaustive(system, budget);
  if (auto result = detail::infeasible_at_once(system, "exhaustive")) return *result;
  Result result;
  result.method = "exhaustive";
  Statistics& statistics = result.statistics;
  Expander expander(system);
  ConnectionSet state = system.start();
  std::vector<std::vector<Action>> untried;  // by depth, last to be tried first
  std::vector<Action> taken;
  const auto expand = [&] {
    const auto legal = expander.legal_actions(state.view());
    untried.emplace_back(legal.rbegin(), legal.rend());
    ++statistics.expanded;
  };

  expand();
  result.stop = budget.expired(0, statistics.expanded);
  while (result.stop == Stop::None) {
    if (state.empty()) {
      double reward = 0;
      for (const Action& action : taken) reward += action.reward;
      if (reward > result.reward || result.status == Status::Unknown) {
        result.status = Status::Feasible;
        result.reward = reward;
        result.sequence.clear();
        for (const Action& action : taken) result.sequence.push_back(action.connection);
      }
    }
    if (untried.back().empty()) {
      untried.pop_back();
      if (untried.empty()) break;
      state.insert(taken.back().connection);
      taken.pop_back();
      continue;
    }
    taken.push_back(untried.back().back());
    untried.back().pop_back();
    state.erase(taken.back().connection);
    ++statistics.generated;
    expand();
    if (statistics.expanded % kPollEvery == 0 || budget.max_expansions < kPollEvery) {
      result.stop = budget.expired(0, statistics.expanded);
      budget.report({.phase = "search", .done = statistics.expanded, .best = result.reward});
    }
  }

  if (result.stop == Stop::None) {
    if (result.status == Status::Unknown) {
      result = detail::exhausted("exhaustive", statistics);
    } else {
      result.status = Status::Optimal;
      result.bound = result.reward;
    }
  } else if (result.status == Status::Unknown) {
    result = detail::stopped_with_quick_plan(system, "exhaustive", result.stop, statistics);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
