#include "orasp/geometry/detail/part_shape.h"

#include "orasp/geometry/detail/for_each_index.h"

namespace orasp::detail {

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
    shapes[i].inside_out = measured.inside_out;
  });
  return shapes;
}

}  // namespace orasp::detail
