#pragma once

#include "orasp/model/vector3.h"

namespace orasp {

class ObjectiveKind;

/// `time`: -(duration + transfer of the moved piece if it separates), in seconds. The transfer is
/// the way from the depot to the centroid of the moved piece and back.
struct TimeObjective {
  Vector3 depot{};
  double speed = 1;     ///< m/s, above 0
  double transfer = 1;  ///< s, used where a part of the moved piece has no position
};

[[nodiscard]] const ObjectiveKind& time_kind();

}  // namespace orasp
