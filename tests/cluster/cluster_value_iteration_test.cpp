#include "orasp/cluster/cluster_value_iteration.h"

#include <bit>
#include <cmath>
#include <string>

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

using Values = DenseValueIterationOptions::Values;

std::vector<Result> on_ranks(const Problem& problem, Values values, std::size_t count,
                             const Budget& budget = {}) {
  const TransitionSystem system(problem);
  return on_thread_ranks(count, [&](Ranks& ranks) {
    return cluster_value_iteration(system, {.values = values}, budget, ranks);
  });
}

/// The bytes that a note says were sent.
double bytes_sent(const Result& result) {
  const std::string& note = result.notes.back();
  const std::size_t end = note.find(" bytes of values were sent");
  EXPECT_NE(end, std::string::npos) << note;
  const std::size_t begin = note.rfind(' ', end - 1);
  return std::stod(note.substr(begin, end - begin));
}

/// Every rank answers what one process does, and sends what the model says.
void expect_as_in_one_process(const Problem& problem, std::size_t count) {
  const TransitionSystem system(problem);
  for (const Values values : {Values::Double, Values::FixedPoint}) {
    SCOPED_TRACE(std::to_string(count) + " ranks");
    const Result expected = dense_value_iteration(system, {.values = values}, {});
    const std::vector<Result> results = on_ranks(problem, values, count);
    for (const Result& result : results) {
      EXPECT_EQ(status_name(result.status), status_name(expected.status));
      EXPECT_EQ(result.sequence, expected.sequence);
      EXPECT_EQ(result.reward, expected.reward);
      EXPECT_EQ(result.bound, expected.bound);
      // A sweep that was given up is counted as far as it came.
      if (expected.statistics.sweeps == 1) {
        EXPECT_EQ(result.statistics.expanded, expected.statistics.expanded);
      }
      EXPECT_EQ(result.statistics.generated, expected.statistics.generated);
      EXPECT_EQ(result.statistics.sweeps, expected.statistics.sweeps);
    }
    if (system.infeasibility()) return;
    const double bytes = values == Values::Double ? 8 : 4;
    EXPECT_EQ(bytes_sent(results[0]),
              bytes * static_cast<double>(expected.statistics.sweeps *
                                          cluster_values_sent(system.num_connections(), count)));
  }
}

// A block of seeds a test, as in agreement_test.cpp.
class ClusterAgreement : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Seeds, ClusterAgreement, testing::Range(0, 4));

TEST_P(ClusterAgreement, AnyNumberOfRanksIsRightAboutEveryProblem) {
  constexpr std::uint64_t kProblemsInBlock = 60;
  int taken = 0;
  for (std::uint64_t i = 0; i < some_of(kProblemsInBlock); ++i) {
    const std::uint64_t seed = static_cast<std::uint64_t>(GetParam()) * kProblemsInBlock + i;
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    if (cluster_values_obstacle(TransitionSystem(problem))) continue;
    ++taken;
    const std::size_t count = 1 + seed % 8;
    const Result result = on_ranks(problem, Values::Double, count)[0];
    expect_honest(problem, oracle::brute_force(spec), find_planner("value-iteration"), result);
    expect_as_in_one_process(problem, count);
    if (HasFailure()) return;
  }
  EXPECT_GE(taken, least_of(40));
}

// Several rounds of blocks; both kinds of blocks; shares that are no power of two.
TEST(ClusterValueIteration, ScenariosAreAsInOneProcess) {
  for (const char* const name : {"hubble", "hubble-upc", "hubble-free", "lattice"}) {
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      ProblemSpec spec = load_scenario(name).spec();
      spec.direction = direction;
      SCOPED_TRACE(name);
      for (const std::size_t count : {3U, 8U}) expect_as_in_one_process(Problem(spec), count);
    }
  }
}

TEST(ClusterValueIteration, CyclesAreAsInOneProcess) {
  for (const std::size_t count : {4U, 5U}) expect_as_in_one_process(Problem(grid(3, 4)), count);
}

TEST(ClusterValueIteration, TheModelOfWhatIsSentIsHalfABitAState) {
  for (std::size_t bits = 0; bits <= 6; ++bits)
    EXPECT_EQ(cluster_values_sent(20, std::size_t{1} << bits), (std::size_t{1} << 19) * bits);
  // Not more than twice what the next power of two sends.
  for (std::size_t count = 3; count <= 33; ++count)
    EXPECT_LE(cluster_values_sent(20, count), 2 * cluster_values_sent(20, std::bit_ceil(count)));
}

// The greedy plan never meets the great reward, so that one rank alone finds the unit too fine: all
// begin again.
TEST(ClusterValueIteration, AllRanksBeginAgainWhereOneMeetsARewardTooLarge) {
  ProblemSpec spec = chain(8);
  Callable callable;
  callable.reward = [](const Step& step) {
    if (step.connection == 0) return step.before == 2 ? 1e6 : 1e-3;
    return -1e-3 * step.connection;
  };
  spec.objective = {"callable", callable};
  const Problem problem(spec);
  for (const std::size_t count : {2U, 3U, 4U}) {
    expect_as_in_one_process(problem, count);
    EXPECT_GE(on_ranks(problem, Values::FixedPoint, count)[0].statistics.sweeps, 2U);
  }
}

TEST(ClusterValueIteration, AFaultOfOneRankIsThrownByAll) {
  ProblemSpec spec = chain(8);
  Callable callable;
  callable.reward = [](const Step& step) { return step.before == 1 ? std::nan("") : 1.0; };
  spec.objective = {"callable", callable};
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const auto thrown = faults_on_thread_ranks(4, [&](Ranks& ranks) {
    return cluster_value_iteration(system, {.values = Values::Double}, {}, ranks);
  });
  for (const std::string& fault : thrown) {
    EXPECT_EQ(fault, thrown.front());
    EXPECT_NE(fault, "");
  }
}

TEST(ClusterValueIteration, WhatStopsOneRankStopsAll) {
  const Problem problem = load_scenario("hubble");
  const TransitionSystem system(problem);
  for (const std::size_t stopped : {0U, 2U}) {
    const auto results = on_thread_ranks(3, [&](Ranks& ranks) {
      Budget budget;
      std::stop_source stop;
      budget.stop = stop.get_token();
      if (ranks.rank() == stopped) stop.request_stop();
      return cluster_value_iteration(system, {}, budget, ranks);
    });
    for (const Result& result : results) EXPECT_EQ(result.stop, Stop::Cancelled);
    EXPECT_TRUE(results[0].has_plan());
    EXPECT_EQ(status_name(results[0].status), "feasible");
  }
}

TEST(ClusterValueIteration, ATableThatDoesNotFitIsRefusedInOneSentenceByAll) {
  const Problem problem = load_scenario("iss");
  Budget budget;
  budget.max_bytes = 1 << 20;
  try {
    static_cast<void>(on_ranks(problem, Values::Automatic, 4, budget));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("rank 0 on here needs 20"), std::string::npos)
        << error.what();
  }
}

TEST(ClusterValueIteration, WhatTheTableDoesNotTakeIsRefused) {
  const Problem uncertain(make_uncertain(chain(6), 1));
  EXPECT_THROW(static_cast<void>(on_ranks(uncertain, Values::Double, 2)), InputError);
}

}  // namespace
}  // namespace orasp
