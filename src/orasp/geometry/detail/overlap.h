#pragma once

#include <optional>

#include "orasp/geometry/detail/part_shape.h"

namespace orasp::detail {

/// An overlap, and whether it runs round a hole, as that of a pin in a bore too narrow for it.
struct FoundOverlap {
  MeshOverlap overlap;
  bool ring = false;
};

/// What two closed parts both cover, where it is thicker than the tolerance: thinner overlaps come
/// of round faces drawn of different triangles. Interval maps along the three axes: on each line of
/// a raster the stretches inside of both. The volume is that of the axis from which most of it is
/// seen; the thickness is twice the greatest distance of the middles of those stretches from either
/// surface. Precise to about a hundredth of the size of the overlap, not more.
[[nodiscard]] std::optional<FoundOverlap> find_overlap(const PartShape& a, const PartShape& b,
                                                       double tolerance);

}  // namespace orasp::detail
