#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/geometry/shapes.h"

namespace orasp::shapes {

/// Two parts whose free directions are known.
struct MadeCase {
  std::string name;
  Mesh a, b;
  std::array<bool, 6> free;  ///< of a, along +x, -x, +y, -y, +z, -z
  double tolerance = 0.1;
};

/// Eighteen pairs: rests, slots, pegs, fits, screws, sockets, thin things and a drawing error.
/// Round faces are drawn with a deflection of half the tolerance and, in the two parts, of
/// different triangles, unless `finer` divides it.
[[nodiscard]] inline std::vector<MadeCase> made_cases(double finer = 1.0) {
  const auto sides = [finer](double radius) { return segments_for(radius, 0.05 / finer); };
  const auto others = [&](double radius) { return sides(radius) + 3; };
  // A round block with a hole of radius r from z = 0 to 10; blind where it has a floor 3 thick.
  const auto bored = [&](double r, bool blind) {
    return blind ? turned_solid({{0, -3}, {15, -3}, {15, 10}, {r, 10}, {r, 0}, {0, 0}}, others(15))
                 : tube(r, 15, 0, 10, others(15), 0.1);
  };
  const auto screw = [&](double r, double tip) {
    return turned_solid({{0, tip}, {r, tip}, {r, 10}, {2.75, 10}, {2.75, 13}, {0, 13}},
                        sides(2.75));
  };
  const auto along_y = [](const std::vector<Point2>& outline) {
    return laid_along_y(extruded(outline, -10, 10));
  };
  // The hollow of a socket: from the lowest point of the ball to where the rim cuts it.
  const auto socket = [&](double rim) {
    std::vector<Point2> profile = {{0, -9}, {9, -9}, {9, rim}};
    const int n = others(5);
    const double top = std::asin(rim / 5);
    for (int i = 0; i < n; ++i) {
      const double angle = top + (-std::numbers::pi / 2 - top) * i / n;
      profile.push_back({5 * std::cos(angle), 5 * std::sin(angle)});
    }
    profile.push_back({0, -5});
    return turned_solid(profile, others(9), 0.05);
  };
  const auto box = [](Vector3 low, Vector3 high) { return block(low, high); };

  std::vector<MadeCase> cases;
  const auto add = [&](std::string name, Mesh a, Mesh b, std::array<bool, 6> free,
                       double tolerance = 0.1) {
    cases.push_back({std::move(name), std::move(a), std::move(b), free, tolerance});
  };
  constexpr std::array<bool, 6> kUp = {false, false, false, false, true, false};
  constexpr std::array<bool, 6> kNone = {};
  constexpr std::array<bool, 6> kNotUp = {true, true, true, true, false, true};
  add("rest on a block", box({2, 3, 10}, {8, 7, 15}), box({0, 0, 0}, {10, 10, 10}),
      {true, true, true, true, true, false});
  add("flush in a slot", box({-3, -10, 0}, {3, 10, 6}),
      along_y({{-8, -4}, {8, -4}, {8, 6}, {3, 6}, {3, 0}, {-3, 0}, {-3, 6}, {-8, 6}}),
      {false, false, true, true, true, false});
  add("peg without clearance, through", cylinder(5, -2, 12, sides(5)), bored(5, false),
      {false, false, false, false, true, true});
  add("peg without clearance, blind", cylinder(5, 0, 12, sides(5)), bored(5, true), kUp);
  add("press fit, 0.05 too big", cylinder(5.05, 0, 12, sides(5)), bored(5, true), kUp);
  add("heat-set insert, a ring of 0.3", tube(1.5, 2.3, 0, 10, sides(2.3)), bored(2.0, true), kUp);
  add("M3 screw in a bore of 2.5, blind", screw(1.5, 2), bored(1.25, true), kUp);
  add("M3 screw through a nut, tip outside", screw(1.5, -4), tube(1.25, 2.75, 0, 2.4, 6), kUp);
  add("dovetail", along_y({{-4, 0}, {4, 0}, {2, 5}, {-2, 5}}),
      along_y({{-8, -4}, {8, -4}, {8, 5}, {2, 5}, {4, 0}, {-4, 0}, {-2, 5}, {-8, 5}}),
      {false, false, true, true, false, false});
  add("slanted slot", along_y({{-2, 0}, {2, 0}, {6, 5}, {2, 5}}),
      along_y({{-8, -4}, {12, -4}, {12, 5}, {6, 5}, {2, 0}, {-2, 0}, {2, 5}, {-8, 5}}),
      {false, false, true, true, false, false});
  add("half ball socket", ball(5, 2 * (sides(5) / 2)), socket(0), kUp);
  add("socket past the equator", ball(5, 2 * (sides(5) / 2)), socket(2), kNone);
  add("ring in a groove", tube(4, 7, 0, 2, sides(7)),
      turned_solid({{0, -5}, {6, -5}, {6, 0}, {4, 0}, {4, 2}, {6, 2}, {6, 7}, {0, 7}}, others(6)),
      kNone);
  add("far lid", box({0, 0, 0}, {10, 10, 10}), box({-5, -5, 500}, {15, 15, 501}), kNotUp);
  add("foil of 0.05 beside", box({0, 0, 0}, {10, 10, 10}), box({0, 10, 0}, {10, 10.05, 10}),
      {true, true, false, true, true, true});
  add("wire of 0.3 over a plate of 100", box({0, 0, 0}, {100, 100, 5}),
      box({10, 40.123, 10}, {90, 40.423, 10.3}), kNotUp);
  add("lip of 0.15 over an edge", box({0, 0, 0}, {10, 10, 10}),
      laid_along_y(
          extruded({{10, 0}, {14, 0}, {14, 12}, {9.85, 12}, {9.85, 10}, {10, 10}}, -10, 0)),
      {false, true, true, true, false, true}, 0.05);
  add("faces overlap by 0.3", box({0, 0, 0}, {10, 10, 10}), box({-2, 1, 9.7}, {11, 8, 20}), kNotUp);
  return cases;
}

}  // namespace orasp::shapes
