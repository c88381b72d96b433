#include "orasp/fleet/fleet_heuristics.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/random.h"

namespace orasp {
namespace {

/// A tree whose part i hangs on part parents[i - 1] < i, along one of `dimensions` axes.
Problem tree(const std::vector<std::size_t>& parents, std::size_t robots, std::size_t sites,
             std::uint64_t seed = 0, std::size_t dimensions = 1) {
  SplitMix64 random(seed);
  ProblemSpec spec;
  for (std::size_t i = 0; i <= parents.size(); ++i)
    spec.parts.push_back({std::to_string(i), "", 1, {}});
  for (std::size_t i = 1; i <= parents.size(); ++i) {
    Connection connection;
    connection.parts = {std::to_string(parents[i - 1]), std::to_string(i)};
    connection.axis = kDirectionNames[random.below(2 * dimensions)];
    spec.connections.push_back(connection);
  }
  Fleet fleet;
  fleet.robots = robots;
  for (std::size_t s = 1; s <= sites; ++s) fleet.sites.push_back({static_cast<double>(s), 0.0});
  spec.fleet = fleet;
  spec.objective = Objective::named("makespan");
  return Problem(spec);
}

std::vector<std::size_t> chain_parents(std::size_t parts) {
  std::vector<std::size_t> parents;
  for (std::size_t i = 1; i < parts; ++i) parents.push_back(i - 1);
  return parents;
}

std::size_t states(const Problem& problem, const std::string& method) {
  const FleetProblem fleet(problem);
  const Result result = solve(problem, method);
  EXPECT_TRUE(result.has_plan()) << method;
  EXPECT_TRUE(evaluate(fleet, result.fleet_plan).valid) << method;
  return result.fleet_plan.makespan() + 1;
}

TEST(FleetHeuristics, CountAsThePublishedOnesDo) {
  const Problem hubble = load_scenario("fleet-hubble");
  EXPECT_EQ(states(hubble, "fast"), 8U);
  EXPECT_EQ(states(hubble, "greedy"), 8U);
  const Problem iss = load_scenario("fleet-iss");
  EXPECT_EQ(states(iss, "fast"), 9U);
  EXPECT_EQ(states(iss, "greedy"), 9U);
  const Problem chain = tree(chain_parents(50), 10, 4);
  EXPECT_EQ(states(chain, "fast"), 11U);
  EXPECT_EQ(states(chain, "greedy"), 26U);
}

TEST(FleetHeuristics, GreedyTravelsAsPublished) {
  // Sites as in the published heuristics; every part goes from the first one to the depot: 20
  // sqrt(2) = 28.2843 in plain distance, 20 * 2 in squared distance, which is what plans count.
  ProblemSpec spec = load_scenario("fleet-hubble").spec();
  spec.fleet->sites = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  const Problem problem = Problem(spec).with_objective(Objective::named("fleet_travel"));
  const Result result = fleet_greedy(FleetProblem(problem), {}, {});
  double plain = 0;
  for (const FleetStep& step : result.fleet_plan.steps) {
    for (const FleetMove& move : step.moves)
      plain += std::sqrt(move.distance / static_cast<double>(move.parts.size())) *
               static_cast<double>(move.parts.size());
  }
  EXPECT_NEAR(plain, 28.2843, 5e-5);
  EXPECT_NEAR(result.reward, -40, 1e-9);
}

TEST(FleetHeuristics, AStarByHand) {
  // Part 0 in the middle of five. Two robots: two leaves, two leaves, then the last leaf with the
  // middle: three steps. The published count would free the last leaf first and leave the middle
  // alone for a step of its own.
  EXPECT_EQ(states(tree({0, 0, 0, 0, 0}, 2, 1), "fast"), 4U);
  // Six robots take all at once.
  EXPECT_EQ(states(tree({0, 0, 0, 0, 0}, 6, 1), "fast"), 2U);
}

TEST(FleetHeuristics, FastCarriesSubassembliesOffWhereGreedyDoesNot) {
  const Problem problem = tree(chain_parents(16), 6, 3);
  const FleetProblem fleet(problem);
  const Result fast = fleet_fast(fleet, {}, {});
  const Result greedy = fleet_greedy(fleet, {}, {});
  EXPECT_LT(fast.fleet_plan.makespan(), greedy.fleet_plan.makespan());
  EXPECT_TRUE(std::ranges::any_of(fast.fleet_plan.steps, [](const FleetStep& step) {
    return std::ranges::any_of(step.moves,
                               [](const FleetMove& move) { return move.parts.size() > 1; });
  }));
}

TEST(FleetHeuristics, PlansOfRandomTreesKeepEveryRuleAndTakeNoFewerStepsThanTheBest) {
  SplitMix64 random(11);
  int planned = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<std::size_t> parents;
    const std::size_t parts = 2 + random.below(10);
    for (std::size_t p = 1; p < parts; ++p) parents.push_back(random.below(p));
    const Problem problem =
        tree(parents, 2 + random.below(4), 1 + random.below(4), random.next(), 3);
    const FleetProblem fleet(problem);
    const Result best = solve(problem, "fleet-search");
    ASSERT_EQ(status_name(best.status), "optimal");
    for (const char* method : {"fast", "greedy"}) {
      const Result result = solve(problem, method);
      ASSERT_TRUE(result.has_plan()) << i << ' ' << method << ": " << result.notes.front();
      EXPECT_TRUE(evaluate(fleet, result.fleet_plan).valid);
      EXPECT_GE(result.fleet_plan.makespan(), best.fleet_plan.makespan()) << i << ' ' << method;
      ++planned;
    }
  }
  EXPECT_EQ(planned, 600);
}

TEST(FleetHeuristics, PlanForLargeTrees) {
  std::vector<std::size_t> parents;
  SplitMix64 random(5);
  for (std::size_t p = 1; p < 500; ++p) parents.push_back(random.below(p));
  const Problem problem = tree(parents, 20, 4);
  EXPECT_GE(states(problem, "greedy"), 26U);  // 500 parts, 20 robots
  EXPECT_GE(states(problem, "fast"), 26U);
}

TEST(FleetHeuristics, WhatTheyDoNotLookAtIsSaid) {
  // The rule is in the way of the first leaf.
  ProblemSpec spec = tree(chain_parents(4), 2, 1).spec();
  spec.precedence = {{"0-1", {"1-2"}, {}}};
  const Problem problem(spec);
  const Result result = fleet_greedy(FleetProblem(problem), {}, {});
  EXPECT_EQ(status_name(result.status), "unknown");
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_NE(result.notes[0].find("breaks a rule that it does not look at: step 1: "),
            std::string::npos)
      << result.notes[0];

  const Problem one_robot = tree(chain_parents(4), 1, 1);
  EXPECT_EQ(fleet_fast(FleetProblem(one_robot), {}, {}).notes[0],
            "no further step: 1 robot is too few for this heuristic");
  const Problem hubble = load_scenario("fleet-hubble");
  EXPECT_EQ(fleet_fast(FleetProblem(hubble), {.steps = 3}, {}).notes[0],
            "the heuristic's plan takes 7 steps, more than allowed");
}

TEST(FleetHeuristics, ACycleIsRefusedByName) {
  const Problem lattice = load_scenario("fleet-lattice");
  try {
    static_cast<void>(fleet_fast(FleetProblem(lattice), {}, {}));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "fast plans for products whose connections form no cycle, and connection \"2-5\" "
                 "closes one");
  }
}

}  // namespace
}  // namespace orasp
