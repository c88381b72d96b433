#include "orasp/graph/uncertain_graph.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "orasp/graph/detail/attempt_outcomes.h"
#include "orasp/model/tolerance.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// So many states are expanded between two looks at the clock.
constexpr std::uint64_t kPollEvery = 256;

}  // namespace

std::uint64_t UncertainGraph::bytes() const {
  return states_.bytes() + attempts_.bytes() +
         states_.size() * (2 * sizeof(std::uint64_t) + sizeof(State) + 1);
}

UncertainGraph UncertainGraph::build(const TransitionSystem& system, const Budget& budget,
                                     const Guide& guide) {
  UncertainGraph graph(system);
  const Problem& problem = system.problem();
  const ConnectionSet start = system.start();
  Budget limited = budget;
  limited.max_bytes = allowed_bytes(budget);

  std::vector<std::vector<State>> by_open(start.size() + 1);
  const auto number_of = [&](const std::uint64_t* key, std::size_t open) {
    if (graph.states_.size() >= kJobEnded - 1)
      throw InputError("value-iteration: there are more than 2^32 - 2 states");
    const auto [number, is_new] = graph.states_.insert(key);
    if (is_new) {
      by_open[open].push_back(number);
      graph.row_begin_.push_back(0);
      graph.row_end_.push_back(0);
      graph.guided_.push_back(false);
    }
    return number;
  };
  static_cast<void>(number_of(start.view().data(), start.size()));

  Expander expander(system);
  std::vector<std::uint64_t> here(system.words());
  std::vector<std::uint64_t> next(system.words());
  const auto clear = [&next](ConnectionIndex c) {
    next[c / 64] &= ~(std::uint64_t{1} << (c % 64));
  };
  std::uint64_t expanded = 0;
  for (std::size_t open = start.size(); open > 0; --open) {
    for (const State s : by_open[open]) {
      if (expanded++ % kPollEvery == 0) {
        limited.report({.phase = "building the states",
                        .done = expanded,
                        .total = 0,
                        .states = graph.num_states()});
        graph.stop_ = limited.expired(graph.bytes(), expanded);
        if (graph.stop_ != Stop::None) return graph;
      }
      std::copy_n(graph.states_.key(s), here.size(), here.begin());
      std::span<const Action> actions = expander.legal_actions(here);
      if (guide && !actions.empty()) {
        if (const auto chosen = guide(here)) {
          const auto found = std::ranges::find(actions, *chosen, &Action::connection);
          if (found != actions.end()) {
            actions = actions.subspan(static_cast<std::size_t>(found - actions.begin()), 1);
            graph.guided_[s] = true;
          }
        }
      }
      graph.row_begin_[s] = graph.attempts_.size();
      for (const Action& action : actions) {
        const ConnectionIndex connection = action.connection;
        const double reward = action.reward;
        Attempt attempt{.reward = reward, .connection = connection, .done = 0, .failed = s};
        next = here;
        clear(connection);
        attempt.done = number_of(next.data(), open - 1);
        const Connection& tried = problem.connections()[connection];
        if (tried.success < 1 && tried.on_failure.abort) attempt.failed = kJobEnded;
        if (detail::breaks_to(problem, connection, here, next))
          attempt.failed = number_of(next.data(), count(next));
        graph.attempts_.push_back(attempt);
      }
      graph.row_end_[s] = graph.attempts_.size();
    }
  }
  graph.stop_ = limited.expired(graph.bytes());
  graph.last_first_.reserve(graph.num_states());
  for (const std::vector<State>& layer : by_open)
    graph.last_first_.insert(graph.last_first_.end(), layer.rbegin(), layer.rend());
  return graph;
}

UncertainSolution solve_uncertain(const UncertainGraph& graph) {
  using State = UncertainGraph::State;
  using Attempt = UncertainGraph::Attempt;
  const detail::AttemptOutcomes outcomes(graph);
  UncertainSolution solution;
  solution.values.assign(graph.num_states(), -kInfinity);
  solution.choice.assign(graph.num_states(), UncertainSolution::kNone);
  solution.attempts.assign(graph.num_states(), 0.0);
  for (const State s : graph.last_first()) {
    if (detail::is_goal(graph, s)) {
      solution.values[s] = 0;
      continue;
    }
    std::tie(solution.values[s], solution.choice[s]) = detail::best_of(
        graph, s, solution.values,
        [&](const Attempt& attempt) { return outcomes.solved(attempt, s, solution.values); });
    if (solution.choice[s] == UncertainSolution::kNone) continue;
    const Attempt& attempt = graph.attempts(s)[solution.choice[s]];
    solution.attempts[s] = outcomes.attempts(attempt, s, solution.attempts);
    if (!std::isfinite(solution.values[s]) || !std::isfinite(solution.attempts[s])) {
      throw InputError("connections[" + std::to_string(attempt.connection) +
                       "].success: so small that the expected reward is not a finite number");
    }
  }
  return solution;
}

}  // namespace orasp
