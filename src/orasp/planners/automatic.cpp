#include "orasp/planners/automatic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "orasp/planners/bounds.h"
#include "orasp/planners/detail/planner_support.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/orasp_search.h"
#include "orasp/planners/state_graph.h"
#include "orasp/planners/value_iteration.h"

namespace orasp {

namespace {

/// Expansions for a look at whether a plan meets the bound; a few milliseconds.
constexpr std::uint64_t kFirstLook = 5000;

/// Whether H is small enough to build, looked at as cheaply as possible.
bool worth_building(const TransitionSystem& system, const Budget& budget) {
  const auto allowed = static_cast<double>(allowed_bytes(budget));
  const GraphEstimate most = estimate_without_constraints(system);
  if (most.actions <= kAutomaticMostActions && most.bytes <= allowed) return true;
  const GraphEstimate estimate = estimate_graph(system);
  return estimate.actions <= kAutomaticMostActions && estimate.bytes <= allowed;
}

}  // namespace

Result automatic(const TransitionSystem& system, std::uint64_t seed, const Budget& budget) {
  const Stopwatch watch;
  if (auto result = detail::settled(system, "auto")) return *result;
  const auto answer = [&](Result result, const std::string& how) {
    result.notes.insert(result.notes.begin(), "auto: " + how);
    result.statistics.seconds = watch.seconds();
    return result;
  };
  const ConnectionSet start = system.start();

  std::optional<Result> incumbent;
  double most = std::numeric_limits<double>::infinity();  // upper bound on any plan
  const auto proved = [&] { return incumbent && incumbent->reward >= most - kRewardTolerance; };
  const auto as_proved = [&] {
    incumbent->method = "auto";
    incumbent->status = Status::Optimal;
    incumbent->stop = Stop::None;
    incumbent->bound = incumbent->reward;
    return *incumbent;
  };

  PieceBound sizes(system, PieceBound::Kind::Both);
  if (sizes.known()) {
    most = sizes(start.view());
    Budget first = budget;
    first.max_expansions =
        std::min(budget.max_expansions, kFirstLook + 4 * system.num_connections());
    Result found = plan_at_bound(system, sizes, first);
    if (!found.has_plan()) found = guided_greedy(system, sizes, first);
    if (found.has_plan()) incumbent = std::move(found);
    if (proved())
      return answer(as_proved(), "the plan earns as much as the bound over piece sizes allows");
  }
  if (worth_building(system, budget)) {
    return answer(value_iteration(system, {}, budget),
                  "value-iteration, since the state-action graph is small");
  }
  if (!incumbent) {
    Result plain = greedy(system, budget);
    if (plain.status == Status::Infeasible || !plain.has_plan())
      return answer(std::move(plain), "greedy");
    incumbent = std::move(plain);
  }
  ConnectionBound connections(system);
  most = std::min(most, connections(start.view()));
  if (proved()) return answer(as_proved(), "the plan earns as much as its connections can at best");
  if (!connections.known()) {
    if (std::isfinite(most)) incumbent->bound = most;
    return answer(std::move(*incumbent),
                  "greedy, since the state-action graph is too large and no bound is known for "
                  "this objective");
  }
  Result search = orasp_search(system, {.seed = seed, .incumbent = &*incumbent}, budget);
  search.bound = std::min(search.bound.value_or(most), most);
  if (search.has_plan() && search.reward >= *search.bound - kRewardTolerance) {
    search.status = Status::Optimal;
    search.stop = Stop::None;  // the bound proves it, however the search ended
    search.bound = search.reward;
  }
  return answer(
      std::move(search),
      "orasp-search from a greedy plan, since the state-action graph is too large to build");
}

}  // namespace orasp
