#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/fleet/fleet.h"

namespace orasp {

/// A rule of fleets, as violations name it (docs/format.md, section "Fleet problems").
enum class FleetRule {
  Cut,      ///< a connection is cut once, by motions that pull it apart
  Motions,  ///< parts that stay together move alike; a part that stays keeps its site
  Robots,   ///< one robot for each part that moves or leaves
  Places,   ///< each subassembly has a site of its own, single parts are in the depot
  Precedence,
  Blocking,
  MaxSubassemblies,
  MaxMovedParts,
  MaxMovedMass,
  Distance,  ///< the distance stated for a move is the one it covers
  End,       ///< at the end every connection is cut
};

/// "cut", "motion", ... "max_subassemblies": as in files.
[[nodiscard]] std::string_view rule_name(FleetRule rule);

struct FleetViolation {
  std::size_t step;  ///< from 1; 0: the start
  FleetRule rule;
  std::string connection;  ///< its id, where the violation is about one
  std::string message;     ///< a sentence
};

/// A plan replayed.
struct FleetEvaluation {
  bool valid = false;
  std::size_t makespan = 0;
  double travel = 0;  ///< m^2, worked out from the places
  std::vector<FleetViolation> violations;
};

/// Replays a plan and reports everything that is wrong with it. Follows the rules as docs/format.md
/// states them, part by part; shares nothing with fleet_step and FleetExpander, which planners use.
[[nodiscard]] FleetEvaluation evaluate(const FleetProblem& fleet, const FleetPlan& plan);

}  // namespace orasp
