#include "orasp/fleet/fleet_search.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "orasp/fleet/fleet_makespan.h"
#include "orasp/fleet/fleet_travel.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

/// States a layer of the widest beam: a few hundredths of a second.
constexpr std::size_t kBeamWidth = 64;

Statistics sum(const Statistics& a, const Statistics& b) {
  Statistics total = a;
  total.expanded += b.expanded;
  total.generated += b.generated;
  total.pruned += b.pruned;
  total.states += b.states;
  return total;
}

Result infeasible(Result result, const std::string& why) {
  result.status = Status::Infeasible;
  result.bound = -kInfinity;
  result.notes.push_back("no plan exists: " + why);
  return result;
}

std::string steps_text(std::size_t steps) {
  return std::to_string(steps) + (steps == 1 ? " step" : " steps");
}

template <class Parts>
Result search(const FleetProblem& fleet, const FleetOptions& options, const Budget& budget) {
  constexpr std::size_t kFirstClusters = FleetMakespanSearch<Parts>::kFirstClusters;
  Result result;
  result.method = "fleet-search";
  FleetExpander<Parts> expander(fleet);
  if (const auto reason = fleet.infeasibility()) return infeasible(std::move(result), *reason);

  FleetMakespanSearch<Parts> makespan(expander, budget);
  FleetTravelSearch<Parts> travel(expander, makespan, budget);
  const auto start = makespan.number_of(expander.start());
  const auto finish = [&](Stop stop) {
    result.stop = result.status == Status::Optimal ? Stop::None : stop;
    result.statistics = sum(makespan.statistics(), travel.statistics());
    result.statistics.peak_bytes = travel.bytes();
    result.statistics.states = travel.num_states();
    return result;
  };
  const auto report = [&] {
    budget.report({.phase = "search",
                   .done = makespan.statistics().expanded + travel.statistics().expanded,
                   .total = 0,
                   .states = travel.num_states(),
                   .best = result.reward});
  };

  // The fewest steps, as far as they matter.
  const bool wants_travel = fleet.objective() == FleetObjective::Travel;
  const std::size_t allowed =
      std::min<std::size_t>(options.steps.value_or(fleet.num_parts()), fleet.num_parts());
  makespan.find_plan(start, kBeamWidth, kFirstClusters);
  if (fleet.robots() > kFirstClusters && makespan.upper(start) > makespan.lower(start))
    makespan.find_plan(start, kBeamWidth, fleet.robots());
  const bool only_whether = wants_travel && options.steps.has_value();
  while (makespan.stop() == Stop::None && makespan.lower(start) <= allowed &&
         makespan.lower(start) < makespan.upper(start) &&
         !(only_whether && makespan.upper(start) <= allowed)) {
    report();
    if (makespan.finishes(start, only_whether ? allowed : makespan.lower(start))) break;
  }
  const std::size_t lower = makespan.lower(start);
  const std::size_t upper = makespan.upper(start);
  if (lower > allowed) {
    const bool none_at_all = lower == FleetMakespanSearch<Parts>::kNoPlan;
    result = infeasible(std::move(result),
                        none_at_all ? "with " + std::to_string(fleet.robots()) + " robots and " +
                                          std::to_string(fleet.num_sites()) +
                                          (fleet.num_sites() == 1 ? " site" : " sites") +
                                          " every order of steps ends where no step can be made"
                                    : "it takes " + steps_text(lower) + " or more, and " +
                                          steps_text(allowed) + " are allowed");
    return finish(Stop::None);
  }
  if (upper > allowed) {
    if (!wants_travel) result.bound = -static_cast<double>(lower);
    return finish(makespan.stop());
  }

  travel.place_known_plan(start);
  result.status = Status::Feasible;
  if (!wants_travel) {
    result.fleet_plan = travel.plan();
    result.reward = 0.0 - static_cast<double>(result.fleet_plan.makespan());
    result.bound = 0.0 - static_cast<double>(lower);
    if (lower == upper) result.status = Status::Optimal;
    return finish(makespan.stop());
  }

  // The least travel in the fewest steps, if they are known, or in those allowed.
  if (!options.steps && lower < upper) {
    result.notes.push_back("the fewest steps are not known: between " + std::to_string(lower) +
                           " and " + std::to_string(upper));
    result.bound = 0.0 - travel.lower();
  } else {
    result.steps_allowed = options.steps.value_or(upper);
    report();
    travel.run(start, *result.steps_allowed);
    result.bound = 0.0 - travel.lower();
  }
  result.fleet_plan = travel.plan();
  result.reward = 0.0 - result.fleet_plan.travel();
  if (result.steps_allowed && travel.stop() == Stop::None) {
    result.status = Status::Optimal;
    result.bound = result.reward;
  }
  return finish(travel.stop());
}

}  // namespace

std::optional<std::string> fleet_search_obstacle(const FleetProblem& fleet,
                                                 const FleetOptions& options) {
  if (fleet.num_parts() > kFleetMaxParts) {
    return "takes at most " + std::to_string(kFleetMaxParts) + " parts; this problem has " +
           std::to_string(fleet.num_parts());
  }
  if (fleet.objective() == FleetObjective::Travel &&
      options.steps.value_or(0) > kFleetMaxTravelSteps) {
    return "finds the least travel in at most " + std::to_string(kFleetMaxTravelSteps) +
           " steps; " + std::to_string(*options.steps) + " are asked for";
  }
  return std::nullopt;
}

Result fleet_search(const FleetProblem& fleet, const FleetOptions& options, const Budget& budget) {
  const Stopwatch watch;
  if (const auto reason = fleet_search_obstacle(fleet, options))
    throw Refusal("fleet-search", *reason);
  const std::size_t parts = fleet.num_parts();
  Result result = parts <= kMostParts<PartsIn<1>>   ? search<PartsIn<1>>(fleet, options, budget)
                  : parts <= kMostParts<PartsIn<2>> ? search<PartsIn<2>>(fleet, options, budget)
                  : parts <= kMostParts<PartsIn<4>> ? search<PartsIn<4>>(fleet, options, budget)
                                                    : search<PartsIn<16>>(fleet, options, budget);
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
