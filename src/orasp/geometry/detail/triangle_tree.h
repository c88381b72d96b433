#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "orasp/geometry/mesh.h"
#include "orasp/model/detail/vector_math.h"

namespace orasp::detail {

/// The three corners of a triangle.
using Corners = std::array<Vector3, 3>;

/// A hierarchy of boxes over the triangles of a mesh. The triangles are sorted along a Z-curve
/// through the centres of their boxes (Lauterbach and others, "Fast BVH construction on GPUs",
/// 2009) and cut into 2^k leaves of nearly equal size; node i has the children 2i and 2i + 1, so
/// that no pointer is stored. O(n log n) to build, one box per two triangles.
class TriangleTree {
 public:
  TriangleTree() = default;
  explicit TriangleTree(const Mesh& mesh);

  [[nodiscard]] bool empty() const { return triangles_.empty(); }
  [[nodiscard]] std::size_t leaves() const { return leaves_; }                   ///< a power of 2
  [[nodiscard]] const Box& box(std::size_t node) const { return boxes_[node]; }  ///< root: 1
  [[nodiscard]] bool is_leaf(std::size_t node) const { return node >= leaves_; }
  /// The triangles of a leaf, as a range of positions.
  [[nodiscard]] std::size_t begin(std::size_t leaf) const { return bound(leaf - leaves_); }
  [[nodiscard]] std::size_t end(std::size_t leaf) const { return bound(leaf - leaves_ + 1); }
  [[nodiscard]] const std::array<std::uint32_t, 3>& triangle(std::size_t position) const {
    return triangles_[position];
  }
  [[nodiscard]] Corners corners(std::size_t position) const {
    const auto& t = triangles_[position];
    return {(*vertices_)[t[0]], (*vertices_)[t[1]], (*vertices_)[t[2]]};
  }
  [[nodiscard]] const std::vector<Vector3>& vertices() const { return *vertices_; }
  [[nodiscard]] std::size_t size() const { return triangles_.size(); }

 private:
  [[nodiscard]] std::size_t bound(std::size_t leaf) const {
    return leaf * triangles_.size() / leaves_;
  }

  const std::vector<Vector3>* vertices_ = nullptr;  // of the mesh, which must stay
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<Box> boxes_;
  std::size_t leaves_ = 0;
};

/// The square of the distance of two boxes.
[[nodiscard]] double squared_distance(const Box& a, const Box& b);

/// The square of the distance of two triangles; 0 where they meet.
[[nodiscard]] double squared_distance(const Corners& a, const Corners& b);

/// The distance of two meshes where it is less than `limit`, and `limit` otherwise. What is nearer
/// than `nothing` counts as 0 and ends the search. A mesh inside of another is as far away as its
/// surface is.
[[nodiscard]] double distance_within(const TriangleTree& a, const TriangleTree& b, double limit,
                                     double nothing);

/// The distance of a point from the surface, where it is more than `least`; `least` or less
/// otherwise, as soon as that is known.
[[nodiscard]] double distance_above(const TriangleTree& tree, const Vector3& point, double least);

/// Whether a point lies inside of a closed mesh: how often a ray meets its surface.
[[nodiscard]] bool contains(const TriangleTree& tree, const Vector3& point);

}  // namespace orasp::detail
