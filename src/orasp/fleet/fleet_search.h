#pragma once

#include <optional>
#include <string>

#include "orasp/fleet/fleet.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Why fleet_search() does not take the problem: it is above one of the limits below. Empty where
/// it takes it.
[[nodiscard]] std::optional<std::string> fleet_search_obstacle(const FleetProblem& fleet,
                                                               const FleetOptions& options);

/// Plans for several robots in synchronous steps: the fewest steps, or the least travel within
/// given steps.
///
/// Problem.    FleetProblem. Objective makespan: the fewest steps (with FleetOptions::steps: at
///             most so many). Objective travel: the least travel in at most FleetOptions::steps
///             steps, by default in the fewest possible.
/// Idea.       First a plan by beam search, then FleetMakespanSearch (iterative deepening over sets
///             of subassemblies), then FleetTravelSearch (branch and bound over sets of placed
///             subassemblies). A plan of the fewest steps is placed on the sites so that it travels
///             little, which is no part of its proof.
/// Guarantee.  Exact: Optimal and Infeasible only with proof. Stopped, it returns the best plan so
///             far and the bound proved so far.
/// Cost.       Exponential; docs/performance.md, section "Fleets", has figures. Hubble with 4
///             robots: 0.01 s.
/// Limit.      kFleetMaxParts parts; 255 sites; the least travel in at most kFleetMaxTravelSteps
///             steps.
/// Repeatable. The same plan on every machine, unless a limit of time stops it. No randomness.
/// @throws Refusal above these limits.
[[nodiscard]] Result fleet_search(const FleetProblem& fleet, const FleetOptions& options,
                                  const Budget& budget);

}  // namespace orasp
