#include "orasp/planners/automatic.h"

#include <cmath>

#include "orasp/planners/bounds.h"
#include "orasp/planners/detail/planner_support.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/orasp_search.h"
#include "orasp/planners/state_graph.h"
#include "orasp/planners/value_iteration.h"

namespace orasp {

Result automatic(const TransitionSystem& system, std::uint64_t seed, const Budget& budget) {
  const Stopwatch watch;
  if (auto result = detail::settled(system, "auto")) return *result;

  const auto chosen = [&](Result result, const std::string& why) {
    result.notes.insert(result.notes.begin(), "auto chose " + result.method + ": " + why);
    result.statistics.seconds = watch.seconds();
    return result;
  };
  // Constraints only take states away, so 2^connections is tried before anything is estimated.
  const double connections = static_cast<double>(system.num_connections());
  const auto allowed = static_cast<double>(allowed_bytes(budget));
  const bool surely_small = std::exp2(connections) * connections / 2 <= kAutomaticMostActions / 10;
  if (!surely_small) {
    const GraphEstimate estimate = estimate_graph(system);
    if (estimate.actions > kAutomaticMostActions || estimate.bytes > allowed) {
      Result first = greedy(system, budget);
      const ConnectionBound bound(system);
      if (!first.has_plan() || !bound.known()) {
        return chosen(
            std::move(first),
            "the state-action graph is too large, and no bound is known for this objective");
      }
      const double most = bound(system.start().view());
      if (first.reward >= most - kRewardTolerance) {
        first.status = Status::Optimal;
        first.bound = first.reward;
        return chosen(std::move(first), "its plan earns as much as the upper bound on any plan");
      }
      Result search = orasp_search(system, {.seed = seed}, budget);
      if (search.has_plan() && search.reward >= first.reward) {
        return chosen(std::move(search), "the state-action graph is too large to build");
      }
      first.bound = search.bound ? search.bound : most;
      first.stop = search.stop;
      return chosen(std::move(first), "orasp-search found nothing better before it was stopped");
    }
  }
  return chosen(value_iteration(system, {}, budget),
                "the state-action graph is small enough to build");
}

}  // namespace orasp
