#pragma once

#include "orasp/model/vector3.h"

namespace orasp {

class ObjectiveKind;

/// `travel`: -(parts in the moved piece) * squared distance of its centroid to the depot, if it
/// separates. Every part must have a position.
struct Travel {
  Vector3 depot{};
};

[[nodiscard]] const ObjectiveKind& travel_kind();

}  // namespace orasp
