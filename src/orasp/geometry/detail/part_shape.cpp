#include "orasp/geometry/detail/part_shape.h"

#include "orasp/geometry/detail/for_each_index.h"

namespace orasp::detail {
namespace {

// Six times the volume, with its sign.
double six_volumes(const Mesh& mesh) {
  if (mesh.empty()) return 0;
  const Vector3 origin = mesh.vertices[mesh.triangles[0][0]];
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    sum += dot(minus(mesh.vertices[t[0]], origin),
               cross(minus(mesh.vertices[t[1]], origin), minus(mesh.vertices[t[2]], origin)));
  }
  return sum;
}

}  // namespace

std::vector<PartShape> part_shapes(std::span<const CadPart> parts,
                                   const GeometrySettings& settings) {
  std::vector<PartShape> shapes(parts.size());
  for_each_index(parts.size(), settings, [&](std::size_t, std::size_t i) {
    const Mesh& mesh = parts[i].mesh;
    shapes[i].tree = TriangleTree(mesh);
    const MeshMeasure measured = measure(mesh);
    shapes[i].closed = measured.closed && measured.volume > 0;
    if (!shapes[i].closed) return;
    shapes[i].volume = measured.volume;
    shapes[i].inside_out = six_volumes(mesh) < 0;
  });
  return shapes;
}

}  // namespace orasp::detail
