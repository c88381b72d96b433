#pragma once

#include <vector>

#include "orasp/geometry/detail/part_shape.h"

namespace orasp::detail {

/// A place where two parts lie on one another.
struct ContactPatch {
  Vector3 normal{};   ///< of length 1, out of the second part and into the first
  double area = 0.0;  ///< mm^2
  double gap = 0.0;   ///< mm, in the middle of the patch; negative where they overlap
};

/// Where faces of two parts look at one another within the tolerance: each pair of triangles that
/// face each other is laid onto the plane between the two, cut by one another and by the tolerance.
/// Exact for plane faces; for curved ones as good as their triangles. Costs as much as there are
/// such pairs of triangles. In the order of the trees.
[[nodiscard]] std::vector<ContactPatch> contact_patches(const PartShape& a, const PartShape& b,
                                                        double tolerance);

/// The patches whose normals differ by less than an angle (its cosine is given), as one each with
/// the normal of its largest, those of most area first. Normals that round to the same thousandths
/// are brought together by sorting, for a thread has thousands. O(n log n).
[[nodiscard]] std::vector<ContactPatch> gathered_by_normal(std::vector<ContactPatch> patches,
                                                           double cosine);

/// Whether patches hold the first part from all sides of an axis, as a hole holds its peg: normals
/// across the axis that leave no half-plane free. Takes patches gathered by normal.
[[nodiscard]] bool held_all_round(const std::vector<ContactPatch>& patches);

}  // namespace orasp::detail
