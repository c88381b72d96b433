#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/problem.h"

namespace orasp::detail {

/// A place of glTF: column by column, the last row left out.
using Transform = std::array<double, 12>;
inline constexpr Transform kIdentity = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};

[[nodiscard]] Transform operator*(const Transform& outer, const Transform& inner);
[[nodiscard]] Vector3 operator*(const Transform& transform, const Vector3& point);

/// A surface as a file has it.
struct RawMesh {
  std::vector<std::array<float, 3>> points;
  std::vector<std::uint32_t> corners;  ///< three a triangle
  std::array<double, 4> colour{};      ///< linear; the last number 0 where the file states none
};

/// A part of the problem in a file: the mesh `mesh` at `place`.
struct PlacedMesh {
  std::size_t mesh = 0;
  Transform place = kIdentity;
};

struct RawShapes {
  std::vector<RawMesh> meshes;      ///< each once, however often it is placed
  std::vector<PlacedMesh> of_part;  ///< in the order of the problem
};

/// Reads a binary glTF file: for each part the node with its id, and all that hangs on it but the
/// other parts. @throws InputError as part_shapes().
[[nodiscard]] RawShapes read_glb(const Problem& problem, std::string_view bytes);

}  // namespace orasp::detail
