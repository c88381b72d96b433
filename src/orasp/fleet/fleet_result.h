#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/fleet/fleet.h"
#include "orasp/model/tolerance.h"
#include "orasp/task/result.h"

namespace orasp {

/// What a fleet plan is to be good at.
enum class FleetObjective {
  Makespan,  ///< the fewest steps
  Travel,    ///< the least travel: over all parts and steps the squared distance, in m^2
};

[[nodiscard]] constexpr std::string_view objective_name(FleetObjective objective) {
  return objective == FleetObjective::Makespan ? "makespan" : "travel";
}

/// What every method for fleets is asked.
struct FleetOptions {
  FleetObjective objective = FleetObjective::Makespan;
  /// At most so many steps. Empty: makespan as many as it takes, travel the fewest possible.
  std::optional<std::size_t> steps;
  std::uint64_t seed = 1;
};

/// What a method for fleets answers. A value; the caller owns it.
struct FleetResult {
  std::string method;
  FleetObjective objective = FleetObjective::Makespan;
  Status status = Status::Unknown;
  Stop stop = Stop::None;
  FleetPlan plan;  ///< where has_plan()
  /// Minus the number of steps, or minus the travel; more is better, as for one robot.
  double reward = -kInfinity;
  std::optional<double> bound;               ///< proved upper bound on any plan's reward
  std::optional<std::size_t> steps_allowed;  ///< horizon that travel was minimised for
  Statistics statistics;
  std::uint64_t seed = 1;
  std::vector<std::string> notes;

  [[nodiscard]] bool has_plan() const {
    return status == Status::Optimal || status == Status::Feasible;
  }
};

}  // namespace orasp
