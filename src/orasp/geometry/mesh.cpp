#include "orasp/geometry/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "orasp/model/detail/vector_math.h"

namespace orasp {
namespace {

using detail::cross;
using detail::dot;
using detail::minus;
using detail::plus;
using detail::times;

// For each vertex the first one that stands in the same place, where places are multiples of
// `step`; exact places where it is 0.
std::vector<std::uint32_t> first_at_place(const std::vector<Vector3>& vertices, const Vector3& low,
                                          double step) {
  std::vector<Vector3> places(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double at = vertices[i][k];
      places[i][k] = step > 0 ? std::floor((at - low[k]) / step + 0.5) : at + 0.0;
    }
  }
  std::vector<std::uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return places[a] != places[b] ? places[a] < places[b] : a < b;
  });
  std::vector<std::uint32_t> first(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && places[order[i]] == places[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

// Whether every edge is walked as often one way as the other.
bool closed_over(const Mesh& mesh, const std::vector<std::uint32_t>& first) {
  struct Edge {
    std::uint64_t ends;
    int way;
  };
  std::vector<Edge> edges;
  edges.reserve(mesh.triangles.size() * 3);
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = first[triangle[k]];
      const std::uint64_t b = first[triangle[(k + 1) % 3]];
      if (a == b) continue;
      edges.push_back({std::min(a, b) << 32U | std::max(a, b), a < b ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
  for (std::size_t i = 0; i < edges.size();) {
    int ways = 0;
    const std::uint64_t ends = edges[i].ends;
    for (; i < edges.size() && edges[i].ends == ends; ++i) ways += edges[i].way;
    if (ways != 0) return false;
  }
  return !edges.empty();
}

}  // namespace

void Box::add(const Vector3& point) {
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = std::min(low[k], point[k]);
    high[k] = std::max(high[k], point[k]);
  }
}

double Box::diagonal() const {
  return low[0] > high[0] ? 0.0 : detail::length(minus(high, low));
}

MeshMeasure measure(const Mesh& mesh) {
  MeshMeasure result;
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) result.box.add(mesh.vertices[vertex]);
  }
  if (mesh.empty()) return result;
  // Sums of tetrahedra over a point of the mesh: far from the origin little would be left of them.
  const Vector3 origin = times(plus(result.box.low, result.box.high), 0.5);
  double six_volumes = 0;
  Vector3 volume_sum{};
  Vector3 area_sum{};
  for (const auto& triangle : mesh.triangles) {
    const Vector3 a = minus(mesh.vertices[triangle[0]], origin);
    const Vector3 b = minus(mesh.vertices[triangle[1]], origin);
    const Vector3 c = minus(mesh.vertices[triangle[2]], origin);
    const Vector3 normal = cross(minus(b, a), minus(c, a));
    const double area = detail::length(normal) / 2;
    const double six = dot(a, normal);
    const Vector3 corners = plus(a, plus(b, c));
    result.area += area;
    six_volumes += six;
    volume_sum = plus(volume_sum, times(corners, six / 4));
    area_sum = plus(area_sum, times(corners, area / 3));
  }
  result.volume = std::abs(six_volumes) / 6;
  result.inside_out = six_volumes < 0;
  result.closed = closed_over(mesh, first_at_place(mesh.vertices, result.box.low, 0));
  if (!result.closed) {
    const double step = 1e-7 * result.box.diagonal();
    result.closed = closed_over(mesh, first_at_place(mesh.vertices, result.box.low, step));
  }
  if (result.closed && six_volumes != 0) {
    result.centroid = plus(origin, times(volume_sum, 1 / six_volumes));
  } else {
    result.centroid = result.area > 0 ? plus(origin, times(area_sum, 1 / result.area)) : origin;
  }
  return result;
}

}  // namespace orasp
