#include "orasp/geometry/contacts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>

#include "orasp/geometry/detail/contact_patch.h"
#include "orasp/geometry/detail/for_each_index.h"
#include "orasp/geometry/detail/overlap.h"
#include "orasp/geometry/detail/part_names.h"
#include "orasp/geometry/detail/part_shape.h"

namespace orasp {
namespace {

using detail::ContactPatch;
using detail::dot;
using detail::PartShape;

struct Pair {
  std::uint32_t a, b;
};

const Box& box_of(const PartShape& shape) {
  return shape.tree.box(1);
}

// The pairs whose boxes are no farther apart than `gap`: a sweep along the axis on which the boxes
// are shortest beside the whole.
std::vector<Pair> near_pairs(const std::vector<PartShape>& shapes, double gap) {
  std::vector<std::uint32_t> order;
  Box all;
  Vector3 sizes{};
  for (std::uint32_t i = 0; i < shapes.size(); ++i) {
    if (shapes[i].tree.empty()) continue;
    order.push_back(i);
    const Box& box = box_of(shapes[i]);
    all.add(box.low);
    all.add(box.high);
    for (std::size_t k = 0; k < 3; ++k) sizes[k] += box.high[k] - box.low[k];
  }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    const double extent = all.high[k] - all.low[k];
    if (sizes[k] * (all.high[axis] - all.low[axis]) < sizes[axis] * extent) axis = k;
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
    return std::pair(box_of(shapes[x]).low[axis], x) < std::pair(box_of(shapes[y]).low[axis], y);
  });
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Box& box = box_of(shapes[order[i]]);
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      const Box& other = box_of(shapes[order[j]]);
      if (other.low[axis] > box.high[axis] + gap) break;
      if (detail::squared_distance(box, other) > gap * gap) continue;
      pairs.push_back({std::min(order[i], order[j]), std::max(order[i], order[j])});
    }
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& x, const Pair& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
  return pairs;
}

bool box_inside(const Box& inner, const Box& outer) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (inner.low[k] < outer.low[k] || inner.high[k] > outer.high[k]) return false;
  }
  return true;
}

// Whether one part lies in the material of the other, their surfaces far apart.
bool one_inside_other(const PartShape& a, const PartShape& b) {
  const auto inside = [](const PartShape& inner, const PartShape& outer) {
    return outer.closed && box_inside(box_of(inner), box_of(outer)) &&
           detail::contains(outer.tree, inner.tree.corners(0)[0]);
  };
  return inside(a, b) || inside(b, a);
}

// In tolerances: a peg with more play beside it fits no hole. A trace above a half, for drawings
// like a play of exactly that.
constexpr double kPlay = 0.5 * (1 + 1e-6);

// A hole and a peg about one axis, of one radius: by what the drawing says of the faces.
bool coaxial_fit(const CadPart& a, const CadPart& b, const std::vector<ContactPatch>& patches,
                 double tolerance) {
  constexpr double kParallel = 0.99996;  // half a degree
  for (const FaceHint& one : a.faces) {
    if (one.kind != FaceHint::Kind::Cylinder) continue;
    const bool touched =
        std::any_of(patches.begin(), patches.end(), [&](const ContactPatch& patch) {
          return std::abs(dot(patch.normal, one.direction)) < 0.02;
        });
    if (!touched) continue;
    for (const FaceHint& other : b.faces) {
      if (other.kind != FaceHint::Kind::Cylinder || one.hollow == other.hollow) continue;
      if (std::abs(dot(one.direction, other.direction)) < kParallel) continue;
      const Vector3 between = detail::minus(other.point, one.point);
      if (detail::length(detail::cross(between, one.direction)) > kPlay * tolerance) continue;
      const double play = (one.radius - other.radius) * (one.hollow ? 1 : -1);
      if (std::abs(play) <= kPlay * tolerance) return true;
    }
  }
  return false;
}

Contact::Kind kind_of(const CadPart& a, const CadPart& b, std::vector<ContactPatch> patches,
                      bool ring, double tolerance) {
  for (const CadPart* part : {&a, &b}) {
    if (detail::names_fastener(part->name.empty() ? part->product : part->name)) {
      return Contact::Kind::Fastener;
    }
  }
  if (ring) return Contact::Kind::Fit;
  if (!a.faces.empty() && !b.faces.empty()) {
    return coaxial_fit(a, b, patches, tolerance) ? Contact::Kind::Fit : Contact::Kind::Touch;
  }
  std::erase_if(patches, [&](const ContactPatch& patch) { return patch.gap > kPlay * tolerance; });
  const std::vector<ContactPatch> sides = detail::gathered_by_normal(std::move(patches), 0.996);
  return detail::held_all_round(sides) ? Contact::Kind::Fit : Contact::Kind::Touch;
}

// The contact of a pair, or one with an infinite distance.
Contact contact_of(std::span<const CadPart> parts, const std::vector<PartShape>& shapes,
                   const Pair& pair, double tolerance) {
  Contact contact;
  contact.a = pair.a;
  contact.b = pair.b;
  const PartShape& a = shapes[pair.a];
  const PartShape& b = shapes[pair.b];
  const double limit = tolerance * (1 + 1e-9);
  contact.distance = detail::distance_within(a.tree, b.tree, limit, 1e-6 * tolerance);
  if (contact.distance >= limit) {
    if (!one_inside_other(a, b)) {
      contact.distance = std::numeric_limits<double>::infinity();
      return contact;
    }
    contact.distance = 0;
  }
  std::vector<ContactPatch> patches = detail::contact_patches(a, b, tolerance);
  for (const ContactPatch& patch : patches) contact.area += patch.area;
  const std::optional<detail::FoundOverlap> overlap = detail::find_overlap(a, b, tolerance);
  if (overlap) contact.overlap = overlap->overlap;
  contact.kind = kind_of(parts[pair.a], parts[pair.b], std::move(patches), overlap && overlap->ring,
                         tolerance);
  return contact;
}

// The nearest other part: the boxes are tried from the nearest on until none can be nearer.
Contact nearest_of(const std::vector<PartShape>& shapes, std::uint32_t part) {
  std::vector<std::pair<double, std::uint32_t>> others;
  for (std::uint32_t i = 0; i < shapes.size(); ++i) {
    if (i == part || shapes[i].tree.empty()) continue;
    others.emplace_back(detail::squared_distance(box_of(shapes[part]), box_of(shapes[i])), i);
  }
  std::sort(others.begin(), others.end());
  Contact contact;
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [least, other] : others) {
    if (least >= best * best) break;
    const double distance =
        detail::distance_within(shapes[part].tree, shapes[other].tree, best, 0.0);
    if (distance >= best) continue;
    best = distance;
    contact.a = std::min(part, other);
    contact.b = std::max(part, other);
  }
  contact.distance = best;
  contact.proposed = true;
  return contact;
}

}  // namespace

std::vector<Contact> find_contacts(std::span<const CadPart> parts,
                                   const GeometrySettings& settings) {
  const std::vector<PartShape> shapes = detail::part_shapes(parts, settings);
  const std::vector<Pair> pairs = near_pairs(shapes, settings.tolerance);
  std::vector<Contact> found(pairs.size());
  detail::for_each_index(pairs.size(), settings, [&](std::size_t, std::size_t i) {
    found[i] = contact_of(parts, shapes, pairs[i], settings.tolerance);
  });
  std::vector<bool> touches(parts.size(), false);
  std::vector<Contact> contacts;
  for (const Contact& contact : found) {
    if (!std::isfinite(contact.distance)) continue;
    contacts.push_back(contact);
    touches[contact.a] = touches[contact.b] = true;
  }
  std::vector<std::uint32_t> lonely;
  for (std::uint32_t i = 0; i < parts.size(); ++i) {
    if (!touches[i] && !shapes[i].tree.empty()) lonely.push_back(i);
  }
  std::vector<Contact> nearest(lonely.size());
  detail::for_each_index(lonely.size(), settings, [&](std::size_t, std::size_t i) {
    nearest[i] = nearest_of(shapes, lonely[i]);
  });
  for (const Contact& contact : nearest) {
    if (std::isfinite(contact.distance)) contacts.push_back(contact);
  }
  const auto order = [](const Contact& contact) { return std::pair(contact.a, contact.b); };
  std::stable_sort(contacts.begin(), contacts.end(),
                   [&](const Contact& x, const Contact& y) { return order(x) < order(y); });
  contacts.erase(
      std::unique(contacts.begin(), contacts.end(),
                  [&](const Contact& x, const Contact& y) { return order(x) == order(y); }),
      contacts.end());
  return contacts;
}

}  // namespace orasp
