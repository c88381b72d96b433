#include "orasp/planners/bellman_ford.h"

#include <algorithm>
#include <vector>

#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

Result bellman_ford(const StateGraph& graph, const BellmanFordOptions& options,
                    const Budget& budget) {
  // Relaxation in rounds (Bellman, Ford, Moore). States are numbered layer by layer, so a state's
  // value is final before its own actions are relaxed: the first sweep settles all, the second
  // confirms it.
  const Stopwatch watch;
  if (auto result = detail::infeasible_at_once(graph.system(), "bellman-ford")) return *result;
  Result result;
  result.method = "bellman-ford";
  result.statistics = detail::statistics_of(graph);
  const auto states = static_cast<StateId>(graph.num_states());

  std::vector<double> best(states, -kInfinity);
  std::vector<StateId> parent(states, 0);
  best[0] = 0;
  result.statistics.peak_bytes = std::max<std::uint64_t>(
      graph.peak_bytes(), graph.bytes() + states * (sizeof(double) + sizeof(StateId)));
  bool changed = true;
  while (changed && result.stop == Stop::None) {
    changed = false;
    graph.rewards().with_reader([&](auto reward_of) {
      ActionId a = 0;
      for (StateId s = 0; s < states; ++s) {
        const double here = best[s];
        for (const ActionId end = graph.end(s); a < end; ++a) {
          const StateId next = graph.successor(a);
          const double there = here + reward_of(a);
          if (there > best[next]) {
            best[next] = there;
            parent[next] = s;
            changed = true;
          }
        }
      }
    });
    ++result.statistics.sweeps;
    budget.report(
        {.phase = "sweep", .done = result.statistics.sweeps, .total = 2, .states = states});
    // The values are final now; only the confirmation can be cut short.
    if (changed) result.stop = budget.expired(result.statistics.peak_bytes);
  }
  result.stop = Stop::None;

  const auto goal = graph.goal();
  if (!goal) {
    result = detail::exhausted("bellman-ford", result.statistics);
  } else if (graph.system().wide()) {
    detail::take_path(graph, parent, result);
    result.status = Status::Optimal;
    result.bound = result.reward;
  } else {
    result.sequence.resize(graph.system().num_steps());
    StateId s = *goal;
    for (std::size_t i = result.sequence.size(); i-- > 0;) {
      ActionId a = graph.begin(parent[s]);
      while (graph.successor(a) != s) ++a;
      result.sequence[i] = graph.connection(a);
      s = parent[s];
    }
    result.status = Status::Optimal;
    result.reward = best[*goal];
    result.bound = result.reward;
  }
  if (options.keep_values) {
    result.notes.push_back("the best reward from the start is known for each of " +
                           std::to_string(states) + " states");
    result.values = std::move(best);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

Result bellman_ford(const TransitionSystem& system, const BellmanFordOptions& options,
                    const Budget& budget) {
  return detail::on_graph(system, budget, "bellman-ford", [&](const StateGraph& graph) {
    return bellman_ford(graph, options, budget);
  });
}

}  // namespace orasp
