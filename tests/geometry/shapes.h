#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "orasp/geometry/cad_model.h"

namespace orasp::shapes {

/// A point of an outline or of a profile.
struct Point2 {
  double x, y;
};

/// The side of a triangle fan that a circle of this radius may lie beside its chords.
[[nodiscard]] inline int segments_for(double radius, double deflection) {
  const double half = std::acos(std::max(0.0, 1 - deflection / radius));
  return std::max(8, static_cast<int>(std::ceil(std::numbers::pi / half)));
}

namespace internal {

inline double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Cuts ears off a simple polygon that runs counter-clockwise.
inline std::vector<std::array<std::uint32_t, 3>> triangulated(const std::vector<Point2>& outline) {
  std::vector<std::uint32_t> left(outline.size());
  for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  while (left.size() > 2) {
    const std::size_t before = left.size();
    for (std::size_t i = 0; i < left.size(); ++i) {
      const std::uint32_t a = left[(i + left.size() - 1) % left.size()];
      const std::uint32_t b = left[i];
      const std::uint32_t c = left[(i + 1) % left.size()];
      if (turn(outline[a], outline[b], outline[c]) <= 0) continue;
      const bool ear = std::none_of(left.begin(), left.end(), [&](std::uint32_t p) {
        return p != a && p != b && p != c && turn(outline[a], outline[b], outline[p]) >= 0 &&
               turn(outline[b], outline[c], outline[p]) >= 0 &&
               turn(outline[c], outline[a], outline[p]) >= 0;
      });
      if (!ear) continue;
      triangles.push_back({a, b, c});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      break;
    }
    if (left.size() == before) break;
  }
  return triangles;
}

}  // namespace internal

/// A simple polygon in x and y, counter-clockwise, drawn out along z.
[[nodiscard]] inline Mesh extruded(const std::vector<Point2>& outline, double low, double high) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double z : {low, high}) {
    for (const Point2& p : outline) mesh.vertices.push_back({p.x, p.y, z});
  }
  for (const auto& t : internal::triangulated(outline)) {
    mesh.triangles.push_back({t[2], t[1], t[0]});
    mesh.triangles.push_back({n + t[0], n + t[1], n + t[2]});
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, n + j});
    mesh.triangles.push_back({i, n + j, n + i});
  }
  return mesh;
}

/// A block along the axes.
[[nodiscard]] inline Mesh block(const Vector3& low, const Vector3& high) {
  return extruded({{low[0], low[1]}, {high[0], low[1]}, {high[0], high[1]}, {low[0], high[1]}},
                  low[2], high[2]);
}

/// A closed outline of (radius, z) turned about the z axis; counter-clockwise seen with the radius
/// to the right and z up. Points on the axis stay single.
[[nodiscard]] inline Mesh turned_solid(const std::vector<Point2>& profile, int segments,
                                       double start = 0.0) {
  Mesh mesh;
  std::vector<std::uint32_t> first(profile.size());
  for (std::size_t i = 0; i < profile.size(); ++i) {
    first[i] = static_cast<std::uint32_t>(mesh.vertices.size());
    const int copies = profile[i].x <= 0 ? 1 : segments;
    for (int s = 0; s < copies; ++s) {
      const double angle = start + 2 * std::numbers::pi * s / segments;
      mesh.vertices.push_back(
          {profile[i].x * std::cos(angle), profile[i].x * std::sin(angle), profile[i].y});
    }
  }
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const std::size_t j = (i + 1) % profile.size();
    const bool axis_i = profile[i].x <= 0;
    const bool axis_j = profile[j].x <= 0;
    if (axis_i && axis_j) continue;
    for (int s = 0; s < segments; ++s) {
      const auto here = static_cast<std::uint32_t>(s);
      const auto next = static_cast<std::uint32_t>((s + 1) % segments);
      const std::uint32_t a = first[i] + (axis_i ? 0 : here);
      const std::uint32_t b = first[i] + (axis_i ? 0 : next);
      const std::uint32_t c = first[j] + (axis_j ? 0 : here);
      const std::uint32_t d = first[j] + (axis_j ? 0 : next);
      if (!axis_i) mesh.triangles.push_back({a, b, d});
      if (!axis_j) mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

[[nodiscard]] inline Mesh cylinder(double radius, double low, double high, int segments,
                                   double start = 0.0) {
  return turned_solid({{0, low}, {radius, low}, {radius, high}, {0, high}}, segments, start);
}

[[nodiscard]] inline Mesh tube(double inner, double outer, double low, double high, int segments,
                               double start = 0.0) {
  return turned_solid({{inner, low}, {outer, low}, {outer, high}, {inner, high}}, segments, start);
}

[[nodiscard]] inline Mesh ball(double radius, int segments) {
  std::vector<Point2> profile;
  for (int i = 0; i <= segments / 2; ++i) {
    const double angle = -std::numbers::pi / 2 + 2 * std::numbers::pi * i / segments;
    const bool pole = i == 0 || i == segments / 2;
    profile.push_back({pole ? 0.0 : radius * std::cos(angle), radius * std::sin(angle)});
  }
  return turned_solid(profile, segments);
}

/// Each vertex p becomes move(p).
template <class Move>
[[nodiscard]] Mesh moved(Mesh mesh, Move&& move) {
  for (Vector3& p : mesh.vertices) p = move(p);
  return mesh;
}

[[nodiscard]] inline Mesh shifted(const Mesh& mesh, const Vector3& by) {
  return moved(mesh, [&](const Vector3& p) {
    return Vector3{p[0] + by[0], p[1] + by[1], p[2] + by[2]};
  });
}

/// x to y, y to z, z to x: turned about the diagonal.
[[nodiscard]] inline Mesh cycled(const Mesh& mesh) {
  return moved(mesh, [](const Vector3& p) { return Vector3{p[2], p[0], p[1]}; });
}

/// Drawn along z, to lie along y instead: (x, y, z) becomes (x, -z, y).
[[nodiscard]] inline Mesh laid_along_y(const Mesh& mesh) {
  return moved(mesh, [](const Vector3& p) { return Vector3{p[0], -p[2], p[1]}; });
}

/// Turned about x, then about z: no edge of a block stays along an axis.
[[nodiscard]] inline Vector3 askew(const Vector3& p) {
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  const double y = p[1] * c - p[2] * s;
  return {p[0] * c - y * s, p[0] * s + y * c, p[1] * s + p[2] * c};
}

/// +x, -x, +y, -y, +z, -z.
[[nodiscard]] inline const std::vector<Vector3>& six_axes() {
  static const std::vector<Vector3> kAxes = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                             {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
  return kAxes;
}

[[nodiscard]] inline CadPart part(Mesh mesh, std::string name = "") {
  CadPart made;
  made.name = std::move(name);
  made.mesh = std::move(mesh);
  return made;
}

}  // namespace orasp::shapes
