#pragma once

#include <cmath>
#include <cstddef>

#include "orasp/model/detail/vector_math.h"

namespace orasp::detail {

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
