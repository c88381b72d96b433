#include "orasp/geometry/detail/triangle_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace orasp::detail {
namespace {

constexpr std::size_t kLeafSize = 4;

// Spreads 10 bits out to every third place.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16U) & 0x030000FFU;
  x = (x | x << 8U) & 0x0300F00FU;
  x = (x | x << 4U) & 0x030C30C3U;
  return (x | x << 2U) & 0x09249249U;
}

// The place of a point on the Z-curve through the cube over a box.
std::uint32_t curve_place(const Vector3& point, const Box& box) {
  const double extent =
      std::max({box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]});
  std::uint32_t place = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double share = extent > 0 ? (point[k] - box.low[k]) / extent : 0.0;
    const auto cell = static_cast<std::uint32_t>(1023 * std::max(0.0, std::min(1.0, share)));
    place |= spread(cell) << static_cast<unsigned>(k);
  }
  return place;
}

double squared(double x) {
  return x * x;
}

double squared_distance(const Box& box, const Vector3& p) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    sum += squared(std::max({0.0, box.low[k] - p[k], p[k] - box.high[k]}));
  }
  return sum;
}

// The square of the distance of segments p + s d and q + t e (Ericson, "Real-Time Collision
// Detection", 2005, 5.1.9).
double squared_distance_of_segments(const Vector3& p, const Vector3& d, const Vector3& q,
                                    const Vector3& e) {
  const Vector3 r = minus(p, q);
  const double dd = dot(d, d);
  const double ee = dot(e, e);
  const double er = dot(e, r);
  const double dr = dot(d, r);
  const double de = dot(d, e);
  double s = 0;
  double t = 0;
  if (dd <= 0 && ee <= 0) return dot(r, r);
  if (dd <= 0) {
    t = std::clamp(er / ee, 0.0, 1.0);
  } else if (ee <= 0) {
    s = std::clamp(-dr / dd, 0.0, 1.0);
  } else {
    const double across = dd * ee - de * de;
    if (across > 1e-14 * dd * ee) s = std::clamp((de * er - dr * ee) / across, 0.0, 1.0);
    t = (de * s + er) / ee;
    if (t < 0) {
      t = 0;
      s = std::clamp(-dr / dd, 0.0, 1.0);
    } else if (t > 1) {
      t = 1;
      s = std::clamp((de - dr) / dd, 0.0, 1.0);
    }
  }
  const Vector3 gap = minus(plus(r, times(d, s)), times(e, t));
  return dot(gap, gap);
}

// The square of the distance of a point from a triangle (Ericson, 5.1.5).
double squared_distance(const Corners& c, const Vector3& p) {
  const Vector3 ab = minus(c[1], c[0]);
  const Vector3 ac = minus(c[2], c[0]);
  const Vector3 ap = minus(p, c[0]);
  const double d1 = dot(ab, ap);
  const double d2 = dot(ac, ap);
  const auto to = [&](const Vector3& q) { return dot(minus(p, q), minus(p, q)); };
  if (d1 <= 0 && d2 <= 0) return to(c[0]);
  const Vector3 bp = minus(p, c[1]);
  const double d3 = dot(ab, bp);
  const double d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return to(c[1]);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return to(plus(c[0], times(ab, d1 / (d1 - d3))));
  const Vector3 cp = minus(p, c[2]);
  const double d5 = dot(ab, cp);
  const double d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return to(c[2]);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return to(plus(c[0], times(ac, d2 / (d2 - d6))));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && d4 - d3 + d5 - d6 > 0) {
    const double share = (d4 - d3) / (d4 - d3 + d5 - d6);
    return to(plus(c[1], times(minus(c[2], c[1]), share)));
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return std::min({to(c[0]), to(c[1]), to(c[2])});
  return to(plus(c[0], plus(times(ab, vb / sum), times(ac, vc / sum))));
}

// Whether the segment from p to q meets a triangle's inside or border.
bool crosses(const Corners& c, const Vector3& p, const Vector3& q) {
  const Vector3 normal = cross(minus(c[1], c[0]), minus(c[2], c[0]));
  const double at_p = dot(normal, minus(p, c[0]));
  const double at_q = dot(normal, minus(q, c[0]));
  if ((at_p > 0 && at_q > 0) || (at_p < 0 && at_q < 0) || at_p == at_q) return false;
  const Vector3 x = plus(p, times(minus(q, p), at_p / (at_p - at_q)));
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3& from = c[k];
    const Vector3& to = c[(k + 1) % 3];
    if (dot(normal, cross(minus(to, from), minus(x, from))) < 0) return false;
  }
  return true;
}

Box box_of(const Corners& c) {
  Box box;
  for (const Vector3& p : c) box.add(p);
  return box;
}

}  // namespace

TriangleTree::TriangleTree(const Mesh& mesh) : vertices_(&mesh.vertices) {
  const std::size_t n = mesh.triangles.size();
  if (n == 0) return;
  Box all;
  std::vector<Vector3> centres(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto& t = mesh.triangles[i];
    const Box box = box_of({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    centres[i] = times(plus(box.low, box.high), 0.5);
    all.add(centres[i]);
  }
  std::vector<std::uint64_t> order(n);
  for (std::size_t i = 0; i < n; ++i) {
    order[i] = static_cast<std::uint64_t>(curve_place(centres[i], all)) << 32U | i;
  }
  std::sort(order.begin(), order.end());
  triangles_.reserve(n);
  for (const std::uint64_t key : order) triangles_.push_back(mesh.triangles[key & 0xFFFFFFFFU]);
  leaves_ = std::bit_ceil((n + kLeafSize - 1) / kLeafSize);
  boxes_.resize(2 * leaves_);
  for (std::size_t leaf = leaves_; leaf < 2 * leaves_; ++leaf) {
    for (std::size_t i = begin(leaf); i < end(leaf); ++i) {
      for (const std::uint32_t vertex : triangles_[i]) boxes_[leaf].add(mesh.vertices[vertex]);
    }
  }
  for (std::size_t node = leaves_; node-- > 1;) {
    const Box& one = boxes_[2 * node];
    const Box& two = boxes_[2 * node + 1];
    for (std::size_t k = 0; k < 3; ++k) {
      boxes_[node].low[k] = std::min(one.low[k], two.low[k]);
      boxes_[node].high[k] = std::max(one.high[k], two.high[k]);
    }
  }
}

double squared_distance(const Box& a, const Box& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    sum += squared(std::max({0.0, a.low[k] - b.high[k], b.low[k] - a.high[k]}));
  }
  return sum;
}

double squared_distance(const Corners& a, const Corners& b) {
  double best = std::numeric_limits<double>::infinity();
  for (const Vector3& p : a) best = std::min(best, squared_distance(b, p));
  for (const Vector3& p : b) best = std::min(best, squared_distance(a, p));
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 d = minus(a[(i + 1) % 3], a[i]);
    for (std::size_t j = 0; j < 3; ++j) {
      const Vector3 e = minus(b[(j + 1) % 3], b[j]);
      best = std::min(best, squared_distance_of_segments(a[i], d, b[j], e));
    }
  }
  if (best <= 0) return 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (crosses(b, a[i], a[(i + 1) % 3]) || crosses(a, b[i], b[(i + 1) % 3])) return 0;
  }
  return best;
}

double distance_within(const TriangleTree& a, const TriangleTree& b, double limit, double nothing) {
  if (a.empty() || b.empty()) return limit;
  double best = limit * limit;
  const double enough = nothing * nothing;
  struct Two {
    std::size_t a, b;
    double least;
  };
  std::vector<Two> stack = {{1, 1, squared_distance(a.box(1), b.box(1))}};
  while (!stack.empty()) {
    const Two two = stack.back();
    stack.pop_back();
    if (two.least >= best) continue;
    if (a.is_leaf(two.a) && b.is_leaf(two.b)) {
      for (std::size_t i = a.begin(two.a); i < a.end(two.a); ++i) {
        const Corners one = a.corners(i);
        const Box box = box_of(one);
        if (squared_distance(box, b.box(two.b)) >= best) continue;
        for (std::size_t j = b.begin(two.b); j < b.end(two.b); ++j) {
          const Corners other = b.corners(j);
          if (squared_distance(box, box_of(other)) >= best) continue;
          best = std::min(best, squared_distance(one, other));
          if (best <= enough) return 0;
        }
      }
      continue;
    }
    const bool split_a = !a.is_leaf(two.a) &&
                         (b.is_leaf(two.b) || a.box(two.a).diagonal() >= b.box(two.b).diagonal());
    Two children[2];
    for (std::size_t k = 0; k < 2; ++k) {
      children[k] = two;
      (split_a ? children[k].a : children[k].b) = 2 * (split_a ? two.a : two.b) + k;
      children[k].least = squared_distance(a.box(children[k].a), b.box(children[k].b));
    }
    if (children[0].least < children[1].least) std::swap(children[0], children[1]);
    for (const Two& child : children) {
      if (child.least < best) stack.push_back(child);
    }
  }
  return std::sqrt(best);
}

double distance_above(const TriangleTree& tree, const Vector3& point, double least) {
  double best = std::numeric_limits<double>::infinity();
  std::vector<std::size_t> stack = {1};
  while (!stack.empty()) {
    const std::size_t node = stack.back();
    stack.pop_back();
    if (squared_distance(tree.box(node), point) >= best) continue;
    if (!tree.is_leaf(node)) {
      const bool second = squared_distance(tree.box(2 * node + 1), point) <
                          squared_distance(tree.box(2 * node), point);
      stack.push_back(2 * node + (second ? 0U : 1U));
      stack.push_back(2 * node + (second ? 1U : 0U));
      continue;
    }
    for (std::size_t i = tree.begin(node); i < tree.end(node); ++i) {
      best = std::min(best, squared_distance(tree.corners(i), point));
      if (best <= squared(least)) return std::sqrt(best);
    }
  }
  return std::sqrt(best);
}

bool contains(const TriangleTree& tree, const Vector3& point) {
  if (tree.empty()) return false;
  bool inside = false;
  std::vector<std::size_t> stack = {1};
  while (!stack.empty()) {
    const std::size_t node = stack.back();
    stack.pop_back();
    const Box& box = tree.box(node);
    if (point[0] < box.low[0] || point[0] > box.high[0] || point[1] < box.low[1] ||
        point[1] > box.high[1] || point[2] > box.high[2]) {
      continue;
    }
    if (!tree.is_leaf(node)) {
      stack.push_back(2 * node);
      stack.push_back(2 * node + 1);
      continue;
    }
    for (std::size_t i = tree.begin(node); i < tree.end(node); ++i) {
      // The same half-open rule for both triangles at an edge: each line meets one of them.
      const Corners c = tree.corners(i);
      int meets = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const bool up = c[k][1] <= c[(k + 1) % 3][1];
        const Vector3& low = up ? c[k] : c[(k + 1) % 3];
        const Vector3& high = up ? c[(k + 1) % 3] : c[k];
        if (point[1] < low[1] || point[1] >= high[1]) continue;
        const double x = low[0] + (point[1] - low[1]) * ((high[0] - low[0]) / (high[1] - low[1]));
        if (x > point[0]) meets += up ? 1 : -1;
      }
      if (meets == 0) continue;
      const Vector3 normal = cross(minus(c[1], c[0]), minus(c[2], c[0]));
      if (normal[2] == 0) continue;
      const double height = dot(normal, minus(c[0], point)) / normal[2];
      if (height > 0) inside = !inside;
    }
  }
  return inside;
}

}  // namespace orasp::detail
