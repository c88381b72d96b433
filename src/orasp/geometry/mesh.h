#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "orasp/model/vector3.h"

namespace orasp {

/// A surface of triangles, as drawn: it may be open, and may cross itself. Lengths in millimetres.
struct Mesh {
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise from outside

  [[nodiscard]] bool empty() const { return triangles.empty(); }
};

/// A box along the axes; empty where low > high.
struct Box {
  Vector3 low{1e300, 1e300, 1e300};
  Vector3 high{-1e300, -1e300, -1e300};

  void add(const Vector3& point);
  [[nodiscard]] double diagonal() const;  ///< 0 where empty
};

/// What a mesh measures, by the divergence theorem. O(triangles).
struct MeshMeasure {
  Box box;
  double area = 0.0;        ///< mm^2
  double volume = 0.0;      ///< mm^3; of an open mesh a rough value
  Vector3 centroid{};       ///< of the volume; of an open mesh that of its surface
  bool inside_out = false;  ///< its triangles are clockwise from outside, all in all
  bool closed = false;      ///< every edge has as many triangles on one side as on the other
};

[[nodiscard]] MeshMeasure measure(const Mesh& mesh);

}  // namespace orasp
