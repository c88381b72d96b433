#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/geometry/blocking.h"
#include "tests/geometry/made_cases.h"

namespace orasp {
namespace {

using shapes::block;
using shapes::part;

std::vector<Vector3> suggested(const std::vector<CadPart>& parts) {
  const GeometrySettings settings;
  return suggested_directions(parts, find_contacts(parts, settings), settings);
}

bool holds(const std::vector<Vector3>& directions, const Vector3& wanted) {
  return std::any_of(directions.begin(), directions.end(), [&](const Vector3& d) {
    const double size =
        std::sqrt(wanted[0] * wanted[0] + wanted[1] * wanted[1] + wanted[2] * wanted[2]);
    return std::abs(d[0] * wanted[0] + d[1] * wanted[1] + d[2] * wanted[2]) > 0.999999 * size;
  });
}

TEST(SuggestedDirections, OfBlocksAlongTheAxesAreNone) {
  EXPECT_TRUE(suggested({part(block({0, 0, 0}, {10, 10, 10})), part(block({1, 1, 10}, {9, 9, 12}))})
                  .empty());
}

TEST(SuggestedDirections, HoldTheWayOutOfASlantedSlot) {
  for (const shapes::MadeCase& made : shapes::made_cases()) {
    if (made.name != "slanted slot") continue;
    const std::vector<CadPart> parts = {part(made.a), part(made.b)};
    const std::vector<Vector3> directions = suggested(parts);
    ASSERT_TRUE(holds(directions, {4, 0, 5}));
    EXPECT_LE(directions.size(), 4U);
    // And it is a way out.
    const GeometrySettings settings;
    const auto facts = find_blocking(parts, find_contacts(parts, settings), directions, settings);
    for (std::uint32_t i = 0; i < directions.size(); ++i) {
      if (!holds({directions[i]}, {4, 0, 5})) continue;
      EXPECT_TRUE(std::none_of(facts.begin(), facts.end(), [&](const BlockingFact& fact) {
        return fact.direction == i && fact.part == 0;
      }));
    }
  }
}

TEST(SuggestedDirections, HoldTheAxisOfAPegThatLeans) {
  const auto leaning = [](const Vector3& p) {
    const double c = std::cos(0.4);
    const double s = std::sin(0.4);
    return Vector3{p[0] * c + p[2] * s, p[1], -p[0] * s + p[2] * c};
  };
  const std::vector<CadPart> parts = {part(shapes::moved(shapes::cylinder(5, 0, 12, 40), leaning)),
                                      part(shapes::moved(shapes::tube(5, 15, 0, 10, 43), leaning))};
  const auto directions = suggested(parts);
  ASSERT_FALSE(directions.empty());
  EXPECT_TRUE(holds(directions, {std::sin(0.4), 0, std::cos(0.4)}));
  EXPECT_LE(directions.size(), 2U);  // across the axis the hole holds the peg
}

TEST(SuggestedDirections, ComeFromTheFacesOfTheDrawingWhereItHasThem) {
  // A block on another: free to slide along any direction of the plane; only what the faces say is
  // worth a look.
  CadPart top = part(block({1, 1, 10}, {9, 9, 12}));
  FaceHint face;
  face.direction = {std::sqrt(0.5), std::sqrt(0.5), 0};
  face.area = 3;
  top.faces.push_back(face);
  face.direction = {0, 0, 1};
  top.faces.push_back(face);
  face.direction = {-0.6, 0, 0.8};
  face.area = 7;
  top.faces.push_back(face);
  const auto directions = suggested({part(block({0, 0, 0}, {10, 10, 10})), top});
  ASSERT_EQ(directions.size(), 2U);
  EXPECT_TRUE(holds({directions[0]}, {-0.6, 0, 0.8}));  // the larger area first
  EXPECT_GT(directions[0][0], 0);                       // one sign of each line
  EXPECT_TRUE(holds({directions[1]}, {1, 1, 0}));
}

TEST(SuggestedDirections, AreTheSameForAnyNumberOfThreads) {
  std::vector<CadPart> parts;
  for (const shapes::MadeCase& made : shapes::made_cases()) {
    const Vector3 at = {0, static_cast<double>(parts.size()) * 60, 0};
    parts.push_back(part(shapes::shifted(made.a, at)));
    parts.push_back(part(shapes::shifted(made.b, at)));
  }
  GeometrySettings settings;
  const auto contacts = find_contacts(parts, settings);
  const auto one = suggested_directions(parts, contacts, settings);
  settings.threads = 5;
  EXPECT_EQ(suggested_directions(parts, contacts, settings), one);
}

}  // namespace
}  // namespace orasp
