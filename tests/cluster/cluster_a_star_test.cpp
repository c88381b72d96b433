#include "orasp/cluster/cluster_a_star.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "orasp/model/error.h"
#include "orasp/model/scenario_generators.h"
#include "tests/checks.h"
#include "tests/cluster/thread_ranks.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

std::vector<Result> a_star_on_ranks(const Problem& problem, std::size_t count,
                                    const Budget& budget = {}) {
  const TransitionSystem system(problem);
  return on_thread_ranks(count,
                         [&](Ranks& ranks) { return cluster_a_star(system, {}, budget, ranks); });
}

/// The same optimum, status and bound as in one process, on every rank.
Result expect_optimum_of_one_process(const Problem& problem, std::size_t count) {
  const Result expected = a_star(TransitionSystem(problem), {}, {});
  const std::vector<Result> results = a_star_on_ranks(problem, count);
  for (const Result& result : results) {
    EXPECT_EQ(status_name(result.status), status_name(expected.status));
    EXPECT_EQ(result.sequence, results[0].sequence);
    EXPECT_EQ(result.has_plan(), expected.has_plan());
    if (!expected.has_plan()) continue;
    const double tolerance = reward_tolerance(expected.reward);
    EXPECT_NEAR(result.reward, expected.reward, tolerance);
    EXPECT_NEAR(*result.bound, *expected.bound, tolerance);
    EXPECT_EQ(result.stop, Stop::None);
  }
  return results[0];
}

// A block of seeds a test, as in agreement_test.cpp.
class ClusterAStarAgreement : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Seeds, ClusterAStarAgreement, testing::Range(0, 6));

TEST_P(ClusterAStarAgreement, AnyNumberOfRanksIsRightAboutEveryProblem) {
  constexpr std::uint64_t kProblemsInBlock = 60;
  int taken = 0;
  for (std::uint64_t i = 0; i < some_of(kProblemsInBlock); ++i) {
    const std::uint64_t seed = static_cast<std::uint64_t>(GetParam()) * kProblemsInBlock + i;
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    if (system.wide()) continue;
    try {
      static_cast<void>(a_star(system, {}, {}));
    } catch (const InputError&) {
      EXPECT_THROW(static_cast<void>(a_star_on_ranks(problem, 3)), InputError);
      continue;
    }
    ++taken;
    const Result result = expect_optimum_of_one_process(problem, 1 + seed % 8);
    expect_honest(problem, oracle::brute_force(spec), find_planner("a-star"), result);
    if (HasFailure()) return;
  }
  EXPECT_GE(taken, least_of(40));
}

// Problems too large for brute force, with thousands of states.
TEST(ClusterAStar, LargerProblemsAreAsInOneProcess) {
  for (std::uint64_t seed = 0; seed < some_of(40U); ++seed) {
    const Problem problem(larger_random_problem(seed));
    SCOPED_TRACE(seed);
    if (TransitionSystem(problem).wide()) continue;
    try {
      static_cast<void>(a_star(TransitionSystem(problem), {}, {}));
    } catch (const InputError&) {
      continue;
    }
    static_cast<void>(expect_optimum_of_one_process(problem, 2 + seed % 4));
  }
}

TEST(ClusterAStar, ScenariosAreAsInOneProcess) {
  for (const char* const name : {"hubble", "hubble-upc", "hubble-free", "lattice"}) {
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      ProblemSpec spec = load_scenario(name).spec();
      spec.direction = direction;
      SCOPED_TRACE(name);
      static_cast<void>(expect_optimum_of_one_process(Problem(spec), 3));
    }
  }
}

// No bound settles it: tens of thousands of states on their way.
TEST(ClusterAStar, ManyStatesAreAsInOneProcess) {
  ProblemSpec spec = grid(3, 4);
  spec.objective = chance_objective();
  const Result result = expect_optimum_of_one_process(Problem(spec), 4);
  EXPECT_GT(result.statistics.expanded, 1000U);
}

TEST(ClusterAStar, AStopOfOneRankIsOneOfAllAndTheBoundIsProved) {
  ProblemSpec spec = grid(3, 4);
  spec.objective = chance_objective();
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const double best = a_star(system, {}, {}).reward;
  for (const std::size_t stopped : {0U, 1U, 2U}) {
    for (const std::uint64_t expansions : {1U, 64U, 640U}) {
      const auto results = on_thread_ranks(3, [&](Ranks& ranks) {
        Budget budget;
        if (ranks.rank() == stopped) budget.max_expansions = expansions;
        return cluster_a_star(system, {}, budget, ranks);
      });
      for (const Result& result : results) EXPECT_EQ(result.stop, Stop::ExpansionLimit);
      EXPECT_EQ(status_name(results[0].status), "feasible");
      EXPECT_LE(results[0].reward, best + 1e-9);
      ASSERT_TRUE(results[0].bound.has_value());
      EXPECT_GE(*results[0].bound, best - 1e-9);
    }
  }
}

TEST(ClusterAStar, AFaultOfOneRankIsThrownByAll) {
  ProblemSpec spec = grid(3, 3);
  Callable callable;
  callable.reward = [](const Step& step) {
    return step.before == 6 && step.connection == 3 ? std::nan("") : 1.0;
  };
  callable.least = 0;
  callable.greatest = 1;
  spec.objective = {"callable", callable};
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const auto thrown = faults_on_thread_ranks(
      4, [&](Ranks& ranks) { return cluster_a_star(system, {}, {}, ranks); });
  for (const std::string& fault : thrown) EXPECT_EQ(fault.empty(), thrown[0].empty());
}

}  // namespace
}  // namespace orasp
