#pragma once

#include <string>

#include "cli/context.h"
#include "orasp/fleet/fleet.h"

namespace orasp::cli {

/// The moves of a plan of several robots, one a line, with the connections that each step cuts.
[[nodiscard]] std::string fleet_table(const Problem& problem, const FleetPlan& plan,
                                      const Context& context);

}  // namespace orasp::cli
