// Random arrangements of convex solids that stand clear of one another or touch, whose blocking
// facts follow from planes and circles without any mesh.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/geometry/blocking.h"
#include "orasp/model/random.h"
#include "tests/geometry/shapes.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using shapes::Point2;
using shapes::six_axes;

constexpr double kTolerance = 0.1;

// A section, a convex polygon or a disc, drawn out along an axis. The section lies in the plane of
// the next axis (x of its points) and the one after.
struct Solid {
  std::size_t axis = 2;
  double low = 0, high = 0;
  std::vector<Point2> outline;  // of a prism, counter-clockwise
  Point2 centre{};              // of a cylinder
  double radius = 0;            // 0 of a prism
};

// How far inside of a convex region a point of the plane lies; negative outside.
double depth_in_section(const Solid& solid, const Point2& p) {
  if (solid.radius > 0) {
    return solid.radius - std::hypot(p.x - solid.centre.x, p.y - solid.centre.y);
  }
  double depth = 1e300;
  for (std::size_t i = 0; i < solid.outline.size(); ++i) {
    const Point2& a = solid.outline[i];
    const Point2& b = solid.outline[(i + 1) % solid.outline.size()];
    const double size = std::hypot(b.x - a.x, b.y - a.y);
    depth = std::min(depth, ((b.x - a.x) * (p.y - a.y) - (p.x - a.x) * (b.y - a.y)) / size);
  }
  return depth;
}

struct Range {
  double low, high;
};

// What a solid covers along a coordinate axis.
Range extent(const Solid& solid, std::size_t axis) {
  if (axis == solid.axis) return {solid.low, solid.high};
  const bool first = axis == (solid.axis + 1) % 3;
  if (solid.radius > 0) {
    const double middle = first ? solid.centre.x : solid.centre.y;
    return {middle - solid.radius, middle + solid.radius};
  }
  Range range{1e300, -1e300};
  for (const Point2& p : solid.outline) {
    range.low = std::min(range.low, first ? p.x : p.y);
    range.high = std::max(range.high, first ? p.x : p.y);
  }
  return range;
}

// How far inside of the shadow along an axis a point of the plane (next axis, the one after) lies.
double depth_in_shadow(const Solid& solid, std::size_t axis, const Point2& p) {
  if (axis == solid.axis) return depth_in_section(solid, p);
  const Range x = extent(solid, (axis + 1) % 3);
  const Range y = extent(solid, (axis + 2) % 3);
  return std::min({p.x - x.low, x.high - p.x, p.y - y.low, y.high - p.y});
}

// Where a line along an axis through a point of its plane lies in a solid.
Range on_line(const Solid& solid, std::size_t axis, const Point2& p) {
  if (axis == solid.axis) return {solid.low, solid.high};
  // The line crosses the section: along its x where the axis is the next one, else along its y.
  const bool along_x = axis == (solid.axis + 1) % 3;
  const double at = along_x ? p.x : p.y;  // the other coordinate of the section
  if (solid.radius > 0) {
    const double off = at - (along_x ? solid.centre.y : solid.centre.x);
    const double half = std::sqrt(std::max(0.0, solid.radius * solid.radius - off * off));
    const double middle = along_x ? solid.centre.x : solid.centre.y;
    return {middle - half, middle + half};
  }
  Range range{1e300, -1e300};
  for (std::size_t i = 0; i < solid.outline.size(); ++i) {
    const Point2& a = solid.outline[i];
    const Point2& b = solid.outline[(i + 1) % solid.outline.size()];
    const double a_at = along_x ? a.y : a.x;
    const double b_at = along_x ? b.y : b.x;
    if ((a_at < at && b_at < at) || (a_at > at && b_at > at) || a_at == b_at) continue;
    const double share = (at - a_at) / (b_at - a_at);
    const double value = along_x ? a.x + share * (b.x - a.x) : a.y + share * (b.y - a.y);
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  }
  return range;
}

struct SharedShadow {
  double width;  // the diameter of the widest disc in both shadows; negative where they lie apart
  Point2 middle;
};

// The depth in both shadows is concave: nested golden section search finds its maximum.
SharedShadow shared_shadow(const Solid& a, const Solid& b, std::size_t axis) {
  const auto depth = [&](const Point2& p) {
    return std::min(depth_in_shadow(a, axis, p), depth_in_shadow(b, axis, p));
  };
  const auto greatest = [](double low, double high, const auto& value) {
    constexpr double kGolden = 0.6180339887498949;
    double p = high - kGolden * (high - low);
    double q = low + kGolden * (high - low);
    double at_p = value(p);
    double at_q = value(q);
    for (int i = 0; i < 34; ++i) {
      if (at_p < at_q) {
        low = p;
        p = q;
        at_p = at_q;
        q = low + kGolden * (high - low);
        at_q = value(q);
      } else {
        high = q;
        q = p;
        at_q = at_p;
        p = high - kGolden * (high - low);
        at_p = value(p);
      }
    }
    return (low + high) / 2;
  };
  const auto best_y = [&](double x) {
    return greatest(-30, 30, [&](double y) { return depth({x, y}); });
  };
  const double x = greatest(-30, 30, [&](double at) { return depth({at, best_y(at)}); });
  const Point2 middle = {x, best_y(x)};
  return {2 * depth(middle), middle};
}

// Convex solids whose shadows along some axis share nothing are apart.
bool apart(const Solid& a, const Solid& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (shared_shadow(a, b, axis).width < 1e-6) return true;
  }
  return false;
}

Solid random_solid(SplitMix64& random, bool on_lattice) {
  const auto number = [&](double low, double high) {
    const double x = low + random.uniform() * (high - low);
    return on_lattice ? std::round(2 * x) / 2 : x;
  };
  Solid solid;
  solid.axis = random.below(3);
  solid.low = number(-10, 6);
  solid.high = solid.low + number(0.5, 8);
  const std::uint64_t kind = random.below(3);
  if (kind == 0) {  // a block
    const Point2 p = {number(-10, 6), number(-10, 6)};
    const Point2 q = {p.x + number(0.5, 8), p.y + number(0.5, 8)};
    solid.outline = {p, {q.x, p.y}, q, {p.x, q.y}};
  } else {
    solid.centre = {number(-8, 8), number(-8, 8)};
    const double radius = number(0.5, 4);
    if (kind == 1) {
      solid.radius = radius;
    } else {  // a prism of 3 to 6 sides
      const std::uint64_t sides = 3 + random.below(4);
      const double start = random.uniform();
      for (std::uint64_t i = 0; i < sides; ++i) {
        const double angle =
            start + 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(sides);
        solid.outline.push_back(
            {solid.centre.x + radius * std::cos(angle), solid.centre.y + radius * std::sin(angle)});
      }
    }
  }
  return solid;
}

Mesh mesh_of(const Solid& solid, double deflection) {
  Mesh mesh;
  if (solid.radius > 0) {
    mesh = shapes::shifted(shapes::cylinder(solid.radius, solid.low, solid.high,
                                            shapes::segments_for(solid.radius, deflection), 0.3),
                           {solid.centre.x, solid.centre.y, 0});
  } else {
    mesh = shapes::extruded(solid.outline, solid.low, solid.high);
  }
  // Drawn with its axis along z; turned so that z becomes its axis.
  for (std::size_t i = 0; i < (solid.axis + 1) % 3; ++i) mesh = shapes::cycled(mesh);
  return mesh;
}

std::vector<Solid> random_solids(std::uint64_t seed) {
  SplitMix64 random(seed);
  const bool on_lattice = seed % 2 == 0;
  const std::size_t wanted = 4 + random.below(6);
  std::vector<Solid> solids;
  for (int tries = 0; solids.size() < wanted && tries < 100; ++tries) {
    const Solid solid = random_solid(random, on_lattice);
    if (std::all_of(solids.begin(), solids.end(),
                    [&](const Solid& other) { return apart(solid, other); })) {
      solids.push_back(solid);
    }
  }
  return solids;
}

using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;  // direction, part, by

std::map<Key, double> true_facts(const std::vector<Solid>& solids) {
  std::map<Key, double> facts;
  for (std::uint32_t a = 0; a < solids.size(); ++a) {
    for (std::uint32_t b = a + 1; b < solids.size(); ++b) {
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const SharedShadow shared = shared_shadow(solids[a], solids[b], axis);
        if (shared.width <= 0) continue;
        const bool b_beyond = on_line(solids[b], axis, shared.middle).low >=
                              on_line(solids[a], axis, shared.middle).high - 1e-6;
        const std::uint32_t lower = b_beyond ? a : b;
        const std::uint32_t upper = b_beyond ? b : a;
        facts[{2 * axis, lower, upper}] = shared.width;
        facts[{2 * axis + 1, upper, lower}] = shared.width;
      }
    }
  }
  return facts;
}

std::vector<CadPart> parts_of(const std::vector<Solid>& solids, double deflection) {
  std::vector<CadPart> parts;
  for (const Solid& solid : solids) parts.push_back(shapes::part(mesh_of(solid, deflection)));
  return parts;
}

std::map<Key, double> found_facts(const std::vector<CadPart>& parts, double tolerance,
                                  const std::vector<Vector3>& directions = six_axes()) {
  GeometrySettings settings;
  settings.tolerance = tolerance;
  const std::vector<Contact> contacts = find_contacts(parts, settings);
  std::map<Key, double> facts;
  for (const BlockingFact& fact : find_blocking(parts, contacts, directions, settings)) {
    facts[{fact.direction, fact.part, fact.by}] = fact.width;
  }
  return facts;
}

std::string words(const Key& key) {
  const auto [direction, part, by] = key;
  return "part " + std::to_string(part) + " by " + std::to_string(by) + " along " +
         std::to_string(direction);
}

TEST(Arrangements, HoldNoWrongFactWiderThanTheTolerance) {
  std::size_t known = 0;
  std::size_t narrow = 0;
  const std::uint64_t seeds = some_of(std::uint64_t{300});
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const std::vector<Solid> solids = random_solids(seed);
    const auto expected = true_facts(solids);
    const auto found = found_facts(parts_of(solids, kTolerance / 2), kTolerance);
    for (const auto& [key, width] : expected) {
      narrow += width < 5 * kTolerance ? 1U : 0U;
      ++known;
      const auto fact = found.find(key);
      // Round faces are drawn smaller by the deflection on either side.
      if (width > 2.8 * kTolerance) {
        ASSERT_NE(fact, found.end())
            << "seed " << seed << ", " << words(key) << ", width " << width;
      } else if (width < 1.8 * kTolerance) {
        EXPECT_EQ(fact, found.end())
            << "seed " << seed << ", " << words(key) << ", width " << width;
      }
      if (fact != found.end() && width < 5 * kTolerance) {
        EXPECT_NEAR(fact->second, width, 1.5 * kTolerance) << "seed " << seed << ", " << words(key);
      }
    }
    for (const auto& [key, width] : found) {
      EXPECT_TRUE(expected.contains(key)) << "seed " << seed << ", " << words(key) << ", " << width;
    }
  }
  EXPECT_GE(known, least_of(std::size_t{3000}));
  EXPECT_GE(narrow, least_of(std::size_t{60}));
}

// The facts that are clear: not those so near the limit that other triangles may turn them.
std::vector<Key> clear_facts(const std::map<Key, double>& facts,
                             const std::map<Key, double>& truth) {
  std::vector<Key> clear;
  for (const auto& [key, width] : facts) {
    const auto known = truth.find(key);
    if (known == truth.end() || known->second > 2.8 * kTolerance) clear.push_back(key);
  }
  return clear;
}

TEST(Arrangements, GiveTheSameFactsTurnedScaledReorderedAndDrawnFiner) {
  const std::uint64_t seeds = some_of(std::uint64_t{60});
  for (std::uint64_t seed = 1001; seed < 1001 + seeds; ++seed) {
    const std::vector<Solid> solids = random_solids(seed);
    const auto truth = true_facts(solids);
    const std::vector<CadPart> parts = parts_of(solids, kTolerance / 2);
    const std::vector<Key> facts = clear_facts(found_facts(parts, kTolerance), truth);

    EXPECT_EQ(clear_facts(found_facts(parts_of(solids, kTolerance / 4), kTolerance), truth), facts)
        << "finer, seed " << seed;

    std::vector<CadPart> larger = parts;
    for (CadPart& part : larger) {
      part.mesh = shapes::moved(part.mesh, [](const Vector3& p) {
        return Vector3{10 * p[0], 10 * p[1], 10 * p[2]};
      });
    }
    EXPECT_EQ(clear_facts(found_facts(larger, 10 * kTolerance), truth), facts)
        << "scaled, seed " << seed;

    std::vector<CadPart> turned = parts;
    for (CadPart& part : turned) part.mesh = shapes::cycled(part.mesh);
    std::map<Key, double> back;
    for (const auto& [key, width] : found_facts(turned, kTolerance)) {
      const auto [direction, part, by] = key;
      back[{(direction + 4) % 6, part, by}] = width;
    }
    EXPECT_EQ(clear_facts(back, truth), facts) << "turned, seed " << seed;

    std::vector<CadPart> leaning = parts;
    for (CadPart& part : leaning) part.mesh = shapes::moved(part.mesh, shapes::askew);
    std::vector<Vector3> directions;
    for (const Vector3& axis : six_axes()) directions.push_back(shapes::askew(axis));
    EXPECT_EQ(clear_facts(found_facts(leaning, kTolerance, directions), truth), facts)
        << "askew, seed " << seed;

    std::vector<CadPart> reversed(parts.rbegin(), parts.rend());
    const auto last = static_cast<std::uint32_t>(parts.size() - 1);
    std::map<Key, double> renamed;
    for (const auto& [key, width] : found_facts(reversed, kTolerance)) {
      const auto [direction, part, by] = key;
      renamed[{direction, last - part, last - by}] = width;
    }
    EXPECT_EQ(clear_facts(renamed, truth), facts) << "in another order, seed " << seed;
  }
}

}  // namespace
}  // namespace orasp
