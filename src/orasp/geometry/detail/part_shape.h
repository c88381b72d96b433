#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "orasp/geometry/contacts.h"
#include "orasp/geometry/detail/triangle_tree.h"

namespace orasp::detail {

/// What the searches need of a part, worked out once.
struct PartShape {
  TriangleTree tree;
  double volume = 0.0;  ///< mm^3; 0 where the mesh is open
  bool closed = false;
  bool inside_out = false;  ///< closed, but its triangles are clockwise from outside
};

/// The shapes of all parts. Throws Interrupted.
[[nodiscard]] std::vector<PartShape> part_shapes(std::span<const CadPart> parts,
                                                 const GeometrySettings& settings);

}  // namespace orasp::detail
