#pragma once

#include <cmath>
#include <limits>

namespace orasp::detail {

/// Sums and products that are never below the true ones: the nearest double, and one step up. One
/// step is more than half a unit in the last place, which is what rounding to nearest may take
/// away. An infinity stays what it is.
[[nodiscard]] inline double up(double value) {
  return std::isinf(value) ? value : std::nextafter(value, std::numeric_limits<double>::infinity());
}
[[nodiscard]] inline double add_up(double a, double b) {
  return up(a + b);
}
[[nodiscard]] inline double multiply_up(double a, double b) {
  return a == 0 || b == 0 ? 0.0 : up(a * b);
}

}  // namespace orasp::detail
