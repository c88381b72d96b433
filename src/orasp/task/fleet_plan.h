#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "orasp/model/index.h"
#include "orasp/model/problem.h"

namespace orasp {

/// Place 0 is the depot, place s is site s, in the order of the problem file.
using PlaceIndex = Index<struct PlaceKind>;
inline constexpr PlaceIndex kDepot = 0;

/// How a part moves in a step: 0 stays, d + 1 goes along direction d of kDirectionNames.
using Motion = std::uint8_t;
inline constexpr Motion kStay = 0;
inline constexpr std::size_t kNumMotions = kDirectionNames.size() + 1;
[[nodiscard]] constexpr Motion motion_along(std::size_t direction) {
  return static_cast<Motion>(direction + 1);
}
/// Of a motion that is not kStay.
[[nodiscard]] constexpr std::size_t direction_of(Motion motion) {
  return motion - std::size_t{1};
}
/// "stay", "+x" ... "-z".
[[nodiscard]] constexpr std::string_view motion_name(Motion motion) {
  return motion == kStay ? std::string_view("stay") : kDirectionNames[direction_of(motion)];
}

/// A block that robots hold in a step: one part that leaves for the depot, or a subassembly that
/// moves.
struct FleetMove {
  std::vector<PartIndex> parts;     ///< ascending
  std::vector<std::size_t> robots;  ///< from 1, one for each part, in the order of `parts`
  PlaceIndex from = kDepot;
  PlaceIndex to = kDepot;
  Motion motion = kStay;
  double distance = 0;  ///< m^2: squared distance, summed over the parts

  friend bool operator==(const FleetMove&, const FleetMove&) = default;
};

struct FleetStep {
  std::vector<ConnectionIndex> cut;  ///< ascending
  std::vector<FleetMove> moves;      ///< by their first part
  std::size_t robots_used = 0;
  double distance = 0;  ///< m^2, of all moves

  friend bool operator==(const FleetStep&, const FleetStep&) = default;
};

/// A plan in the order of disassembly.
struct FleetPlan {
  std::vector<PlaceIndex> start;  ///< of each part
  std::vector<FleetStep> steps;

  [[nodiscard]] std::size_t makespan() const { return steps.size(); }
  /// m^2, of all steps.
  [[nodiscard]] double travel() const;
  /// All connections in the order in which they are cut.
  [[nodiscard]] std::vector<ConnectionIndex> sequence() const;

  friend bool operator==(const FleetPlan&, const FleetPlan&) = default;
};

}  // namespace orasp
