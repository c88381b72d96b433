#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orasp/containers/state_table.h"
#include "orasp/planners/planner_support.h"

namespace orasp::detail {

/// Finds some legal sequence from the state `from` (open connections) to the state `to`, a subset
/// of it, depth first, backtracking at dead ends. `arrange(open, std::span<Action>)` puts the legal
/// actions of a state into the order in which they are tried and returns how many of them to try;
/// it leaves out those of `to`. States from which everything failed are kept in a table, so none is
/// tried twice; so it is complete over the actions that `arrange` keeps.
template <class Arrange>
[[nodiscard]] Result depth_first_search(const TransitionSystem& system, const ConnectionSet& from,
                                        const ConnectionSet& to, const Budget& budget,
                                        std::string_view method, Arrange&& arrange) {
  // A state of thousands of connections takes a millisecond.
  const std::uint64_t poll_every = system.num_connections() < 1000 ? 64 : 4;
  const Stopwatch watch;
  Result result;
  result.method = method;
  Statistics& statistics = result.statistics;
  Expander expander(system);
  StateTable<0> failed(system.words());
  ConnectionSet state = from;
  const std::size_t goal_depth = from.size() - to.size();

  std::vector<Action> actions;
  // Where the untried actions of each state begin in `actions`; the last of them is tried first.
  std::vector<std::size_t> frames;
  std::vector<Action> taken;
  result.stop = budget.expired();
  while (result.stop == Stop::None && taken.size() < goal_depth) {
    const bool is_new_state = frames.size() == taken.size();
    if (is_new_state) {
      const bool known_failure =
          failed.size() > 0 && failed.find(state.view().data()) != StateTable<0>::kAbsent;
      const std::size_t begin = actions.size();
      if (!known_failure) {
        const auto legal = expander.legal_actions(state.view());
        actions.insert(actions.end(), legal.begin(), legal.end());
        const auto mine = std::span(actions).subspan(begin);
        const std::size_t kept = arrange(state.view(), mine);
        actions.resize(begin + kept);
        std::ranges::reverse(std::span(actions).subspan(begin));
        ++statistics.expanded;
      } else {
        ++statistics.pruned;
      }
      frames.push_back(begin);
      if (statistics.expanded % poll_every == 0 || budget.max_expansions < poll_every) {
        result.stop =
            budget.expired(failed.bytes() + actions.size() * sizeof(Action), statistics.expanded);
      }
    }
    const bool everything_failed = actions.size() == frames.back();
    if (everything_failed) {
      failed.insert(state.view().data());
      frames.pop_back();
      if (frames.empty()) break;
      state.insert(taken.back().connection);
      taken.pop_back();
      continue;
    }
    taken.push_back(actions.back());
    actions.pop_back();
    state.erase(taken.back().connection);
    ++statistics.generated;
  }

  statistics.states = failed.size();
  statistics.peak_bytes = failed.bytes() + actions.capacity() * sizeof(Action);
  if (taken.size() == goal_depth) {
    result.stop = Stop::None;
    // Where nothing is to be done, the empty plan is the only one, and so the best.
    result.status = goal_depth == 0 ? Status::Optimal : Status::Feasible;
    if (goal_depth == 0) result.bound = 0;
    result.reward = 0;
    for (const Action& action : taken) {
      result.sequence.push_back(action.connection);
      result.reward += action.reward;
    }
  } else if (result.stop == Stop::None) {
    result = exhausted(method, statistics);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

/// Finds some plan: the frame of `greedy` and `random`. `arrange` as above, for all connections.
/// Where it goes on for long without a plan, because of dead ends, any plan is looked for instead.
template <class Arrange>
[[nodiscard]] Result depth_first_plan(const TransitionSystem& system, const Budget& budget,
                                      std::string_view method, Arrange&& arrange) {
  if (auto result = infeasible_at_once(system, method)) return *result;
  const ConnectionSet goal(system.num_connections());
  const std::uint64_t long_search = 20 * system.num_connections() + 5000;
  if (system.ordered() || budget.max_expansions <= long_search)
    return depth_first_search(system, system.start(), goal, budget, method, arrange);
  const Stopwatch watch;
  Budget first = budget;
  first.max_expansions = long_search;
  Result result = depth_first_search(system, system.start(), goal, first, method, arrange);
  if (result.stop != Stop::ExpansionLimit) return result;
  Result other = any_plan(system, budget);
  if (other.has_plan() || other.status == Status::Infeasible) {
    if (other.status == Status::Infeasible) other = exhausted(method, other.statistics);
    other.method = method;
    other.stop = Stop::None;
    if (other.has_plan())
      other.notes.push_back(std::string(method) +
                            " met too many dead ends: this is the first plan of another search");
    other.statistics.expanded += result.statistics.expanded;
    other.statistics.seconds = watch.seconds();
    return other;
  }
  Result last = depth_first_search(system, system.start(), goal, budget, method, arrange);
  last.statistics.expanded += result.statistics.expanded + other.statistics.expanded;
  last.statistics.seconds = watch.seconds();
  return last;
}

}  // namespace orasp::detail
