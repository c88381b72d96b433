#pragma once

#include <optional>

#include "orasp/model/vector3.h"

namespace orasp {

class ObjectiveKind;

/// `route`: minus `per_metre` times the distance from the place of the step before to that of this
/// step. The first step comes from `start`, and is free without it. Every connection must have a
/// place.
struct Route {
  std::optional<Vector3> start{};
  double per_metre = 1;
};

[[nodiscard]] const ObjectiveKind& route_kind();

}  // namespace orasp
