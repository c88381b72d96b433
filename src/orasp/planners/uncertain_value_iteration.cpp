#include "orasp/planners/uncertain_value_iteration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "orasp/graph/detail/attempt_outcomes.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

namespace {

using State = UncertainGraph::State;
using Attempt = UncertainGraph::Attempt;
using detail::AttemptOutcomes;
using detail::best_of;
using detail::is_goal;

/// Expected rewards and attempts under a choice, fewest open connections first.
void evaluate_choice(const UncertainGraph& graph, UncertainSolution& solution) {
  const AttemptOutcomes outcomes(graph);
  for (const State s : graph.last_first()) {
    const std::uint32_t place = solution.choice[s];
    if (place == UncertainSolution::kNone) continue;
    const Attempt& attempt = graph.attempts(s)[place];
    solution.values[s] = outcomes.solved(attempt, s, solution.values);
    solution.attempts[s] = outcomes.attempts(attempt, s, solution.attempts);
  }
}

/// How far V at the start may be from the optimum: see "Guarantee" in the header.
struct Accuracy {
  double residual = 0;
  double error = 0;
};
Accuracy accuracy_of(const UncertainGraph& graph, const std::vector<double>& values) {
  const AttemptOutcomes outcomes(graph);
  Accuracy accuracy;
  double largest = 0;  // number that the residual is worked out from
  std::vector<double> most_attempts(graph.num_states(), 0.0);
  for (const State s : graph.last_first()) {
    if (values[s] == -kInfinity || is_goal(graph, s)) continue;
    const auto [next, place] = best_of(graph, s, values, [&](const Attempt& attempt) {
      largest = std::max(largest, std::abs(attempt.reward));
      if (attempt.failed == UncertainGraph::kJobEnded)
        largest = std::max(largest, std::abs(outcomes.failure(attempt, values)));
      return outcomes.plain(attempt, values);
    });
    accuracy.residual = std::max(accuracy.residual, std::abs(next - values[s]));
    largest = std::max(largest, std::abs(values[s]));
    most_attempts[s] = best_of(graph, s, values, [&](const Attempt& attempt) {
                         return outcomes.attempts(attempt, s, most_attempts);
                       }).first;
  }
  // The operator sums and multiplies a handful of numbers, none above twice the largest.
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * largest;
  if (most_attempts[0] > 0) accuracy.error = (accuracy.residual + rounding) * most_attempts[0];
  return accuracy;
}

/// The states that the policy can meet, but the goal: the start, then most open first.
std::vector<PolicyState> policy_of(const UncertainGraph& graph, const UncertainSolution& solution) {
  std::vector<bool> met(graph.num_states(), false);
  met[0] = true;
  std::vector<PolicyState> policy;
  const std::size_t connections = graph.system().num_connections();
  const auto& order = graph.last_first();
  for (auto s = order.rbegin(); s != order.rend(); ++s) {
    if (!met[*s] || solution.choice[*s] == UncertainSolution::kNone) continue;
    const Attempt& attempt = graph.attempts(*s)[solution.choice[*s]];
    policy.push_back({.open = ConnectionSet(connections, graph.state(*s)),
                      .next = attempt.connection,
                      .reward = solution.values[*s]});
    met[attempt.done] = true;
    if (attempt.failed != UncertainGraph::kJobEnded) met[attempt.failed] = true;
  }
  return policy;
}

/// The likeliest course under the choice. A failure that leaves the state as it is changes nothing:
/// the attempt is made again, and succeeds in the end. Of two that are equally likely, the one that
/// succeeds.
void find_most_likely(const UncertainGraph& graph, const UncertainSolution& solution,
                      Expectation& expectation) {
  const AttemptOutcomes outcomes(graph);
  struct Likelihood {
    double best = 1;
    bool succeeds = true;
  };
  std::vector<Likelihood> likelihoods(graph.num_states());
  for (const State s : graph.last_first()) {
    if (solution.choice[s] == UncertainSolution::kNone) continue;
    const Attempt& attempt = graph.attempts(s)[solution.choice[s]];
    const double p = attempt.failed == s ? 1 : outcomes.success(attempt);
    const double done = p * likelihoods[attempt.done].best;
    const double rest =
        attempt.failed == UncertainGraph::kJobEnded ? 1 : likelihoods[attempt.failed].best;
    const double failed = p == 1 ? 0 : (1 - p) * rest;
    likelihoods[s] = {.best = std::max(done, failed), .succeeds = done >= failed};
  }
  expectation.probability = likelihoods[0].best;
  for (State s = 0;
       s != UncertainGraph::kJobEnded && solution.choice[s] != UncertainSolution::kNone;) {
    const Attempt& attempt = graph.attempts(s)[solution.choice[s]];
    expectation.most_likely.push_back({attempt.connection, likelihoods[s].succeeds});
    s = likelihoods[s].succeeds ? attempt.done : attempt.failed;
  }
}

/// Iterates the plain operator on the states that have a value, V_{k+1} from V_k.
void sweep_textbook(const UncertainGraph& graph, const ValueIterationOptions& options,
                    const Budget& budget, std::vector<double>& values, Result& result) {
  const AttemptOutcomes outcomes(graph);
  for (State s = 0; s < graph.num_states(); ++s) {
    if (values[s] != -kInfinity && !is_goal(graph, s)) values[s] = options.initial_value;
  }
  std::vector<double> previous = values;
  std::uint64_t& sweeps = result.statistics.sweeps;
  bool changing = true;
  while (changing && sweeps < options.max_sweeps) {
    std::swap(values, previous);
    double change = 0;
    double largest = 0;
    for (State s = 0; s < graph.num_states(); ++s) {
      values[s] = previous[s];
      if (previous[s] == -kInfinity || is_goal(graph, s)) continue;
      values[s] = best_of(graph, s, previous, [&](const Attempt& attempt) {
                    return outcomes.plain(attempt, previous);
                  }).first;
      change = std::max(change, std::abs(values[s] - previous[s]));
      largest = std::max(largest, std::abs(values[s]));
    }
    ++sweeps;
    // Below the last bits of the values a change says nothing.
    changing =
        change >= options.epsilon && change > 2 * std::numeric_limits<double>::epsilon() * largest;
    budget.report({.phase = "sweep", .done = sweeps, .total = 0, .states = graph.num_states()});
    result.stop = budget.expired(result.statistics.peak_bytes);
    if (result.stop != Stop::None) break;
  }
}

/// The order in which the policy handles the connections where no failure changes the state.
std::vector<ConnectionIndex> sequence_of(const UncertainGraph& graph,
                                         const UncertainSolution& solution) {
  std::vector<ConnectionIndex> sequence;
  for (State s = 0; solution.choice[s] != UncertainSolution::kNone;) {
    const Attempt& attempt = graph.attempts(s)[solution.choice[s]];
    sequence.push_back(attempt.connection);
    s = attempt.done;
  }
  return sequence;
}

}  // namespace

Result uncertain_value_iteration(const UncertainGraph& graph, const ValueIterationOptions& options,
                                 const Budget& budget) {
  const Stopwatch watch;
  require_valid(options);
  Result result;
  result.method = "value-iteration";
  Statistics& statistics = result.statistics;
  statistics.states = graph.num_states();
  statistics.actions = graph.num_attempts();
  statistics.expanded = graph.num_states();
  statistics.generated = graph.num_attempts();
  statistics.peak_bytes = graph.bytes();
  if (graph.stop() != Stop::None) {
    result.stop = graph.stop();
    result.notes.emplace_back("stopped before all states were known that attempts lead to");
    return result;
  }

  UncertainSolution solution = solve_uncertain(graph);
  const bool textbook = options.order == ValueIterationOptions::Order::Textbook;
  const std::size_t numbers = textbook ? 4 : 3;
  statistics.peak_bytes += graph.num_states() * (numbers * sizeof(double) + sizeof(std::uint32_t));
  if (solution.values[0] == -kInfinity) {
    result = detail::exhausted(result.method, statistics);
    result.notes = {
        "no plan exists: whatever is attempted, a state may be met that has no legal step"};
    return result;
  }

  double bound = 0;
  if (textbook) {
    // What the sweeps find stands on its own: the choice is theirs, and is evaluated exactly.
    std::vector<double> values = solution.values;
    sweep_textbook(graph, options, budget, values, result);
    const AttemptOutcomes outcomes(graph);
    for (const State s : graph.last_first()) {
      if (values[s] == -kInfinity || is_goal(graph, s)) continue;
      solution.choice[s] = best_of(graph, s, values, [&](const Attempt& attempt) {
                             return outcomes.plain(attempt, values);
                           }).second;
    }
    evaluate_choice(graph, solution);
    const Accuracy accuracy = accuracy_of(graph, values);
    result.expectation =
        Expectation{solution.attempts[0], accuracy.residual, accuracy.error, {}, 1, {}};
    bound = std::max(values[0] + accuracy.error, solution.values[0]);
  } else {
    statistics.sweeps = 1;
    const Accuracy accuracy = accuracy_of(graph, solution.values);
    result.expectation =
        Expectation{solution.attempts[0], accuracy.residual, accuracy.error, {}, 1, {}};
    bound = solution.values[0];
  }
  result.reward = solution.values[0];
  result.sequence = sequence_of(graph, solution);
  find_most_likely(graph, solution, *result.expectation);
  result.expectation->policy = policy_of(graph, solution);
  detail::judge_by(bound, result);
  if (result.status != Status::Optimal) {
    result.notes.push_back("stopped after " + std::to_string(statistics.sweeps) +
                           " sweeps, before the values were final: the policy is not proved best");
  }
  statistics.seconds = watch.seconds();
  return result;
}

Result uncertain_value_iteration(const TransitionSystem& system,
                                 const ValueIterationOptions& options, const Budget& budget) {
  const Stopwatch watch;
  if (auto result = detail::infeasible_at_once(system, "value-iteration")) return *result;
  Result result = uncertain_value_iteration(UncertainGraph::build(system, budget), options, budget);
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
