#include "orasp/geometry/blocking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/geometry/made_cases.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using shapes::block;
using shapes::MadeCase;
using shapes::part;
using shapes::six_axes;

GeometrySettings with_tolerance(double tolerance, unsigned threads = 1) {
  GeometrySettings settings;
  settings.tolerance = tolerance;
  settings.threads = threads;
  return settings;
}

std::vector<BlockingFact> facts_of(const std::vector<CadPart>& parts,
                                   const std::vector<Vector3>& directions,
                                   const GeometrySettings& settings) {
  return find_blocking(parts, find_contacts(parts, settings), directions, settings);
}

// As many of the made cases as tests that repeat them are to look at.
std::vector<MadeCase> some_cases(double finer = 1.0) {
  std::vector<MadeCase> cases = shapes::made_cases(finer);
  const std::size_t count = some_of(cases.size());
  std::rotate(cases.begin(), cases.begin() + 4, cases.end());
  cases.erase(cases.begin() + static_cast<std::ptrdiff_t>(count), cases.end());
  return cases;
}

// Along which of six directions, the axes unless others are given, the first part is free of the
// second.
std::array<bool, 6> free_of(const Mesh& a, const Mesh& b, double tolerance,
                            const std::vector<Vector3>& directions = six_axes()) {
  const auto facts = facts_of({part(a), part(b)}, directions, with_tolerance(tolerance));
  std::array<bool, 6> free;
  free.fill(true);
  for (const BlockingFact& fact : facts) {
    if (fact.part == 0) free[fact.direction] = false;
  }
  return free;
}

std::string words(const std::array<bool, 6>& free) {
  std::string text;
  for (std::size_t i = 0; i < 6; ++i) {
    if (free[i]) text += std::string(i % 2 == 0 ? "+" : "-") + "xyz"[i / 2] + " ";
  }
  return text;
}

TEST(FindBlocking, IsRightInEighteenMadeCases) {
  const std::vector<MadeCase> cases = shapes::made_cases();
  ASSERT_EQ(cases.size(), 18U);
  for (const MadeCase& made : cases) {
    ASSERT_TRUE(measure(made.a).closed && measure(made.b).closed) << made.name;
    EXPECT_EQ(words(free_of(made.a, made.b, made.tolerance)), words(made.free)) << made.name;
  }
}

TEST(FindBlocking, IsRightInMadeCasesTurnedScaledAndDrawnFiner) {
  for (const MadeCase& made : some_cases(2.0)) {
    EXPECT_EQ(words(free_of(made.a, made.b, made.tolerance)), words(made.free)) << made.name;
  }
  const auto larger = [](const Vector3& p) { return Vector3{10 * p[0], 10 * p[1], 10 * p[2]}; };
  for (const MadeCase& made : some_cases()) {
    const auto free =
        free_of(shapes::moved(made.a, larger), shapes::moved(made.b, larger), 10 * made.tolerance);
    EXPECT_EQ(words(free), words(made.free)) << made.name;
    std::array<bool, 6> cycled{};
    for (std::size_t i = 0; i < 6; ++i) cycled[(i + 2) % 6] = made.free[i];
    const auto turned = free_of(shapes::cycled(made.a), shapes::cycled(made.b), made.tolerance);
    EXPECT_EQ(words(turned), words(cycled)) << made.name;
  }
}

TEST(FindBlocking, IsRightInMadeCasesThatLieAskew) {
  std::vector<Vector3> directions;
  for (const Vector3& axis : six_axes()) directions.push_back(shapes::askew(axis));
  for (const MadeCase& made : some_cases()) {
    const auto free = free_of(shapes::moved(made.a, shapes::askew),
                              shapes::moved(made.b, shapes::askew), made.tolerance, directions);
    EXPECT_EQ(words(free), words(made.free)) << made.name;
  }
}

TEST(FindBlocking, SaysTheSameOfThePartInTheOtherOrder) {
  for (const MadeCase& made : some_cases()) {
    const auto facts =
        facts_of({part(made.b), part(made.a)}, six_axes(), with_tolerance(made.tolerance));
    std::array<bool, 6> free;
    free.fill(true);
    for (const BlockingFact& fact : facts) {
      if (fact.part == 1) free[fact.direction] = false;
    }
    EXPECT_EQ(words(free), words(made.free)) << made.name;
  }
}

TEST(FindBlocking, TellsTheWidthAndTheDepth) {
  // The shadow of the lid on the box is 4 by 10; the lid's top is 21 above the box's floor.
  const auto facts =
      facts_of({part(block({0, 0, 0}, {10, 10, 10})), part(block({6, 0, 20}, {20, 10, 21}))},
               {{0, 0, 1}}, with_tolerance(0.1));
  ASSERT_EQ(facts.size(), 1U);
  EXPECT_EQ(facts[0].part, 0U);
  EXPECT_EQ(facts[0].by, 1U);
  EXPECT_NEAR(facts[0].width, 4, 0.2);
  EXPECT_NEAR(facts[0].depth, 21, 1e-9);
}

TEST(FindBlocking, TellsNarrowWidthsClosely) {
  for (const double width : {0.24, 0.3, 0.5, 0.8}) {
    const auto facts = facts_of(
        {part(block({0, 0, 0}, {40, 40, 10})), part(block({40 - width, 0, 20}, {60, 40, 21}))},
        {{0, 0, 1}}, with_tolerance(0.1));
    ASSERT_EQ(facts.size(), 1U) << width;
    EXPECT_NEAR(facts[0].width, width, 0.05);
  }
  for (const double width : {0.05, 0.1, 0.17, 0.2}) {
    const auto facts = facts_of(
        {part(block({0, 0, 0}, {40, 40, 10})), part(block({40 - width, 0, 20}, {60, 40, 21}))},
        {{0, 0, 1}}, with_tolerance(0.1));
    EXPECT_TRUE(facts.empty()) << width;
  }
}

TEST(FindBlocking, FindsAHairInALargeShadow) {
  // A wire askew over a plate of half a metre, as no line of a coarse raster may meet it.
  const double c = std::cos(0.3);
  const double s = std::sin(0.3);
  const Mesh wire = shapes::moved(block({50, 0, 20}, {300, 0.3, 20.3}), [&](const Vector3& p) {
    return Vector3{p[0] * c - p[1] * s, p[0] * s + p[1] * c, p[2]};
  });
  const auto facts = facts_of({part(block({0, 0, 0}, {500, 500, 5})), part(wire)}, {{0, 0, 1}},
                              with_tolerance(0.1));
  ASSERT_EQ(facts.size(), 1U);
  EXPECT_NEAR(facts[0].width, 0.3, 0.08);
}

TEST(FindBlocking, AnswersAlongAnyDirection) {
  // The slot of 4 across leans by atan(4 / 5): the piece slides along (4, 0, 5) and no other way in
  // the plane across the slot.
  const auto cases = shapes::made_cases();
  const auto slot = std::find_if(cases.begin(), cases.end(),
                                 [](const MadeCase& made) { return made.name == "slanted slot"; });
  ASSERT_NE(slot, cases.end());
  const double size = std::sqrt(41.0);
  const std::vector<Vector3> directions = {
      {4 / size, 0, 5 / size}, {-4 / size, 0, -5 / size}, {std::sqrt(0.5), 0, std::sqrt(0.5)}};
  const auto facts = facts_of({part(slot->a), part(slot->b)}, directions, with_tolerance(0.1));
  std::array<bool, 3> free = {true, true, true};
  for (const BlockingFact& fact : facts) {
    if (fact.part == 0) free[fact.direction] = false;
  }
  EXPECT_EQ(free, (std::array<bool, 3>{true, false, false}));
}

TEST(FindBlocking, GivesOppositeFactsOfOppositeDirections) {
  const auto facts =
      facts_of({part(block({0, 0, 0}, {1, 1, 1})), part(block({0.2, 0.1, 5}, {2, 2, 6}))},
               {{0, 0, -1}, {0, 0, 1}}, with_tolerance(0.01));
  ASSERT_EQ(facts.size(), 2U);
  EXPECT_EQ(std::tuple(facts[0].direction, facts[0].part, facts[0].by), std::tuple(0U, 1U, 0U));
  EXPECT_EQ(std::tuple(facts[1].direction, facts[1].part, facts[1].by), std::tuple(1U, 0U, 1U));
  EXPECT_EQ(facts[0].width, facts[1].width);
}

TEST(FindBlocking, DoesNotCatchOnFacesThatAreDrawnTooDeep) {
  // The upper block lies 0.3 too low and half beside the lower one: along x each stands in the way
  // of the other in a layer of 0.3, which is the drawing's error.
  const Mesh lower = block({0, 0, 0}, {10, 10, 10});
  EXPECT_EQ(words(free_of(lower, block({5, 0, 9.7}, {15, 10, 20}), 0.1)), "+x -x +y -y -z ");
  // A layer that is no error holds as before.
  EXPECT_EQ(words(free_of(lower, block({10, 0, 9.7}, {15, 10, 20}), 0.1)), "-x +y -y +z -z ");
  // And so does a hook beside the error: it reaches 1 under the lower block.
  const Mesh hook = shapes::laid_along_y(shapes::extruded(
      {{11, -5}, {11, 20}, {5, 20}, {5, 9.7}, {10.2, 9.7}, {10.2, -1}, {9, -1}, {9, -5}}, -10, 0));
  EXPECT_EQ(words(free_of(lower, hook, 0.1)), "-x +y -y ");
}

TEST(FindBlocking, KeepsAPartInsideOfACavity) {
  CadPart shell = part(block({0, 0, 0}, {10, 10, 10}));
  Mesh hollow = block({2, 2, 2}, {8, 8, 8});
  const auto base = static_cast<std::uint32_t>(shell.mesh.vertices.size());
  for (const Vector3& p : hollow.vertices) shell.mesh.vertices.push_back(p);
  for (const auto& t : hollow.triangles) {
    shell.mesh.triangles.push_back({base + t[1], base + t[0], base + t[2]});
  }
  const auto facts =
      facts_of({shell, part(block({4, 4, 4}, {6, 6, 6}))}, six_axes(), with_tolerance(0.1));
  EXPECT_EQ(facts.size(), 12U);
}

TEST(FindBlocking, JudgesOpenMeshesByTheirOutermostPoints) {
  Mesh sheet;
  sheet.vertices = {{0, 0, 5}, {10, 0, 5}, {10, 10, 5}, {0, 10, 5}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto free = free_of(sheet, block({2, 2, 5}, {8, 8, 9}), 0.1);
  EXPECT_EQ(words(free), "+x -x +y -y -z ");
}

TEST(FindBlocking, TakesMeshesThatAreInsideOut) {
  for (const MadeCase& made : some_cases()) {
    Mesh a = made.a;
    for (auto& t : a.triangles) std::swap(t[0], t[1]);
    EXPECT_EQ(words(free_of(a, made.b, made.tolerance)), words(made.free)) << made.name;
  }
}

TEST(FindBlocking, TakesNoTrianglesAndTrianglesWithoutArea) {
  CadPart flat = part(Mesh{});
  flat.mesh.vertices = {{0, 0, 0}, {5, 5, 5}, {0, 0, 0}};
  flat.mesh.triangles = {{0, 1, 2}, {1, 1, 1}};
  const auto facts = facts_of({part(Mesh{}), flat, part(block({0, 0, 7}, {9, 9, 9}))}, six_axes(),
                              with_tolerance(0.1));
  for (const BlockingFact& fact : facts) EXPECT_NE(fact.part, 0U);
  EXPECT_TRUE(facts_of({}, six_axes(), with_tolerance(0.1)).empty());
}

TEST(FindBlocking, StaysRightFarFromTheOriginAndAmongVastParts) {
  const Vector3 far = {1e6, -2e6, 3e6};
  for (const MadeCase& made : some_cases()) {
    const auto free =
        free_of(shapes::shifted(made.a, far), shapes::shifted(made.b, far), made.tolerance);
    EXPECT_EQ(words(free), words(made.free)) << made.name;
  }
  EXPECT_EQ(
      words(free_of(block({0, 0, 0}, {1e5, 1e5, 1e5}), block({0, 0, 2e5}, {1e5, 1e5, 3e5}), 0.1)),
      "+x -x +y -y -z ");
}

TEST(FindBlocking, EndsOnNumbersThatAreNone) {
  Mesh mesh = block({0, 0, 0}, {1, 1, 1});
  mesh.vertices[0][0] = std::numeric_limits<double>::quiet_NaN();
  mesh.vertices[3][2] = std::numeric_limits<double>::infinity();
  (void)facts_of({part(mesh), part(block({0, 0, 3}, {1, 1, 4}))}, six_axes(), with_tolerance(0.1));
}

TEST(FindBlocking, IsTheSameToTheLastBitForAnyNumberOfThreads) {
  std::vector<CadPart> parts;
  for (const MadeCase& made : shapes::made_cases()) {
    const Vector3 at = {static_cast<double>(parts.size()) * 12, 0, 0};
    parts.push_back(part(shapes::shifted(made.a, at)));
    parts.push_back(part(shapes::shifted(made.b, at)));
    if (parts.size() >= (percent_of_seeds() == 100 ? 16U : 8U)) break;
  }
  const auto one = facts_of(parts, six_axes(), with_tolerance(0.1, 1));
  ASSERT_GT(one.size(), 20U);
  for (const unsigned threads : {2U, 5U}) {
    const auto more = facts_of(parts, six_axes(), with_tolerance(0.1, threads));
    ASSERT_EQ(more.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(
          std::tuple(one[i].direction, one[i].part, one[i].by, one[i].width, one[i].depth),
          std::tuple(more[i].direction, more[i].part, more[i].by, more[i].width, more[i].depth));
    }
  }
}

TEST(FindBlocking, StopsWhenItIsTold) {
  std::stop_source source;
  source.request_stop();
  GeometrySettings settings;
  settings.stop = source.get_token();
  const std::vector<CadPart> parts = {part(block({0, 0, 0}, {1, 1, 1}))};
  EXPECT_THROW((void)find_blocking(parts, {}, six_axes(), settings), Interrupted);
  EXPECT_THROW((void)find_contacts(parts, settings), Interrupted);
  EXPECT_THROW((void)suggested_directions(parts, {}, settings), Interrupted);
}

}  // namespace
}  // namespace orasp
