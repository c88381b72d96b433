#pragma once

#include <string>
#include <string_view>

#include "orasp/fleet/fleet.h"

namespace orasp {

/// A plan file of a fleet as read.
struct FleetPlanFile {
  FleetPlan plan;  ///< each part starts where its first move begins
  std::string problem_digest;
};

/// Whether a text is a plan file of a fleet: an object with the key "fleet". Not an error if it is
/// no JSON.
[[nodiscard]] bool is_fleet_plan(std::string_view text);

/// Reads a plan file of a fleet. Only form and names are checked; whether the plan keeps the rules
/// says evaluate() of fleet/fleet_validate.h. @throws InputError: `steps[2].moves[0].parts[1]: no
/// part "77"; parts are "1" to "9"`.
[[nodiscard]] FleetPlanFile parse_fleet_plan(std::string_view text, const FleetProblem& fleet);

}  // namespace orasp
