#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

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

/// Three directions at right angles, right-handed: lines of sight run along `w`.
struct Frame {
  Vector3 u, v, w;

  [[nodiscard]] constexpr Vector3 turned(const Vector3& p) const {
    return {dot(u, p), dot(v, p), dot(w, p)};
  }
};

/// A frame that looks along `direction`, of length 1. Along an axis its vectors are axes, so that
/// turning rounds nothing.
[[nodiscard]] inline Frame frame_along(const Vector3& direction) {
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(direction[i]) > std::abs(direction[largest])) largest = i;
  }
  const std::size_t next = (largest + 1) % 3;
  Frame frame;
  if (std::abs(direction[next]) < 1e-12 && std::abs(direction[(next + 1) % 3]) < 1e-12) {
    const double sign = direction[largest] < 0 ? -1 : 1;
    frame.w = frame.u = frame.v = {};
    frame.w[largest] = sign;
    frame.u[next] = sign;
    frame.v[(next + 1) % 3] = 1;
    return frame;
  }
  Vector3 side{};
  std::size_t smallest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(direction[i]) < std::abs(direction[smallest])) smallest = i;
  }
  side[smallest] = 1;
  frame.w = normalized(direction);
  frame.u = normalized(cross(side, frame.w));
  frame.v = cross(frame.w, frame.u);
  return frame;
}

}  // namespace orasp::detail
