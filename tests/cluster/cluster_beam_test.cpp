#include "orasp/cluster/cluster_beam.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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
#include "tests/symmetry/symmetric_problems.h"

namespace orasp {
namespace {

// Whether so many ranks answer as one process does. Where wide layers are cut down before they are
// whole, successors that meet one of the same state are not counted alike: `counts` says whether
// they are compared.
Result beam_as_in_one_process(const Problem& problem, std::size_t count, std::uint64_t expansions,
                              const BeamOptions& options = {}, bool counts = true) {
  const TransitionSystem system(problem);
  Budget budget;
  budget.max_expansions = expansions;
  const Result expected = beam(system, options, budget);
  const auto results = on_thread_ranks(
      count, [&](Ranks& ranks) { return cluster_beam(system, options, budget, ranks); });
  for (const Result& result : results) {
    EXPECT_EQ(status_name(result.status), status_name(expected.status));
    EXPECT_EQ(result.sequence, expected.sequence);
    EXPECT_EQ(result.reward, expected.reward);
    EXPECT_EQ(result.stop, expected.stop);
    EXPECT_EQ(result.bound.has_value(), expected.bound.has_value());
    // A pass that ends in time promises the same but for the last bits: a state may be left out
    // once by one way to it and then by another.
    if (expected.bound) {
      EXPECT_NEAR(*result.bound, *expected.bound, 1e-9);
    }
    if (expected.stop != Stop::None) continue;
    EXPECT_EQ(result.statistics.expanded, expected.statistics.expanded);
    EXPECT_EQ(result.statistics.generated, expected.statistics.generated);
    if (counts) {
      EXPECT_EQ(result.statistics.pruned, expected.statistics.pruned);
    }
  }
  return results[0];
}

// A block of seeds a test, as in agreement_test.cpp.
class ClusterBeamAgreement : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Seeds, ClusterBeamAgreement, testing::Range(0, 4));

TEST_P(ClusterBeamAgreement, AnyNumberOfRanksIsRightAboutEveryProblem) {
  constexpr std::uint64_t kProblemsInBlock = 60;
  constexpr std::array<std::size_t, 5> kCounts = {1, 2, 3, 4, 8};
  constexpr auto kAll = std::numeric_limits<std::uint64_t>::max();
  int taken = 0;
  for (std::uint64_t i = 0; i < some_of(kProblemsInBlock); ++i) {
    const std::uint64_t seed = static_cast<std::uint64_t>(GetParam()) * kProblemsInBlock + i;
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    if (TransitionSystem(problem).wide()) continue;
    ++taken;
    const Result result = beam_as_in_one_process(problem, kCounts[seed % 5], kAll);
    expect_honest(problem, oracle::brute_force(spec), find_planner("beam"), result);
    if (HasFailure()) return;
  }
  EXPECT_GE(taken, least_of(40));
}

TEST_P(ClusterBeamAgreement, SymmetryIsThatOfOneProcess) {
  constexpr std::uint64_t kProblemsInBlock = 30;
  constexpr auto kAll = std::numeric_limits<std::uint64_t>::max();
  int used = 0;
  for (std::uint64_t i = 0; i < some_of(kProblemsInBlock); ++i) {
    const std::uint64_t seed = static_cast<std::uint64_t>(GetParam()) * kProblemsInBlock + i;
    const ProblemSpec spec = symmetric_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    if (system.wide() || symmetry_obstacle(system, SymmetryUse::On)) continue;
    const Result result =
        beam_as_in_one_process(problem, 2 + seed % 3, kAll, {.symmetry = SymmetryUse::On});
    expect_honest(problem, oracle::brute_force(spec), find_planner("beam"), result);
    const auto names_it = [](const std::string& note) {
      return note.find("exchange") != std::string::npos;
    };
    used += std::ranges::any_of(result.notes, names_it) ? 1 : 0;
    if (HasFailure()) return;
  }
  EXPECT_GE(used, least_of(10));
}

// Layers of thousands of states, in several rounds, under an objective that no bound settles.
TEST(ClusterBeam, WideLayersAreAsInOneProcess) {
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    ProblemSpec spec = grid(3, 4);
    spec.direction = direction;
    spec.objective = chance_objective();
    for (const std::size_t count : {2U, 3U})
      static_cast<void>(beam_as_in_one_process(Problem(spec), count, 40'000));
  }
}

// To the end, with layers that are cut down between rounds.
TEST(ClusterBeam, WholeSearchesOfWideLayersAreAsInOneProcess) {
  ProblemSpec spec = grid(3, 4);
  spec.objective = Objective::named("fuel");
  const Result result =
      beam_as_in_one_process(Problem(spec), 3, std::numeric_limits<std::uint64_t>::max(),
                             {.bound = BoundKind::Connections}, false);
  EXPECT_EQ(status_name(result.status), "optimal");
}

// Symmetry that is looked for in the midst of the search is so by all ranks before the same pass.
TEST(ClusterBeam, SymmetryBeginsWhereItDoesInOneProcess) {
  ProblemSpec spec = grid(3, 4);
  spec.objective = Objective::named("fuel");
  const Result result = beam_as_in_one_process(
      Problem(spec), 3, 60'000, {.bound = BoundKind::Connections, .symmetry = SymmetryUse::Auto},
      false);
  EXPECT_GT(result.statistics.expanded, 10'000U);
}

// A rank holds its share of the layers.
TEST(ClusterBeam, LayersAreSplitEvenly) {
  ProblemSpec spec = grid(4, 5);
  spec.objective = chance_objective();
  const Problem problem(spec);
  const TransitionSystem system(problem);
  Budget budget;
  budget.max_expansions = 100'000;
  const auto alone = static_cast<double>(beam(system, {}, budget).statistics.peak_bytes);
  const auto results =
      on_thread_ranks(4, [&](Ranks& ranks) { return cluster_beam(system, {}, budget, ranks); });
  // What is on its way between the ranks comes to some hundred thousand bytes.
  EXPECT_LE(static_cast<double>(results[0].statistics.peak_bytes), 0.3 * alone + 1'000'000);
}

// Where orders of steps are improved against a clock, by one rank for all.
TEST(ClusterBeam, ImprovedOrdersAreThoseOfTheFirstRank) {
  const Problem problem = load_scenario("hubble").with_objective(Objective::named("indexed"));
  const Result result =
      beam_as_in_one_process(problem, 3, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(status_name(result.status), "optimal");
}

TEST(ClusterBeam, AFaultOfOneRankIsThrownByAll) {
  ProblemSpec spec = grid(3, 3);
  Callable callable;
  callable.reward = [](const Step& step) {
    return step.before == 6 && step.connection == 3 ? std::nan("") : 1.0;
  };
  spec.objective = {"callable", callable};
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const auto thrown =
      faults_on_thread_ranks(4, [&](Ranks& ranks) { return cluster_beam(system, {}, {}, ranks); });
  for (const std::string& fault : thrown) EXPECT_NE(fault, "");
}

TEST(ClusterBeam, WhatStopsOneRankStopsAll) {
  ProblemSpec spec = grid(4, 5);
  spec.objective = chance_objective();
  const Problem problem(spec);
  const TransitionSystem system(problem);
  for (const std::size_t stopped : {0U, 2U}) {
    const auto results = on_thread_ranks(3, [&](Ranks& ranks) {
      Budget budget;
      if (ranks.rank() == stopped) budget.set_time_limit(0.1);
      return cluster_beam(system, {}, budget, ranks);
    });
    for (const Result& result : results) {
      EXPECT_EQ(result.stop, Stop::TimeLimit);
      EXPECT_EQ(result.sequence, results[0].sequence);
    }
    EXPECT_EQ(status_name(results[0].status), "feasible");
  }
}

}  // namespace
}  // namespace orasp
