#pragma once

namespace orasp {

class ObjectiveKind;

/// `fuel`: propellant in kg of a low-thrust tug that flies out empty and back with the moved piece.
struct Fuel {
  double dry_mass = 6;  ///< kg
  double delta_v = 30;  ///< m/s
  double isp = 200;     ///< s, above 0
};

[[nodiscard]] const ObjectiveKind& fuel_kind();

}  // namespace orasp
