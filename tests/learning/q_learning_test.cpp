#include "orasp/learning/q_learning.h"

#include <cstddef>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "orasp/orasp.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/random_problems.h"

namespace orasp {
namespace {

Result learn(const Problem& problem, const QLearningOptions& options = {},
             const Budget& budget = {}) {
  const TransitionSystem system(problem);
  return q_learning(system, options, budget);
}

// From values that know only what each connection can earn, it must find out the rest by itself.
TEST(QLearning, ConvergesToTheOptimumFromEverySeed) {
  for (const char* name : {"4brick", "2x3", "lattice"}) {
    const double best = solve(load_scenario(name), "value-iteration").reward;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(std::string(name) + ", seed " + std::to_string(seed));
      const Result result =
          learn(load_scenario(name), {.seed = seed, .bound = BoundKind::Connections});
      EXPECT_EQ(status_name(result.status), "optimal");
      EXPECT_NEAR(result.reward, best, 1e-9);
      EXPECT_NEAR(result.bound.value(), best, 1e-9);
    }
  }
}

// One episode cannot do: the greedy start of instances::greedy_trap must be unlearned.
TEST(QLearning, UnlearnsWhatLooksGoodAtFirst) {
  const Problem problem(instances::greedy_trap());
  const Result result = learn(problem, {.seed = 1, .bound = BoundKind::Connections});
  EXPECT_NEAR(result.reward, 0.5570, 1e-12);
  EXPECT_GT(result.statistics.sweeps, 1U);
}

// A better start leaves less to learn.
TEST(QLearning, ABetterBoundLeavesLessToLearn) {
  const Problem problem = load_scenario("lattice");
  const Result connections = learn(problem, {.bound = BoundKind::Connections});
  const Result best = learn(problem, {.bound = BoundKind::Best});
  EXPECT_LT(2 * best.statistics.states, connections.statistics.states);
  EXPECT_LT(2 * best.statistics.sweeps, connections.statistics.sweeps);
  EXPECT_LE(connections.statistics.states, 1'296U);
}

TEST(QLearning, AgreesWithValueIterationOnRandomProblems) {
  std::size_t solved = 0;
  std::size_t infeasible = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    const ProblemSpec spec = larger_random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const Result truth = solve(problem, "value-iteration");
    for (const BoundKind bound : {BoundKind::Connections, BoundKind::Best}) {
      const Result result = learn(problem, {.seed = seed, .bound = bound});
      EXPECT_EQ(status_name(result.status), status_name(truth.status));
      if (truth.has_plan()) {
        ++solved;
        EXPECT_NEAR(result.reward, truth.reward, reward_tolerance(truth.reward));
        const Evaluation replay = evaluate(problem, result.sequence);
        EXPECT_TRUE(replay.valid);
        EXPECT_NEAR(replay.reward, result.reward, reward_tolerance(truth.reward));
      } else {
        ++infeasible;
      }
    }
  }
  EXPECT_GE(solved, 80U);
  EXPECT_GE(infeasible, 20U);
}

// Stopped anywhere, its values are still an upper bound, which only falls.
TEST(QLearning, BoundsTheOptimumWhereverItIsStopped) {
  const Problem problem = load_scenario("lattice");
  double before = std::numeric_limits<double>::infinity();
  std::size_t stopped = 0;
  for (const std::uint64_t limit : {1U, 30U, 100U, 300U, 600U}) {
    Budget budget;
    budget.max_expansions = limit;
    const Result result = learn(problem, {.seed = 3, .bound = BoundKind::Connections}, budget);
    ASSERT_TRUE(result.has_plan());
    EXPECT_LE(result.reward, 0.0735 + 1e-9);
    EXPECT_TRUE(evaluate(problem, result.sequence).valid);
    if (result.status == Status::Optimal) continue;
    ++stopped;
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_GE(*result.bound, 0.0735 - 1e-9);
    EXPECT_LE(*result.bound, before + 1e-9);
    before = *result.bound;
  }
  EXPECT_GE(stopped, 2U);
}

}  // namespace
}  // namespace orasp
