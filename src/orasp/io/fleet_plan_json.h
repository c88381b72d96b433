#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "orasp/fleet/fleet.h"
#include "orasp/fleet/fleet_result.h"

namespace orasp {

/// A plan of a fleet as a plan file, format `orasp-plan/1` (docs/format.md, section "Fleet plan"):
/// for each step the connections cut, what each robot moves from where to where, and the distance.
/// `options` are the caller's settings that shaped the result, name to value, already JSON texts.
/// Ends with a newline.
[[nodiscard]] std::string fleet_plan_text(const FleetProblem& fleet, const FleetResult& result,
                                          const std::map<std::string, std::string>& options);

/// A plan file of a fleet as read.
struct FleetPlanFile {
  FleetPlan plan;  ///< each part starts where its first move begins
  FleetObjective objective = FleetObjective::Makespan;
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
