#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/io/formula_parser.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/problem.h"
#include "orasp/model/random.h"
#include "orasp/model/transition_system.h"
#include "tests/seeds.h"
#include "tests/wide_oracle.h"

namespace orasp {
namespace {

/// One that sees the piece only.
Objective random_objective(SplitMix64& random) {
  const auto named = [&] {
    constexpr std::array kNames = {"cubesat", "cubesat_zone", "custom", "fuel", "completion"};
    return Objective::named(kNames[random.below(kNames.size())]);
  };
  switch (random.below(4)) {
    case 0:
      return Objective(
          "expression",
          Expression{.formula = "-moved_mass * (1 + kept_parts) - duration + 3 * completes",
                     .compiler = compile_formula});
    case 1: {
      WeightedSum sum;
      sum.terms.push_back({2, named()});
      sum.terms.push_back({-0.5, named()});
      return Objective("sum", sum);
    }
    default: return named();
  }
}

/// Up to eight parts that hang together at random in one piece or two, taken off or put on in any
/// connected sets; objectives that see the piece only, limits, blocking, a base and precedence.
ProblemSpec random_part_steps(std::uint64_t seed) {
  SplitMix64 random(seed);
  ProblemSpec spec;
  spec.action = StepKind::Part;
  spec.direction = random.below(2) == 0 ? Direction::Disassembly : Direction::Assembly;
  spec.objective = random_objective(random);
  const std::size_t parts = 2 + random.below(6);
  for (std::size_t p = 0; p < parts; ++p) {
    Part& part = spec.parts.emplace_back();
    part.id = "p" + std::to_string(p);
    part.mass = static_cast<double>(1 + random.below(9));
    part.position =
        Vector3{static_cast<double>(random.below(5)), static_cast<double>(random.below(5)), 0};
  }
  const auto join = [&](std::size_t a, std::size_t b) {
    Connection& connection = spec.connections.emplace_back();
    connection.id = "c" + std::to_string(spec.connections.size());
    connection.parts = {"p" + std::to_string(a), "p" + std::to_string(b)};
    connection.duration = static_cast<double>(random.below(4));
  };
  const std::size_t second = random.below(4) == 0 ? 1 + random.below(parts) : parts;
  for (std::size_t p = 1; p < parts; ++p) {
    if (p != second) join(p < second ? random.below(p) : second + random.below(p - second), p);
  }
  for (std::size_t more = random.below(5); more > 0; --more) {
    const std::size_t a = random.below(parts);
    const std::size_t b = random.below(parts);
    if (a != b && (a < second) == (b < second)) join(a, b);
  }
  if (random.below(3) == 0) spec.limits.max_moved_parts = 1 + random.below(3);
  if (random.below(4) == 0) spec.limits.max_subassemblies = 1 + random.below(2);
  if (random.below(4) == 0) spec.base.push_back("p0");
  if (random.below(2) == 0) {
    Blocking& blocking = spec.blocking.emplace();
    blocking.directions = {"+x", "-x", "+y", "-y"};
    for (std::size_t i = 0; i < 2 * parts; ++i) {
      const std::size_t part = random.below(parts);
      const std::size_t by = random.below(parts);
      if (part == by) continue;
      Blocked fact{.part = "p" + std::to_string(part), .by = "p" + std::to_string(by)};
      for (const char* const direction : {"+x", "-x", "+y", "-y"}) {
        if (random.below(3) == 0) fact.directions.emplace_back(direction);
      }
      if (!fact.directions.empty()) blocking.blocked.push_back(std::move(fact));
    }
  }
  const std::size_t connections = spec.connections.size();
  for (std::size_t i = random.below(3); i > 0 && connections > 1; --i) {
    const std::size_t a = random.below(connections);
    const std::size_t b = random.below(connections);
    if (a == b) continue;
    Precedence& clause = spec.precedence.emplace_back();
    clause.connection = spec.connections[a].id;
    clause.after = {spec.connections[b].id};
  }
  return spec;
}

TEST(PartTrees, WhatAndOrSaysOfStepsThatTakePartsOffIsTrue) {
  std::size_t asked = 0;
  std::size_t optimal = 0;
  std::size_t without_plan = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(600); ++seed) {
    const ProblemSpec spec = random_part_steps(seed);
    const Problem problem(spec);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + problem_text(problem));
    if (obstacle(problem, "and-or")) continue;
    ++asked;
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    const Result result = solve(problem, "and-or");
    if (!truth.best) {
      EXPECT_FALSE(result.has_plan());
      without_plan += result.status == Status::Infeasible ? 1 : 0;
      continue;
    }
    ASSERT_NE(result.status, Status::Infeasible);
    const bool proved = result.status == Status::Optimal;
    EXPECT_GE(result.bound.value_or(kInfinity), *truth.best - 1e-9);
    EXPECT_LE(result.reward, *truth.best + 1e-9);
    EXPECT_TRUE(!proved || std::abs(result.reward - *truth.best) < 1e-9);
    const bool between_pieces = spec.limits.max_subassemblies || !spec.precedence.empty();
    EXPECT_TRUE(proved || between_pieces);
    optimal += proved ? 1 : 0;
  }
  EXPECT_GE(asked, least_of(500U));
  EXPECT_GE(optimal, least_of(300U));
  EXPECT_GE(without_plan, least_of(20U));
}

TEST(PartTrees, AStarIsParted) {
  // Its middle comes off all others at once, or they come off it one by one.
  ProblemSpec spec;
  spec.action = StepKind::Part;
  spec.objective = Objective::named("custom");
  spec.parts.emplace_back().id = "middle";
  for (int i = 0; i < 9; ++i) {
    const std::string arm = "arm " + std::to_string(i);
    spec.parts.emplace_back().id = arm;
    Connection& connection = spec.connections.emplace_back();
    connection.id = "c" + std::to_string(i);
    connection.parts = {"middle", arm};
  }
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    spec.direction = direction;
    const Result free = solve(Problem(spec), "and-or");
    EXPECT_EQ(free.status, Status::Optimal);
    EXPECT_EQ(free.steps.size(), 1U);
    EXPECT_DOUBLE_EQ(free.reward, 1);
    spec.base = {"middle"};
    const Result fixed = solve(Problem(spec), "and-or");
    EXPECT_EQ(fixed.status, Status::Optimal);
    EXPECT_EQ(fixed.steps.size(), 9U);
    spec.base.clear();
  }
}

/// A tree of parts at random.
ProblemSpec tree_of(int parts) {
  SplitMix64 random(5);
  ProblemSpec spec;
  spec.action = StepKind::Part;
  spec.objective = Objective::named("fuel");
  for (int p = 0; p < parts; ++p) {
    Part& part = spec.parts.emplace_back();
    part.id = "p" + std::to_string(p);
    part.mass = 1.0 + p;
    if (p == 0) continue;
    Connection& connection = spec.connections.emplace_back();
    connection.id = "c" + std::to_string(p);
    connection.parts = {"p" + std::to_string(random.below(static_cast<std::uint64_t>(p))), part.id};
  }
  return spec;
}

TEST(PartTrees, ItEndsAtItsLimitWithAPlanAndABound) {
  Budget few;
  few.max_expansions = 3;
  // Of 40 parts not even the first steps are listed in so short a time.
  const std::pair<int, Budget> limited[] = {{14, few}, {40, Budget::with_time_limit(0.05)}};
  for (const auto& [parts, budget] : limited) {
    const Result result = solve(Problem(tree_of(parts)), "and-or", {}, budget);
    ASSERT_TRUE(result.has_plan());
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_GE(*result.bound, result.reward);
    EXPECT_NE(result.stop, Stop::None);
  }
}

TEST(PartTrees, WhereNothingIsToBeDoneThePlanIsEmpty) {
  ProblemSpec spec;
  spec.action = StepKind::Part;
  spec.objective =
      Objective("expression", Expression{.formula = "-moved_mass", .compiler = compile_formula});
  for (const char* const id : {"left", "right"}) {
    spec.parts.emplace_back().id = id;
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      spec.direction = direction;
      for (const char* const method : {"and-or", "auto"}) {
        const Result result = solve(Problem(spec), method);
        EXPECT_EQ(result.status, Status::Optimal) << method;
        EXPECT_EQ(result.reward, 0);
        EXPECT_TRUE(result.steps.empty());
      }
    }
  }
}

}  // namespace
}  // namespace orasp
