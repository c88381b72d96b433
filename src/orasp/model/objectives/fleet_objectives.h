#pragma once

namespace orasp {

class ObjectiveKind;

/// `makespan`, of a fleet: -1 for every step of the plan, in which all robots may move. No
/// parameters.
struct Makespan {};

/// `fleet_travel`, of a fleet: -(sum over all parts of the squared distance that they move in the
/// step), in square metres. No parameters.
struct FleetTravel {};

[[nodiscard]] const ObjectiveKind& makespan_kind();
[[nodiscard]] const ObjectiveKind& fleet_travel_kind();

}  // namespace orasp
