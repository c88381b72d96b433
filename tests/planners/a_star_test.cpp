#include "orasp/planners/a_star.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "orasp/orasp.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

constexpr BoundKind kBounds[] = {BoundKind::None, BoundKind::Connections, BoundKind::Sizes,
                                 BoundKind::Parts, BoundKind::Best};

Result run(const Problem& problem, BoundKind bound = BoundKind::Best, const Budget& budget = {}) {
  const TransitionSystem system(problem);
  return a_star(system, {.bound = bound}, budget);
}

// The point of the method. H has 1,296 and 12,096 states.
TEST(AStar, ExpandsFarFewerStatesThanThereAre) {
  const Result lattice = run(load_scenario("lattice"));
  EXPECT_EQ(status_name(lattice.status), "optimal");
  EXPECT_NEAR(lattice.reward, 0.0735, 1e-9);
  EXPECT_LE(lattice.statistics.expanded, 1'296U / 20);
  const Result hubble = run(load_scenario("hubble"));
  EXPECT_EQ(status_name(hubble.status), "optimal");
  EXPECT_NEAR(hubble.reward, -0.9902, 1e-9);
  EXPECT_LE(hubble.statistics.expanded, 12'096U / 20);
}

// With the paper's bound it still need not see all of H, and a stronger bound leaves less to see.
TEST(AStar, AStrongerBoundLeavesLessToExpand) {
  for (const char* name : {"lattice", "hubble"}) {
    SCOPED_TRACE(name);
    const Problem problem = load_scenario(name);
    const std::uint64_t none = run(problem, BoundKind::None).statistics.expanded;
    const std::uint64_t sizes = run(problem, BoundKind::Sizes).statistics.expanded;
    const std::uint64_t best = run(problem, BoundKind::Best).statistics.expanded;
    EXPECT_LT(2 * sizes, none);
    EXPECT_LE(best, sizes);
  }
}

TEST(AStar, EveryBoundGivesTheSameOptimum) {
  std::size_t solved = 0;
  std::size_t refused = 0;
  std::size_t infeasible = 0;
  for (std::uint64_t seed = 0; seed < some_of(150U); ++seed) {
    const ProblemSpec spec = larger_random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const Result truth = solve(problem, "value-iteration");
    for (const BoundKind bound : kBounds) {
      SCOPED_TRACE(kBoundNames[static_cast<std::size_t>(bound)]);
      try {
        const Result result = run(problem, bound);
        EXPECT_EQ(status_name(result.status), status_name(truth.status));
        if (!truth.has_plan()) {
          ++infeasible;
          continue;
        }
        ++solved;
        EXPECT_NEAR(result.reward, truth.reward, reward_tolerance(truth.reward));
        const Evaluation replay = evaluate(problem, result.sequence);
        EXPECT_TRUE(replay.valid);
        EXPECT_NEAR(replay.reward, truth.reward, reward_tolerance(truth.reward));
        EXPECT_LE(result.statistics.states, truth.statistics.states);
      } catch (const InputError&) {
        ++refused;
      }
    }
  }
  EXPECT_GE(solved, least_of(200U));
  EXPECT_GE(refused, least_of(50U)) << "bounds that know nothing about the objective";
  EXPECT_GE(infeasible, least_of(50U));
}

// Consistent bounds: no state is expanded again but for rounding.
TEST(AStar, ExpandsNoStateTwice) {
  for (const char* name : {"2x3", "lattice", "hubble"}) {
    for (const char* type :
         {"cubesat", "cubesat_zone", "custom", "indexed", "time", "completion"}) {
      SCOPED_TRACE(std::string(name) + ", " + type);
      const Result result = run(load_scenario(name).with_objective(Objective::named(type)));
      EXPECT_EQ(status_name(result.status), "optimal");
      EXPECT_LE(result.statistics.expanded, result.statistics.states);
    }
  }
}

// Stopped anywhere, the bound is above the optimum and the plan below it.
TEST(AStar, GivesATrueBoundWhereverItIsStopped) {
  const Problem problem = load_scenario("lattice").with_objective(Objective::named("indexed"));
  double before = std::numeric_limits<double>::infinity();
  for (std::uint64_t limit = 1; limit < 255; limit = limit * 3 / 2 + 1) {
    SCOPED_TRACE(limit);
    Budget budget;
    budget.max_expansions = limit;
    const Result result = run(problem, BoundKind::Connections, budget);
    ASSERT_EQ(stop_name(result.stop), "expansion limit");
    ASSERT_TRUE(result.has_plan());
    EXPECT_EQ(status_name(result.status), "feasible");
    EXPECT_LE(result.reward, 34 + 1e-9);
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_GE(*result.bound, 34 - 1e-9);
    EXPECT_LE(*result.bound, before + 1e-7) << "the bound only falls";
    before = *result.bound;
  }
}

TEST(AStar, RefusesABoundThatKnowsNothing) {
  ProblemSpec spec = instances::greedy_trap();
  spec.objective = Objective::named("indexed");
  for (const BoundKind bound : {BoundKind::None, BoundKind::Sizes, BoundKind::Parts}) {
    EXPECT_THROW((void)run(Problem(spec), bound), InputError);
  }
  EXPECT_EQ(status_name(run(Problem(spec), BoundKind::Connections).status), "optimal");
}

}  // namespace
}  // namespace orasp
