#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "orasp/model/problem.h"

namespace orasp {

/// The most triangles that a file of shapes may draw, each part that repeats a mesh counted.
inline constexpr std::size_t kMaxShapeTriangles = 20'000'000;
/// What is left of them for a page: any graphics card draws that 30 times a second, and without one
/// a core still does in a third of a second.
inline constexpr std::size_t kMaxPageTriangles = 120'000;
/// The largest file of shapes in a page. With the page around it, it stays below 10 MB.
inline constexpr std::size_t kMaxPageShapeBytes = std::size_t{5} << 20U;

/// The shapes of all parts, small enough for a page.
struct PartShapes {
  /// A binary glTF file with a node for each part, in the order of the problem: `extras.part` is
  /// its number. Its mesh has triangles and, for drawings, the edges at which the surface bends.
  /// Equal parts share a mesh where they did in the file that was read.
  std::string glb;
  std::size_t triangles = 0;       ///< that are drawn
  std::size_t triangles_read = 0;  ///< that the file would draw
};

/// Reads a binary glTF file (docs/format.md, "Geometry") and simplifies it (Garland and Heckbert's
/// quadrics, by meshoptimizer): first as far as nobody sees, then, if that is more than
/// kMaxPageTriangles, each mesh in proportion. The same file gives the same bytes. A file in which
/// y is up is turned, if the positions of the parts say so.
/// @throws InputError with one clause that follows the name of the file: "it is cut off after 20 of
///         its 5,012 bytes", "no node has the id of part \"lid\"".
[[nodiscard]] PartShapes part_shapes(const Problem& problem, std::string_view glb);

}  // namespace orasp
