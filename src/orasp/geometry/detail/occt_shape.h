#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <TopoDS_Shape.hxx>
#include <gp_Trsf.hxx>

#include "orasp/geometry/cad_model.h"

/// What the module with OpenCASCADE makes of one shape. Not part of the library.
namespace orasp::detail {

/// A shape in its own frame, in the kernel's millimetres.
struct OcctShape {
  std::size_t key = 0;  ///< a number of its own, from 1; 0 where nothing is done yet
  Mesh mesh;
  std::vector<FaceHint> faces;
  std::size_t failed_faces = 0;  ///< that could not be meshed
  std::optional<double> volume;  ///< of what its shells enclose
  std::optional<Vector3> centroid;
};

/// Triangles and hints of all faces. Nodes at one place become one, so that the mesh of a closed
/// shell is closed.
[[nodiscard]] OcctShape meshed(const TopoDS_Shape& shape, double deflection, bool parallel);

/// Adds volume and centroid, where the shape is closed.
void measure_volume(const TopoDS_Shape& shape, OcctShape& measured);

/// The shape where it stands, all lengths times `scale`: sets mesh, faces, volume, centroid and
/// placement of `part`.
void place(const OcctShape& shape, const gp_Trsf& where, double scale, CadPart& part);

}  // namespace orasp::detail
