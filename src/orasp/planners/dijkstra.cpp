#include "orasp/planners/dijkstra.h"

#include <algorithm>
#include <vector>

#include "orasp/containers/indexed_heap.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

namespace {

/// The most that an action earns for each connection that it handles. A step that ends the plan
/// early counts as handling all that is left: so every path handles as many.
double greatest_by_connection(const StateGraph& graph) {
  double greatest = 0;
  for (StateId s = 0; s < graph.num_states(); ++s) {
    const auto open = static_cast<double>(count(graph.state(s)));
    for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
      const auto left = static_cast<double>(count(graph.state(graph.successor(a))));
      greatest = std::max(greatest, graph.reward(a) / (open - left));
    }
  }
  return greatest;
}

}  // namespace

Result dijkstra(const StateGraph& graph, const Budget& budget) {
  // Dijkstra (1959) with lengths greatest - r >= 0. A state settled is never entered again: lengths
  // are not negative, and the heap would only take it for a strictly smaller length.
  constexpr std::uint64_t kPollEvery = 16'384;
  const Stopwatch watch;
  if (auto result = detail::infeasible_at_once(graph.system(), "dijkstra")) return *result;
  Result result;
  result.method = "dijkstra";
  result.statistics = detail::statistics_of(graph);
  result.statistics.expanded = 0;
  result.statistics.generated = 0;
  const auto states = static_cast<StateId>(graph.num_states());
  const auto goal = graph.goal();
  const bool wide = graph.system().wide();
  const double greatest = wide ? greatest_by_connection(graph) : graph.greatest_reward();

  std::vector<double> length(states, kInfinity);
  std::vector<StateId> parent(states, 0);
  detail::IndexedHeap open(states, length);
  length[0] = 0;
  open.enter_or_decrease(0);
  result.statistics.peak_bytes = std::max<std::uint64_t>(
      graph.peak_bytes(), graph.bytes() + states * (sizeof(double) + 3 * sizeof(StateId)));
  graph.rewards().with_reader([&](auto reward_of) {
    while (!open.empty()) {
      const StateId s = open.top();
      if (goal == s) break;
      open.pop();
      if (++result.statistics.expanded % kPollEvery == 0) {
        budget.report({.phase = "settling",
                       .done = result.statistics.expanded,
                       .total = states,
                       .states = states});
        result.stop = budget.expired(result.statistics.peak_bytes);
        if (result.stop != Stop::None) return;
      }
      const std::size_t before = wide ? count(graph.state(s)) : 0;
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
        ++result.statistics.generated;
        const StateId next = graph.successor(a);
        const double handled = wide ? static_cast<double>(before - count(graph.state(next))) : 1.0;
        const double through = length[s] + std::max(0.0, greatest * handled - reward_of(a));
        if (through < length[next]) {
          length[next] = through;
          parent[next] = s;
          open.enter_or_decrease(next);
        }
      }
    }
  });

  if (result.stop != Stop::None) {
    result =
        detail::stopped_with_quick_plan(graph.system(), "dijkstra", result.stop, result.statistics);
  } else if (!goal) {
    result = detail::exhausted("dijkstra", result.statistics);
  } else {
    if (wide) {
      detail::take_path(graph, parent, result);
      result.status = Status::Optimal;
      result.bound = result.reward;
      result.statistics.seconds = watch.seconds();
      return result;
    }
    result.sequence.resize(graph.system().num_steps());
    result.reward = 0;
    StateId s = *goal;
    for (std::size_t i = result.sequence.size(); i-- > 0; s = parent[s]) {
      ActionId a = graph.begin(parent[s]);
      while (graph.successor(a) != s) ++a;
      result.sequence[i] = graph.connection(a);
      result.reward += graph.reward(a);
    }
    result.status = Status::Optimal;
    result.bound = result.reward;
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

Result dijkstra(const TransitionSystem& system, const Budget& budget) {
  return detail::on_graph(system, budget, "dijkstra",
                          [&](const StateGraph& graph) { return dijkstra(graph, budget); });
}

}  // namespace orasp
