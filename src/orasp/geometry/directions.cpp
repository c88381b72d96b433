#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "orasp/geometry/blocking.h"
#include "orasp/geometry/detail/contact_patch.h"
#include "orasp/geometry/detail/for_each_index.h"
#include "orasp/geometry/detail/part_shape.h"

namespace orasp {
namespace {

using detail::ContactPatch;
using detail::cross;
using detail::dot;
using detail::length;
using detail::PartShape;

constexpr double kSame = 0.99996192;  // the cosine of half a degree
constexpr double kInCone = -0.015;    // what rounding and triangles of round faces may take off
constexpr std::size_t kNormals = 12;  // of one contact that are crossed with one another
constexpr std::size_t kFacets = 64;   // directions that the triangles of one part may suggest

// A direction and how much area speaks for it.
struct Candidate {
  Vector3 direction{};
  double area = 0.0;
};

// The same line with the first coordinate that is not 0 positive, and without traces of rounding.
Vector3 canonical(const Vector3& direction) {
  Vector3 line = direction;
  for (double& x : line) x = std::abs(x) > 1e-12 ? x : 0.0;
  const auto first = std::find_if(line.begin(), line.end(), [](double x) { return x != 0; });
  if (first == line.end() || *first > 0) return line;
  for (double& x : line) x = x != 0 ? -x : 0.0;
  return line;
}

bool larger(const Candidate& x, const Candidate& y) {
  return x.area != y.area ? x.area > y.area : x.direction > y.direction;
}

// Lines within an angle of one another as one, with the direction of the largest: a slot a hundred
// long would be closed to the mean of two of its faces.
std::vector<Candidate> gathered(std::vector<Candidate> candidates, double cosine) {
  for (Candidate& candidate : candidates) candidate.direction = canonical(candidate.direction);
  std::sort(candidates.begin(), candidates.end(), larger);
  std::vector<Candidate> lines;
  for (const Candidate& candidate : candidates) {
    const auto same = std::find_if(lines.begin(), lines.end(), [&](const Candidate& line) {
      return std::abs(dot(line.direction, candidate.direction)) >= cosine;
    });
    if (same == lines.end()) {
      lines.push_back(candidate);
    } else {
      same->area += candidate.area;
    }
  }
  std::sort(lines.begin(), lines.end(), larger);
  return lines;
}

// Directions that the faces of a part suggest: normals of its planes and axes of its round faces,
// or, where only triangles are known, normals of its largest flat places.
std::vector<Candidate> face_directions(const CadPart& part, const PartShape& shape) {
  std::vector<Candidate> found;
  for (const FaceHint& face : part.faces) {
    if (dot(face.direction, face.direction) > 0.5) found.push_back({face.direction, face.area});
  }
  if (!part.faces.empty()) return gathered(std::move(found), kSame);
  // Equal normals are brought together by sorting first: a part has many more triangles than
  // directions.
  for (std::size_t i = 0; i < shape.tree.size(); ++i) {
    const detail::Corners c = shape.tree.corners(i);
    const Vector3 normal = cross(detail::minus(c[1], c[0]), detail::minus(c[2], c[0]));
    const double twice = length(normal);
    if (twice > 0) found.push_back({canonical(detail::normalized(normal)), twice / 2});
  }
  const auto rounded = [](const Candidate& candidate) {
    Vector3 place = candidate.direction;
    for (double& x : place) x = std::round(x * 1e5);
    return place;
  };
  std::sort(found.begin(), found.end(), [&](const Candidate& x, const Candidate& y) {
    return rounded(x) != rounded(y) ? rounded(x) < rounded(y) : larger(x, y);
  });
  std::vector<Candidate> flat;
  for (const Candidate& candidate : found) {
    if (!flat.empty() && rounded(flat.back()) == rounded(candidate)) {
      flat.back().area += candidate.area;
    } else {
      flat.push_back(candidate);
    }
  }
  std::sort(flat.begin(), flat.end(), larger);
  if (flat.size() > 4 * kFacets) flat.resize(4 * kFacets);
  flat = gathered(std::move(flat), kSame);
  if (flat.size() > kFacets) flat.resize(kFacets);
  return flat;
}

// The directions along which one of two touching parts may leave, as far as their contact says.
struct Cone {
  std::vector<ContactPatch> patches;

  [[nodiscard]] bool holds(const Vector3& direction) const {
    double total = 0;
    double against = 0;
    for (const ContactPatch& patch : patches) {
      total += patch.area;
      if (dot(patch.normal, direction) < kInCone) against += patch.area;
    }
    return against <= 0.01 * total;
  }
  [[nodiscard]] bool holds_line(const Vector3& direction) const {
    return holds(direction) || holds(detail::times(direction, -1));
  }
};

// What one contact suggests: of the directions of the two parts' faces, and of the rays where two
// of the contact's planes meet, those that its cone holds. Between two faces that look at one
// another, as in a slot, the cone is flat and may have no such ray but the slot's length: the
// directions across that, and those in which the parts' other faces cut the slot, are offered as
// well.
std::vector<Candidate> suggested_by(const Cone& cone, const std::vector<Candidate>& faces_a,
                                    const std::vector<Candidate>& faces_b) {
  std::vector<Candidate> found;
  const auto offer = [&](const Vector3& direction, double area) {
    if (cone.holds_line(direction)) found.push_back({direction, area});
  };
  for (const Candidate& face : faces_a) offer(face.direction, face.area);
  for (const Candidate& face : faces_b) offer(face.direction, face.area);
  const std::size_t size = std::min(kNormals, cone.patches.size());
  std::vector<Candidate> cuts;
  for (const std::vector<Candidate>* faces : {&faces_a, &faces_b}) {
    cuts.insert(cuts.end(), faces->begin(),
                faces->begin() + static_cast<std::ptrdiff_t>(std::min(kNormals, faces->size())));
  }
  std::vector<std::size_t> walls;
  for (std::size_t i = 0; i < size; ++i) {
    const ContactPatch& one = cone.patches[i];
    bool opposed = false;
    for (std::size_t j = 0; j < size; ++j) {
      const ContactPatch& other = cone.patches[j];
      opposed = opposed || dot(one.normal, other.normal) < -kSame;
      const Vector3 ray = cross(one.normal, other.normal);
      if (j <= i || length(ray) < 0.02) continue;
      cuts.push_back({detail::normalized(ray), std::min(one.area, other.area)});
      offer(cuts.back().direction, cuts.back().area);
    }
    if (opposed) walls.push_back(i);
  }
  for (const std::size_t wall : walls) {
    for (const Candidate& cut : cuts) {
      const Vector3 ray = cross(cone.patches[wall].normal, cut.direction);
      if (length(ray) < 0.02) continue;
      offer(detail::normalized(ray), std::min(cone.patches[wall].area, cut.area));
    }
  }
  return found;
}

bool along_an_axis(const Vector3& direction) {
  return std::any_of(direction.begin(), direction.end(),
                     [](double x) { return std::abs(x) >= kSame; });
}

}  // namespace

std::vector<Vector3> suggested_directions(std::span<const CadPart> parts,
                                          std::span<const Contact> contacts,
                                          const GeometrySettings& settings) {
  const std::vector<PartShape> shapes = detail::part_shapes(parts, settings);
  std::vector<std::vector<Candidate>> faces(parts.size());
  detail::for_each_index(parts.size(), settings, [&](std::size_t, std::size_t i) {
    faces[i] = face_directions(parts[i], shapes[i]);
  });
  std::vector<std::vector<Candidate>> by_contact(contacts.size());
  detail::for_each_index(contacts.size(), settings, [&](std::size_t, std::size_t i) {
    const Contact& contact = contacts[i];
    if (contact.proposed) return;
    Cone cone;
    cone.patches = detail::gathered_by_normal(
        detail::contact_patches(shapes[contact.a], shapes[contact.b], settings.tolerance), kSame);
    by_contact[i] = suggested_by(cone, faces[contact.a], faces[contact.b]);
  });
  std::vector<Candidate> all;
  for (const std::vector<Candidate>& some : by_contact) {
    all.insert(all.end(), some.begin(), some.end());
  }
  std::vector<Vector3> directions;
  for (const Candidate& candidate : gathered(std::move(all), kSame)) {
    if (!along_an_axis(candidate.direction)) directions.push_back(candidate.direction);
  }
  return directions;
}

}  // namespace orasp
