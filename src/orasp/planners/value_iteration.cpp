#include "orasp/planners/value_iteration.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "orasp/containers/parallel.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/dense_value_iteration.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

namespace {
constexpr std::size_t kParallelFrom = 4096;  // states worth a second thread

/// V_{k+1}(s) for the states first .. last - 1, written to `to`; returns the greatest change
/// against `from`.
template <class RewardOf>
double bellman_update(const StateGraph& graph, RewardOf reward_of, StateId first, StateId last,
                      const std::vector<double>& from, std::vector<double>& to) {
  double change = 0;
  ActionId a = graph.begin(first);
  for (StateId s = first; s < last; ++s) {
    double best = -kInfinity;
    for (const ActionId end = graph.end(s); a < end; ++a) {
      best = std::max(best, reward_of(a) + from[graph.successor(a)]);
    }
    if (best != from[s]) change = std::max(change, std::abs(best - from[s]));
    to[s] = best;
  }
  return change;
}

/// One parallel update of a range of states.
double update_range(const StateGraph& graph, StateId begin, StateId end,
                    const std::vector<double>& from, std::vector<double>& to, std::size_t threads) {
  const std::size_t size = end - begin;
  if (size < kParallelFrom) threads = 1;
  std::vector<double> changes(threads, 0.0);
  graph.rewards().with_reader([&](auto reward_of) {
    detail::run_parallel(threads, [&](std::size_t t) {
      const auto [first, last] = detail::share_of(size, threads, t);
      if (first == last) return;
      changes[t] = bellman_update(graph, reward_of, static_cast<StateId>(begin + first),
                                  static_cast<StateId>(begin + last), from, to);
    });
  });
  return *std::ranges::max_element(changes);
}

/// Follows the greedy policy of V from the start; false if it ends before the goal.
bool roll_out(const StateGraph& graph, const std::vector<double>& values, Result& result) {
  result.sequence.clear();
  result.reward = 0;
  StateId s = 0;
  std::vector<StateId> path{s};
  while (graph.begin(s) < graph.end(s)) {
    ActionId best = graph.begin(s);
    for (ActionId a = best + 1; a < graph.end(s); ++a) {
      if (graph.reward(a) + values[graph.successor(a)] >
          graph.reward(best) + values[graph.successor(best)])
        best = a;
    }
    result.sequence.push_back(graph.connection(best));
    result.reward += graph.reward(best);
    s = graph.successor(best);
    path.push_back(s);
  }
  if (graph.system().wide()) detail::take_walk(graph.steps_along(path), result);
  return graph.goal() == s;
}

}  // namespace

Result value_iteration(const StateGraph& graph, const ValueIterationOptions& options,
                       const Budget& budget) {
  // The paper's Algorithm 1. In layer order every successor is final before it is read, so updating
  // in place makes the first sweep exact; the second finds no change and ends. The textbook order
  // reads V_k throughout.
  const Stopwatch watch;
  if (auto result = detail::infeasible_at_once(graph.system(), "value-iteration")) return *result;
  Result result;
  result.method = "value-iteration";
  result.statistics = detail::statistics_of(graph);
  const auto states = static_cast<StateId>(graph.num_states());
  const auto goal = graph.goal();
  const bool layered = options.order == ValueIterationOptions::Order::Layers;
  const std::size_t threads = std::max(1U, budget.threads);

  std::vector<double> values(states, options.initial_value);
  if (goal) values[*goal] = 0;
  std::vector<double> previous;
  if (!layered) previous = values;
  result.statistics.peak_bytes = std::max<std::uint64_t>(
      graph.peak_bytes(), graph.bytes() + (values.size() + previous.size()) * sizeof(double));

  double change = kInfinity;
  std::uint64_t& sweeps = result.statistics.sweeps;
  while (change >= options.epsilon && change != 0 && sweeps < options.max_sweeps) {
    double greatest = 0;
    const StateId last = goal ? *goal : states;  // the goal keeps its value
    if (layered) {
      for (std::size_t layer = graph.num_layers(); layer-- > 0;) {
        const StateId begin = graph.layer_begin(layer);
        const StateId end = std::min(graph.layer_end(layer), last);
        if (begin < end)
          greatest = std::max(greatest, update_range(graph, begin, end, values, values, threads));
      }
    } else {
      std::swap(values, previous);
      greatest = update_range(graph, 0, last, previous, values, threads);
    }
    change = greatest;
    ++sweeps;
    budget.report({.phase = "sweep", .done = sweeps, .total = 0, .states = states});
    result.stop = budget.expired(result.statistics.peak_bytes);
    if (result.stop != Stop::None) break;
  }

  // Exact after one sweep in layer order, after as many as there are layers in textbook order, or
  // when nothing changed (on an acyclic graph Bellman's equation has one solution).
  const bool exact = change == 0 || (layered ? sweeps >= 1 : sweeps + 1 >= graph.num_layers());
  if (exact) result.stop = Stop::None;
  if (exact && (!goal || values[0] == -kInfinity)) {
    const Stop none = Stop::None;
    result = detail::exhausted("value-iteration", result.statistics);
    result.stop = none;
  } else if (!roll_out(graph, values, result)) {
    result = detail::stopped_with_quick_plan(graph.system(), "value-iteration", result.stop,
                                             result.statistics);
    result.notes.emplace_back("the values were not final: the greedy policy ends in a dead end");
  } else if (exact) {
    result.status = Status::Optimal;
    result.bound = result.reward;
  } else {
    result.status = Status::Feasible;
    result.notes.push_back("stopped after " + std::to_string(sweeps) +
                           " sweeps, before the values were final: the plan is not proved");
  }
  result.values = std::move(values);
  result.statistics.seconds = watch.seconds();
  return result;
}

void require_valid(const ValueIterationOptions& options) {
  if (!std::isfinite(options.initial_value))
    throw InputError("value-iteration: the initial value must be finite");
  if (!(options.epsilon >= 0)) throw InputError("value-iteration: epsilon must be 0 or more");
}

std::optional<std::string> value_iteration_obstacle(const TransitionSystem& system,
                                                    const ValueIterationOptions& options,
                                                    const Budget& budget) {
  const bool dense = options == ValueIterationOptions{} && dense_values_safe(system);
  if (dense && dense_table_fits(system, budget)) return std::nullopt;
  return graph_obstacle(system, budget, dense ? dense_table_bytes(system, budget) : 0);
}

Result value_iteration(const TransitionSystem& system, const ValueIterationOptions& options,
                       const Budget& budget) {
  require_valid(options);
  const bool dense = options == ValueIterationOptions{} && dense_values_safe(system);
  const bool dense_fits = dense && dense_table_fits(system, budget);
  if (dense_fits && (unconstrained(system) || !graph_fits(system, budget)))
    return dense_value_iteration(system, {}, budget);
  Result result = detail::on_graph(
      system, budget, "value-iteration",
      [&](const StateGraph& graph) { return value_iteration(graph, options, budget); },
      dense ? dense_table_bytes(system, budget) : 0);
  // The estimate was too low.
  if (result.stop == Stop::MemoryLimit && dense_fits)
    return dense_value_iteration(system, {}, budget);
  return result;
}

}  // namespace orasp
