// Planning forwards (direction assembly): where a forward step earns what the backward step of the
// same cut earns, both directions have the same optimum, by every exact planner; where it does not,
// they differ as worked out by hand.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/learning/environment.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "tests/checks.h"
#include "tests/random_problems.h"

namespace orasp {
namespace {

/// Objectives whose steps earn the same in both directions. piece_cost is none of them, even with
/// completion 0: its last step is free, and the last step cuts other pieces than it joins.
std::vector<Objective> symmetric_objectives(const ProblemSpec& spec) {
  std::vector<Objective> objectives = {
      parse_objective(
          R"json({"type": "expression", "formula": "-(moved_parts * kept_parts + kept_mass)"})json",
          "objective"),
      Objective("time", TimeObjective{.depot = {1, 0, 0}, .speed = 2}),
      Objective("fuel", Fuel{.dry_mass = 2, .delta_v = 50}),
      Objective("completion", CompletionObjective{.join = 3, .step = 1, .bonus = 0}),
  };
  if (std::ranges::all_of(spec.parts, [](const Part& part) { return part.position.has_value(); })) {
    objectives.emplace_back("travel", Travel{.depot = {0, 1, 0}});
    objectives.emplace_back("sum", WeightedSum{{{0.5, objectives[2]}, {2, objectives.back()}}});
  }
  return objectives;
}

/// Planners that prove an optimum without trying every sequence.
std::vector<const Planner*> exact_planners(const Problem& problem) {
  std::vector<const Planner*> chosen;
  constexpr std::size_t kMostForAllSequences = 6;
  for (const Planner* const planner : one_robot_planners()) {
    const bool serves =
        planner->role == Role::Search ||
        (planner->role == Role::Check && problem.num_connections() <= kMostForAllSequences);
    if (planner->exact && serves && !obstacle(problem, planner->name)) chosen.push_back(planner);
  }
  return chosen;
}

void expect_same_both_ways(const Problem& backward, bool every_planner) {
  const Problem forward = backward.with_direction(Direction::Assembly);
  const Result truth = solve(backward, "value-iteration", quick_options(), Budget{});
  for (const Planner* planner : exact_planners(forward)) {
    if (!every_planner && planner->obstacle != find_planner("dijkstra").obstacle) continue;
    SCOPED_TRACE(planner->name);
    const Result result = solve(forward, planner->name, quick_options(), Budget{});
    ASSERT_EQ(result.status, truth.status);
    if (!truth.has_plan()) continue;
    EXPECT_NEAR(result.reward, truth.reward, reward_tolerance(truth.reward));
    // Its reverse is a plan of the same reward the other way round.
    std::vector<ConnectionIndex> reversed(result.sequence.rbegin(), result.sequence.rend());
    const Evaluation replayed = evaluate(backward, std::span<const ConnectionIndex>(reversed));
    EXPECT_TRUE(replayed.valid);
    EXPECT_NEAR(replayed.reward, truth.reward, reward_tolerance(truth.reward));
  }
}

TEST(Forward, SymmetricRewardsHaveOneOptimumOnRandomProblems) {
  int feasible = 0;
  for (std::uint64_t seed = 0; seed < 240; ++seed) {
    ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    spec.direction = Direction::Disassembly;
    for (const Objective& objective : symmetric_objectives(spec)) {
      SCOPED_TRACE(objective.type);
      spec.objective = objective;
      const Problem problem(spec);
      expect_same_both_ways(problem, true);
      if (solve(problem, "greedy", {}, Budget{}).has_plan()) ++feasible;
      if (testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GT(feasible, 300);
}

TEST(Forward, SymmetricRewardsHaveOneOptimumOnTheScenarios) {
  for (const char* name : {"3piece", "4brick", "4piece", "2x3", "lattice", "hubble"}) {
    SCOPED_TRACE(name);
    const Problem scenario = load_scenario(name);
    for (const Objective& objective : symmetric_objectives(scenario.spec())) {
      SCOPED_TRACE(objective.type);
      expect_same_both_ways(
          scenario.with_objective(objective).with_direction(Direction::Disassembly),
          scenario.num_connections() <= 12);
    }
  }
}

ProblemSpec chain_of_three(Objective objective) {
  ProblemSpec spec;
  spec.parts.resize(3);
  for (std::size_t i = 0; i < 3; ++i) spec.parts[i].id = std::to_string(i + 1);
  spec.connections.resize(2);
  spec.connections[0].parts = {"1", "2"};
  spec.connections[1].parts = {"2", "3"};
  spec.objective = std::move(objective);
  return spec;
}

std::array<double, 2> both_optima(const Objective& objective) {
  const Problem problem(chain_of_three(objective));
  std::array<double, 2> optima{};
  for (const Planner* planner : exact_planners(problem)) {
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      const Result result =
          solve(problem.with_direction(direction), planner->name, quick_options(), Budget{});
      EXPECT_EQ(result.status, Status::Optimal) << planner->name;
      double& optimum = optima[direction == Direction::Assembly ? 1 : 0];
      if (optimum != 0) {
        EXPECT_NEAR(result.reward, optimum, 1e-12) << planner->name;
      }
      optimum = result.reward;
    }
  }
  return optima;
}

TEST(Forward, RewardsThatSeeTheEndOrTheOrderDifferAsByHand) {
  // cubesat: backwards the first cut costs a single part and a pair, the last earns 1; forwards the
  // first join costs two single parts, the last, of the pair and a part, earns 1.
  const auto cubesat = both_optima(Objective::named("cubesat"));
  EXPECT_NEAR(cubesat[0], 1 - 0.0967 - 0.1248, 1e-12);
  EXPECT_NEAR(cubesat[1], 1 - 2 * 0.0967, 1e-12);
  // indexed: backwards n = 2 and i = 0 earns 2, then n = 1 and i = 1 earns -1. Forwards n = 0, then
  // n = 1: i < n - 1 never holds, -1 twice.
  const auto indexed = both_optima(Objective::named("indexed"));
  EXPECT_EQ(indexed[0], 1);
  EXPECT_EQ(indexed[1], -2);
  // A callable that pays for the larger piece kept when few connections are there before the step:
  // forwards with none before (kept: one part) then one (kept: two); backwards with two before
  // (kept: two), then one (kept: one).
  const auto callable = both_optima(Objective(
      "callable", Callable{.name = "kept by before", .reward = [](const Step& step) {
                             return static_cast<double>(step.kept().size() * (3 - step.before));
                           }}));
  EXPECT_EQ(callable[0], 2 * 1 + 1 * 2);
  EXPECT_EQ(callable[1], 1 * 3 + 2 * 2);
}

TEST(Forward, TheEnvironmentEarnsWhatTheCheckerSays) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    spec.direction = Direction::Assembly;
    const Problem problem(spec);
    const TransitionSystem system(problem);
    Environment world(system, 1);
    SplitMix64 random(seed);
    std::vector<ConnectionIndex> sequence;
    double reward = 0;
    while (!world.actions(0).empty()) {
      const auto actions = world.actions(0);
      sequence.push_back(actions[random.below(actions.size())].connection);
      reward += world.step(0, sequence.back());
    }
    const Evaluation replayed = evaluate(problem, std::span<const ConnectionIndex>(sequence));
    EXPECT_NEAR(replayed.reward, reward, reward_tolerance(reward));
    if (system.infeasibility()) continue;
    EXPECT_EQ(replayed.valid, sequence.size() == problem.num_connections());
  }
}

}  // namespace
}  // namespace orasp
