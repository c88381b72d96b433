#include "orasp/geometry/detail/contact_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "orasp/geometry/detail/frame.h"
#include "orasp/geometry/detail/line_raster.h"

namespace orasp::detail {
namespace {

// Facing triangles: their normals differ from opposites by no more than about 32 degrees, which two
// round faces drawn of few triangles do.
constexpr double kFacing = -0.85;

// A convex polygon in a plane, with the gap over each corner.
struct Polygon {
  struct Corner {
    double u, v, gap;
  };
  std::array<Corner, 12> corners{};
  std::size_t size = 0;

  // Keeps what lies where a function, linear over the plane, is not negative.
  template <class Inside>
  void cut(Inside&& inside) {
    Polygon kept;
    for (std::size_t i = 0; i < size; ++i) {
      const Corner& p = corners[i];
      const Corner& q = corners[(i + 1) % size];
      const double at_p = inside(p);
      const double at_q = inside(q);
      if (at_p >= 0 && kept.size < kept.corners.size()) kept.corners[kept.size++] = p;
      if ((at_p >= 0) != (at_q >= 0) && kept.size < kept.corners.size()) {
        const double share = at_p / (at_p - at_q);
        kept.corners[kept.size++] = {p.u + share * (q.u - p.u), p.v + share * (q.v - p.v),
                                     p.gap + share * (q.gap - p.gap)};
      }
    }
    *this = kept;
  }
  [[nodiscard]] double area() const {
    double twice = 0;
    for (std::size_t i = 2; i < size; ++i) {
      twice += (corners[i - 1].u - corners[0].u) * (corners[i].v - corners[0].v) -
               (corners[i].u - corners[0].u) * (corners[i - 1].v - corners[0].v);
    }
    return std::abs(twice) / 2;
  }
  [[nodiscard]] double mean_gap() const {
    double sum = 0;
    for (std::size_t i = 0; i < size; ++i) sum += corners[i].gap;
    return sum / static_cast<double>(std::max<std::size_t>(1, size));
  }
};

// The part of the plane between two triangles that both cover within the tolerance.
ContactPatch patch_of(const Corners& a, const Corners& b, const Vector3& normal, double tolerance) {
  const Frame frame = frame_along(normal);
  Corners p;
  Corners q;
  for (std::size_t k = 0; k < 3; ++k) {
    p[k] = frame.turned(minus(a[k], b[0]));
    q[k] = frame.turned(minus(b[k], b[0]));
  }
  const double twice = twice_shadow(q);
  if (twice == 0) return {};
  const Vector3 plane = cross(minus(q[1], q[0]), minus(q[2], q[0]));
  Polygon polygon;
  polygon.size = 3;
  for (std::size_t k = 0; k < 3; ++k) {
    const double height = -(plane[0] * p[k][0] + plane[1] * p[k][1]) / plane[2];
    polygon.corners[k] = {p[k][0], p[k][1], p[k][2] - height};
  }
  const double way = twice > 0 ? 1 : -1;
  for (std::size_t k = 0; k < 3 && polygon.size > 0; ++k) {
    const Vector3& from = q[k];
    const Vector3& to = q[(k + 1) % 3];
    polygon.cut([&](const Polygon::Corner& c) {
      return way * ((to[0] - from[0]) * (c.v - from[1]) - (c.u - from[0]) * (to[1] - from[1]));
    });
  }
  if (polygon.size > 0) polygon.cut([&](const Polygon::Corner& c) { return tolerance - c.gap; });
  if (polygon.size > 0) polygon.cut([&](const Polygon::Corner& c) { return tolerance + c.gap; });
  if (polygon.size < 3) return {};
  return {normal, polygon.area(), polygon.mean_gap()};
}

struct Facing {
  const PartShape& a;
  const PartShape& b;
  double tolerance;
  std::vector<ContactPatch>& patches;

  void add(const Corners& one, const Corners& other) const {
    Vector3 out_of_a = normalized(cross(minus(one[1], one[0]), minus(one[2], one[0])));
    Vector3 out_of_b = normalized(cross(minus(other[1], other[0]), minus(other[2], other[0])));
    if (a.inside_out) out_of_a = times(out_of_a, -1);
    if (b.inside_out) out_of_b = times(out_of_b, -1);
    // What an open surface calls outside says nothing.
    if (!a.closed && dot(out_of_a, out_of_b) > 0) out_of_a = times(out_of_a, -1);
    if (!b.closed && dot(out_of_a, out_of_b) > 0) out_of_b = times(out_of_b, -1);
    if (!(dot(out_of_a, out_of_b) < kFacing)) return;
    const ContactPatch patch =
        patch_of(one, other, normalized(minus(out_of_b, out_of_a)), tolerance);
    if (patch.area > 0) patches.push_back(patch);
  }
};

// Patches by the cube of space that their normals end in.
class NormalIndex {
 public:
  explicit NormalIndex(double side) : side_(std::max(1e-6, side)) {}

  void add(const Vector3& normal, std::size_t patch) { cubes_[cube(normal)].push_back(patch); }
  // The first patch whose normal is within the angle, or their number.
  [[nodiscard]] std::size_t first_near(const Vector3& normal,
                                       const std::vector<ContactPatch>& patches,
                                       double cosine) const {
    std::size_t first = patches.size();
    const Cube middle = cube(normal);
    for (int i = 0; i < 27; ++i) {
      const auto found =
          cubes_.find({middle[0] + i / 9 - 1, middle[1] + i / 3 % 3 - 1, middle[2] + i % 3 - 1});
      if (found == cubes_.end()) continue;
      for (const std::size_t patch : found->second) {
        if (dot(patches[patch].normal, normal) >= cosine) first = std::min(first, patch);
      }
    }
    return first;
  }

 private:
  using Cube = std::array<long, 3>;
  [[nodiscard]] Cube cube(const Vector3& normal) const {
    return {std::lround(normal[0] / side_), std::lround(normal[1] / side_),
            std::lround(normal[2] / side_)};
  }

  double side_;
  std::map<Cube, std::vector<std::size_t>> cubes_;
};

bool near(const Corners& a, const Corners& b, double tolerance) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::min({a[0][k], a[1][k], a[2][k]}) > std::max({b[0][k], b[1][k], b[2][k]}) + tolerance ||
        std::min({b[0][k], b[1][k], b[2][k]}) > std::max({a[0][k], a[1][k], a[2][k]}) + tolerance) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::vector<ContactPatch> contact_patches(const PartShape& a, const PartShape& b,
                                          double tolerance) {
  std::vector<ContactPatch> patches;
  if (a.tree.empty() || b.tree.empty()) return patches;
  const Facing facing{a, b, tolerance, patches};
  struct Two {
    std::size_t a, b;
  };
  std::vector<Two> stack = {{1, 1}};
  while (!stack.empty()) {
    const Two two = stack.back();
    stack.pop_back();
    const Box& box_a = a.tree.box(two.a);
    const Box& box_b = b.tree.box(two.b);
    if (!(squared_distance(box_a, box_b) <= tolerance * tolerance)) continue;
    const bool leaf_a = a.tree.is_leaf(two.a);
    const bool leaf_b = b.tree.is_leaf(two.b);
    if (leaf_a && leaf_b) {
      for (std::size_t i = a.tree.begin(two.a); i < a.tree.end(two.a); ++i) {
        const Corners one = a.tree.corners(i);
        for (std::size_t j = b.tree.begin(two.b); j < b.tree.end(two.b); ++j) {
          const Corners other = b.tree.corners(j);
          if (near(one, other, tolerance)) facing.add(one, other);
        }
      }
    } else if (!leaf_a && (leaf_b || box_a.diagonal() >= box_b.diagonal())) {
      stack.push_back({2 * two.a + 1, two.b});
      stack.push_back({2 * two.a, two.b});
    } else {
      stack.push_back({two.a, 2 * two.b + 1});
      stack.push_back({two.a, 2 * two.b});
    }
  }
  return patches;
}

std::vector<ContactPatch> gathered_by_normal(std::vector<ContactPatch> patches, double cosine) {
  const auto larger = [](const ContactPatch& x, const ContactPatch& y) {
    return x.area != y.area ? x.area > y.area : x.normal > y.normal;
  };
  const auto join = [](ContactPatch& one, const ContactPatch& other) {
    one.gap = (one.gap * one.area + other.gap * other.area) / (one.area + other.area);
    one.area += other.area;
  };
  struct Rounded {
    std::array<int, 3> place;
    std::size_t patch;
  };
  std::vector<Rounded> order(patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      order[i].place[k] = static_cast<int>(std::lround(patches[i].normal[k] * 1000));
    }
    order[i].patch = i;
  }
  std::sort(order.begin(), order.end(), [&](const Rounded& x, const Rounded& y) {
    if (x.place != y.place) return x.place < y.place;
    const ContactPatch& one = patches[x.patch];
    const ContactPatch& other = patches[y.patch];
    return larger(one, other) || (!larger(other, one) && x.patch < y.patch);
  });
  std::vector<ContactPatch> distinct;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && order[i].place == order[i - 1].place) {
      join(distinct.back(), patches[order[i].patch]);
    } else {
      distinct.push_back(patches[order[i].patch]);
    }
  }
  std::stable_sort(distinct.begin(), distinct.end(), larger);
  NormalIndex index(std::sqrt(2 - 2 * cosine));
  std::vector<ContactPatch> gathered;
  for (const ContactPatch& patch : distinct) {
    const std::size_t same = index.first_near(patch.normal, gathered, cosine);
    if (same == gathered.size()) {
      index.add(patch.normal, gathered.size());
      gathered.push_back(patch);
    } else {
      join(gathered[same], patch);
    }
  }
  std::stable_sort(gathered.begin(), gathered.end(), larger);
  return gathered;
}

bool held_all_round(const std::vector<ContactPatch>& patches) {
  constexpr std::size_t kMost = 16;  // normals that an axis is made of
  const std::size_t size = std::min(kMost, patches.size());
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = i + 1; j < size; ++j) {
      const Vector3 across = cross(patches[i].normal, patches[j].normal);
      if (length(across) < 0.1) continue;
      const Frame frame = frame_along(normalized(across));
      std::vector<double> angles;
      for (const ContactPatch& patch : patches) {
        const Vector3 n = frame.turned(patch.normal);
        if (std::abs(n[2]) < 0.1) angles.push_back(std::atan2(n[1], n[0]));
      }
      std::sort(angles.begin(), angles.end());
      double widest = angles.front() + 2 * std::numbers::pi - angles.back();
      for (std::size_t k = 1; k < angles.size(); ++k) {
        widest = std::max(widest, angles[k] - angles[k - 1]);
      }
      if (widest < std::numbers::pi - 0.05) return true;
    }
  }
  return false;
}

}  // namespace orasp::detail
