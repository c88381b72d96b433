#pragma once

#include <cmath>

#include "orasp/model/vector3.h"

namespace orasp::detail {

[[nodiscard]] constexpr Vector3 plus(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
[[nodiscard]] constexpr Vector3 minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] constexpr Vector3 times(const Vector3& a, double factor) {
  return {a[0] * factor, a[1] * factor, a[2] * factor};
}
[[nodiscard]] constexpr double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
[[nodiscard]] constexpr Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] inline double length(const Vector3& a) {
  return std::sqrt(dot(a, a));
}

/// Of length 1; a vector without a direction stays 0.
[[nodiscard]] inline Vector3 normalized(const Vector3& a) {
  const double size = length(a);
  return size > 0 && std::isfinite(size) ? times(a, 1 / size) : Vector3{};
}

/// The same; a vector without a direction becomes +z, so that a surface always faces somewhere.
[[nodiscard]] inline Vector3 facing(const Vector3& a) {
  const double size = length(a);
  if (!(size > 0)) return {0, 0, 1};
  return {a[0] / size, a[1] / size, a[2] / size};
}

}  // namespace orasp::detail
