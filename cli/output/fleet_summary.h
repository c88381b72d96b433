#pragma once

#include <optional>
#include <string>

#include "cli/options/problem_source.h"
#include "orasp/fleet/fleet.h"
#include "orasp/fleet/fleet_result.h"
#include "orasp/fleet/fleet_validate.h"

namespace orasp::cli {

/// The objective of fleets of that name; empty: it is none.
[[nodiscard]] std::optional<FleetObjective> fleet_objective_called(const std::string& name);

/// Whether `planner` plans for the robots of `problem` here: it knows nothing else, or it is asked
/// for no objective of one robot and the problem has a fleet. `objective` is what the user asked
/// for. @throws InputError where planner and objective do not fit.
[[nodiscard]] bool plans_for_fleet(const Planner& planner, const Problem& problem,
                                   const std::optional<std::string>& objective);

/// Says that a method for one robot leaves the fleet of `problem` alone, if it has one.
void warn_of_unused_fleet(const Problem& problem, const Context& context);

/// Checks a plan by the rules. @throws std::logic_error if the method broke one.
void require_valid(const FleetProblem& fleet, const FleetResult& result);

/// The exit code of a result.
[[nodiscard]] int exit_code(const FleetResult& result);

/// A result for people: method, status, makespan, travel, bound, gap, effort, and where there is a
/// plan its moves. `typed` is what the user called the problem.
[[nodiscard]] std::string fleet_summary(const FleetProblem& fleet, const std::string& typed,
                                        const FleetResult& result, const Context& context);

/// The moves of a plan, one a line, with the connections that each step cuts.
[[nodiscard]] std::string fleet_table(const FleetProblem& fleet, const FleetPlan& plan,
                                      const Context& context);

}  // namespace orasp::cli
