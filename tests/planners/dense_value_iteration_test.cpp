#include "orasp/planners/dense_value_iteration.h"

#include <array>
#include <atomic>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/planners/value_iteration.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using Values = DenseValueIterationOptions::Values;

Budget with_threads(unsigned threads) {
  Budget budget;
  budget.threads = threads;
  return budget;
}

Result dense(const Problem& problem, Values values, const Budget& budget = {}) {
  return dense_value_iteration(TransitionSystem(problem), {.values = values}, budget);
}

/// Value iteration on H.
Result on_graph(const Problem& problem) {
  const TransitionSystem system(problem);
  return value_iteration(StateGraph::build(system, with_threads(2)), {}, Budget{});
}

/// The same plan, reward and status from doubles, with one thread and with two, as from H.
void expect_as_on_graph(const Problem& problem) {
  const Result expected = on_graph(problem);
  const Result result = dense(problem, Values::Double);
  EXPECT_EQ(status_name(result.status), status_name(expected.status));
  EXPECT_EQ(result.sequence, expected.sequence);
  EXPECT_EQ(result.reward, expected.reward);
  EXPECT_EQ(result.bound, expected.bound);
  expect_same_answer(result, dense(problem, Values::Double, with_threads(2)));
}

/// A plan within its bound, which is at most `most_above` over the best plan; optimal if `exact`.
void expect_fixed_point(const Problem& problem, double best, double most_above, bool exact) {
  const Result result = dense(problem, Values::FixedPoint);
  ASSERT_TRUE(result.has_plan());
  EXPECT_EQ(stop_name(result.stop), "none");
  const oracle::OracleReplay replay = oracle::replay(problem.spec(), result.sequence);
  EXPECT_TRUE(replay.valid);
  EXPECT_NEAR(replay.reward, result.reward, reward_tolerance(result.reward));
  EXPECT_LE(result.reward, best + reward_tolerance(best));
  ASSERT_TRUE(result.bound.has_value());
  EXPECT_GE(*result.bound, best - reward_tolerance(best));
  EXPECT_LE(*result.bound, best + most_above + reward_tolerance(best));
  EXPECT_EQ(result.status == Status::Feasible, !result.notes.empty());
  if (result.status == Status::Optimal) {
    EXPECT_NEAR(result.reward, best, reward_tolerance(best));
  }
  if (exact) {
    EXPECT_EQ(status_name(result.status), "optimal");
  }
  expect_same_answer(result, dense(problem, Values::FixedPoint, with_threads(2)));
}

// A block of seeds a test, as in agreement_test.cpp.
class DenseAgreement : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Seeds, DenseAgreement, testing::Range(0, 12));

TEST_P(DenseAgreement, IsRightAboutEveryProblem) {
  constexpr std::uint64_t kProblemsInBlock = 60;
  int optimal = 0;
  for (std::uint64_t i = 0; i < some_of(kProblemsInBlock); ++i) {
    const ProblemSpec spec =
        random_problem(static_cast<std::uint64_t>(GetParam()) * kProblemsInBlock + i);
    SCOPED_TRACE(spec.name);
    const oracle::OracleResult truth = oracle::brute_force(spec);
    const Problem problem(spec);
    const Result doubles = dense(problem, Values::Double);
    expect_honest(problem, truth, find_planner("value-iteration"), doubles);
    const Result fixed = dense(problem, Values::FixedPoint);
    EXPECT_EQ(fixed.has_plan(), truth.feasible);
    if (truth.feasible) {
      // At most 8 steps of a few hundred each: sums below 1e5, so a unit of 1e-4, and half of it a
      // step.
      expect_fixed_point(problem, truth.best, 4e-4, false);
      optimal += fixed.status == Status::Optimal ? 1 : 0;
    } else {
      EXPECT_EQ(status_name(fixed.status), "infeasible");
    }
    if (!TransitionSystem(problem).infeasibility()) expect_as_on_graph(problem);
    if (HasFailure()) return;
  }
  EXPECT_GE(optimal, least_of(5)) << "decimal rewards must be exact";
}

// Forests in every size about the borders of lanes and blocks: 5 connections fill the lanes, 10 one
// block, 13 are eight blocks. The costs of a piece are all different, and no two sums of them are
// alike.
TEST(DenseValueIteration, ForestsAreAsOnTheGraph) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const std::size_t parts : {5U, 6U, 7U, 8U, 11U, 12U, 14U}) {
      for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
        ProblemSpec spec = random_tree(parts, seed);
        spec.direction = direction;
        SplitMix64 random(seed);
        PieceCost cost;
        cost.operation = 0.3;
        cost.completion = -0.7;
        for (std::size_t size = 1; size <= parts; ++size) {
          cost.pieces[size] = 0.01 * static_cast<double>(random.below(1000));
        }
        spec.objective = {"piece_cost", cost};
        SCOPED_TRACE(std::to_string(parts) + " parts, seed " + std::to_string(seed));
        const Problem problem(spec);
        expect_as_on_graph(problem);
        expect_fixed_point(problem, on_graph(problem).reward, 0, true);
      }
    }
  }
}

// Cuts of different pieces can be made in any order, so plans are equally good but for the last bit
// of a sum: and there (0.1 + a) + b is not (0.1 + b) + a. The same plan as from H shows that sums
// are formed the same way.
TEST(DenseValueIteration, TiesOfForestsAreBrokenAsOnTheGraph) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    ProblemSpec spec = random_tree(9, seed);
    if (seed % 2 == 0) spec.direction = Direction::Assembly;
    SplitMix64 random(seed);
    PieceCost cost;
    cost.operation = 0.1;
    for (std::size_t size = 1; size <= 8; ++size) {
      cost.pieces[size] = random.uniform();
    }
    spec.objective = {"piece_cost", cost};
    SCOPED_TRACE(seed);
    expect_as_on_graph(Problem(spec));
  }
}

// Two start pieces, a part alone, a connection of a part to itself among the lowest five and one
// above, and an objective of several terms.
TEST(DenseValueIteration, ForestsOfSeveralPiecesWithLoopsAreAsOnTheGraph) {
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    ProblemSpec spec = instances::assembly(
        10, {{1, 2}, {2, 2}, {3, 2}, {4, 5}, {6, 5}, {5, 7}, {2, 8}, {8, 8}, {9, 3}});
    spec.direction = direction;
    WeightedSum sum;
    sum.terms.push_back({2, Objective()});
    sum.terms.push_back({-0.01, Objective::named("completion")});
    sum.terms.push_back(
        {0.5,
         {"piece_cost",
          PieceCost{.operation = 0.25, .pieces = {{2, 0.75}, {5, -1.5}}, .completion = 0.125}}});
    spec.objective = {"sum", sum};
    const Problem problem(spec);
    expect_as_on_graph(problem);
    expect_fixed_point(problem, on_graph(problem).reward, 0, true);
  }
}

// More connections than parts: sizes end at the number of parts.
TEST(DenseValueIteration, LoopsOfASinglePartAreAsOnTheGraph) {
  ProblemSpec spec = instances::assembly(2, {{1, 1}, {2, 2}, {1, 1}, {1, 2}, {2, 2}, {1, 1}});
  for (std::size_t c = 0; c < spec.connections.size(); ++c)
    spec.connections[c].id = "c" + std::to_string(c);
  const Problem problem(spec);
  expect_as_on_graph(problem);
  expect_fixed_point(problem, 1, 0, true);
}

// `cubesat_zone` on a forest, which the quick blocks must leave alone: a pair that is a whole
// starting piece costs more than a pair cut off.
TEST(DenseValueIteration, KnowsWholeStartingPiecesOfTheZone) {
  ProblemSpec spec = instances::assembly(8, {{1, 2}, {3, 4}, {5, 6}, {6, 7}, {7, 8}});
  spec.objective = Objective::named("cubesat_zone");
  const Problem problem(spec);
  expect_as_on_graph(problem);
  expect_fixed_point(problem, on_graph(problem).reward, 0, true);
}

TEST(DenseValueIteration, FindsTheKnownValuesOfTheScenarios) {
  for (const auto& [name, best] :
       {std::pair{"3piece", 0.7785}, std::pair{"4brick", 0.5570}, std::pair{"4piece", 0.5570},
        std::pair{"2x3", 0.3636}, std::pair{"lattice", 0.0735}, std::pair{"hubble", -0.9902},
        std::pair{"hubble-free", -0.9902}, std::pair{"hubble-upc", -0.9902}}) {
    SCOPED_TRACE(name);
    const Problem problem = load_scenario(name);
    expect_as_on_graph(problem);
    expect_fixed_point(problem, best, 0, true);
  }
}

// Of both kinds of blocks: hubble-free is a tree, grid:3x4 has cycles.
TEST(DenseValueIteration, CountsStatesActionsAndBytes) {
  const Result tree = dense(load_scenario("hubble-free"), Values::FixedPoint);
  EXPECT_EQ(tree.statistics.states, 524'288U);
  EXPECT_EQ(tree.statistics.expanded, 524'288U);
  EXPECT_EQ(tree.statistics.generated, 4'980'736U);
  EXPECT_EQ(tree.statistics.sweeps, 1U);
  EXPECT_GE(tree.statistics.peak_bytes, 4U * 524'288U);
  EXPECT_LE(tree.statistics.peak_bytes, 4U * 524'288U + 10'000U);
  EXPECT_TRUE(tree.values.empty());
  const Result cycles = dense(Problem(grid(3, 4)), Values::Double);
  EXPECT_EQ(cycles.statistics.states, 131'072U);
  EXPECT_EQ(cycles.statistics.generated, 1'114'112U);
  EXPECT_GE(cycles.statistics.peak_bytes, 8U * 131'072U);
}

// Rewards of `fuel` are no decimals. 19 steps of at most 4 kg or so, so sums below 100 and a unit
// of 1e-7.
TEST(DenseValueIteration, RoundedRewardsGiveABoundAndNoFalseProof) {
  const Problem problem = load_scenario("hubble-free").with_objective(Objective::named("fuel"));
  const double best = on_graph(problem).reward;
  expect_fixed_point(problem, best, 19 * 0.5e-7, false);
  const Result result = dense(problem, Values::FixedPoint);
  EXPECT_EQ(status_name(result.status), "feasible");
  EXPECT_GT(*result.bound, result.reward);
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_NE(result.notes.front().find("multiples of 1e-"), std::string::npos);
}

// Steps of 1/3 and 2/3 in units of 1e-8: three are rounded down by a third of a unit and two up. So
// the value of the start is a third of a unit below the truth, and only the errors of five steps
// make it a bound.
TEST(DenseValueIteration, TheBoundAllowsForEveryStepsError) {
  ProblemSpec spec = chain(6);
  Callable thirds;
  thirds.reward = [](const Step& step) { return step.connection % 2 == 0 ? 1 / 3.0 : 2 / 3.0; };
  thirds.least = 0;
  thirds.greatest = 2 / 3.0;
  spec.objective = {"callable", thirds};
  const Result result = dense(Problem(spec), Values::FixedPoint);
  EXPECT_EQ(status_name(result.status), "feasible");
  EXPECT_NEAR(result.reward, 7 / 3.0, 1e-12);
  EXPECT_NEAR(*result.bound, 7 / 3.0 + 4e-8 / 3, 1e-11);
}

/// Six parts in a row. Connection 0 must go first (1e-3); as the last but one it would earn
/// `hidden`, which the greedy plan never meets.
Problem with_hidden_reward(double hidden) {
  ProblemSpec spec = chain(6);
  Callable callable;
  callable.reward = [hidden](const Step& step) {
    if (step.connection == 0) return step.before == 2 ? hidden : 1e-3;
    return -1e-3 * step.connection;
  };
  spec.objective = {"callable", callable};
  return Problem(spec);
}

// The unit fits rewards of 1e-3 at first; a reward 1e5 times as large makes it coarser and the
// sweep begin again.
TEST(DenseValueIteration, BeginsAgainWithACoarserUnitWhereARewardIsTooLarge) {
  const Problem harmless = with_hidden_reward(1e-3);
  EXPECT_EQ(dense(harmless, Values::FixedPoint).statistics.sweeps, 1U);
  for (const double hidden : {-100.0, 100.0, -1e12, 1e12, -1e305, 1e305}) {
    SCOPED_TRACE(hidden);
    const Problem problem = with_hidden_reward(hidden);
    const double best = oracle::brute_force(problem.spec()).best;
    EXPECT_NEAR(best, hidden > 0 ? hidden - 0.010 : -0.009, 1e-3 * std::abs(hidden));
    expect_as_on_graph(problem);
    const Result result = dense(problem, Values::FixedPoint);
    EXPECT_GE(result.statistics.sweeps, 2U);
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_GE(*result.bound, best - reward_tolerance(best));
    EXPECT_LE(result.reward, best + reward_tolerance(best));
    EXPECT_LE(*result.bound - result.reward, 1e-3 * std::abs(hidden));
    if (std::abs(hidden) > 1e300) {
      EXPECT_EQ(status_name(result.status), "feasible");  // in units of 1e302
    }
    expect_same_answer(result, dense(problem, Values::FixedPoint, with_threads(2)));
  }
}

// A callable's range is the caller's word; a false one costs a second sweep, not the answer.
TEST(DenseValueIteration, DoesNotTrustTheRangeOfACallable) {
  ProblemSpec spec = with_hidden_reward(5000).spec();
  auto callable = std::get<Callable>(spec.objective.parameters);
  callable.least = -1e-2;
  callable.greatest = 1e-2;
  spec.objective = {"callable", callable};
  const Problem problem(spec);
  const double best = oracle::brute_force(spec).best;
  const Result result = dense(problem, Values::FixedPoint);
  EXPECT_GE(result.statistics.sweeps, 2U);
  EXPECT_NEAR(result.reward, best, 1e-2);
  EXPECT_GE(*result.bound, best - reward_tolerance(best));
}

TEST(DenseValueIteration, RewardsOfZeroHaveAUnitToo) {
  ProblemSpec spec = chain(7);
  spec.objective = {"piece_cost", PieceCost{}};
  expect_fixed_point(Problem(spec), 0, 0, true);
  Callable nothing;
  nothing.reward = [](const Step&) { return 0.0; };
  spec.objective = {"callable", nothing};
  expect_fixed_point(Problem(spec), 0, 0, true);
}

TEST(DenseValueIteration, SmallAndLargeRewardsHaveTheirUnits) {
  for (const double scale : {1e-200, 1e-12, 1e12, 1e200}) {
    SCOPED_TRACE(scale);
    ProblemSpec spec = instances::greedy_trap();
    WeightedSum sum;
    sum.terms.push_back({scale, Objective()});
    spec.objective = {"sum", sum};
    const Result result = dense(Problem(spec), Values::FixedPoint);
    EXPECT_TRUE(result.has_plan());
    EXPECT_NEAR(result.reward, 0.5570 * scale, 1e-6 * scale);
    EXPECT_GE(*result.bound, 0.5570 * scale * (1 - 1e-9));
  }
}

TEST(DenseValueIteration, EmptyAssemblyHasTheEmptyPlan) {
  for (const Values values : {Values::Double, Values::FixedPoint}) {
    const Result result = dense(Problem(instances::nothing()), values);
    EXPECT_EQ(status_name(result.status), "optimal");
    EXPECT_EQ(result.reward, 0);
  }
}

TEST(DenseValueIteration, StopsAtItsLimits) {
  for (const char* name : {"hubble-free", "hubble-upc"}) {
    SCOPED_TRACE(name);
    const Problem problem = load_scenario(name);
    const Result late = dense(problem, Values::Double, Budget::with_time_limit(0));
    EXPECT_EQ(stop_name(late.stop), "time limit");
    EXPECT_EQ(late.statistics.expanded, 0U);

    for (const unsigned threads : {1U, 2U}) {
      std::stop_source source;
      Budget budget = with_threads(threads);
      budget.stop = source.get_token();
      std::vector<Progress> reports;
      budget.progress = [&](const Progress& progress) {
        reports.push_back(progress);
        if (reports.size() == 5) source.request_stop();
      };
      const Result cancelled = dense(problem, Values::FixedPoint, budget);
      EXPECT_EQ(stop_name(cancelled.stop), "interrupted");
      EXPECT_EQ(status_name(cancelled.status), "feasible");  // greedy's
      EXPECT_LT(cancelled.statistics.expanded, 524'288U);
      ASSERT_GE(reports.size(), 5U);
      EXPECT_EQ(reports.back().total, 524'288U);
      EXPECT_LE(reports.front().done, reports.back().done);
    }

    Budget few;
    few.max_expansions = 10'000;
    EXPECT_EQ(stop_name(dense(problem, Values::Double, few).stop), "expansion limit");

    Budget small;
    small.max_bytes = 3'000'000;  // 2^19 values of 4 bytes, not of 8
    EXPECT_EQ(status_name(dense(problem, Values::FixedPoint, small).status), "optimal");
    EXPECT_EQ(status_name(dense(problem, Values::Automatic, small).status), "optimal");
    EXPECT_THROW((void)dense(problem, Values::Double, small), InputError);
    small.max_bytes = 2'000'000;
    EXPECT_FALSE(dense_table_fits(TransitionSystem(problem), small));
    EXPECT_THROW((void)dense(problem, Values::Automatic, small), InputError);
  }
}

TEST(DenseValueIteration, RefusesMoreConnectionsThanAnyTableHolds) {
  for (const std::size_t parts : {50U, 65U, 66U, 500U}) {
    const Problem problem(chain(parts));
    EXPECT_FALSE(dense_table_fits(TransitionSystem(problem), Budget{})) << parts;
    EXPECT_THROW((void)dense(problem, Values::Automatic), InputError) << parts;
  }
}

// ---- when the method value-iteration takes it

/// H was not built.
bool is_dense(const Result& result) {
  return result.statistics.actions == 0 && result.values.empty();
}

TEST(ValueIterationMethod, TakesTheTableWhereNothingIsConstrained) {
  const Problem problem = load_scenario("hubble-free");
  const TransitionSystem system(problem);
  EXPECT_TRUE(is_dense(value_iteration(system, {}, Budget{})));
  // Whoever asks for anything about sweeps gets them.
  for (const ValueIterationOptions& options :
       {ValueIterationOptions{.order = ValueIterationOptions::Order::Textbook},
        ValueIterationOptions{.initial_value = 1}, ValueIterationOptions{.epsilon = 0},
        ValueIterationOptions{.max_sweeps = 5}}) {
    const Result result = value_iteration(system, options, Budget{});
    EXPECT_FALSE(is_dense(result));
    EXPECT_EQ(result.values.size(), 524'288U);
  }
}

// hubble-upc: H needs 20 MB and more and is estimated at 11, the table takes 2 or 4: refused by the
// estimate at 5 MB, stopped while it grows at 14 MB.
TEST(ValueIterationMethod, TakesTheTableWhereOnlyThatFits) {
  const Problem problem = load_scenario("hubble-upc");
  const TransitionSystem system(problem);
  EXPECT_FALSE(is_dense(value_iteration(system, {}, Budget{})));
  for (const std::uint64_t bytes : {5'000'000U, 14'000'000U}) {
    SCOPED_TRACE(bytes);
    Budget small;
    small.max_bytes = bytes;
    EXPECT_EQ(graph_fits(system, small), bytes > 10'000'000);
    EXPECT_EQ(stop_name(StateGraph::build(system, small).stop()), "memory limit");
    const Result result = value_iteration(system, {}, small);
    EXPECT_TRUE(is_dense(result));
    EXPECT_EQ(status_name(result.status), "optimal");
    EXPECT_NEAR(result.reward, -0.9902, 1e-9);
    EXPECT_LE(result.statistics.peak_bytes, small.max_bytes);
  }
}

TEST(ValueIterationMethod, RefusesWithWhatWasTried) {
  const Problem problem = load_scenario("hubble-upc");
  const TransitionSystem system(problem);
  Budget tiny;
  tiny.max_bytes = 1'500'000;
  try {
    (void)value_iteration(system, {}, tiny);
    FAIL() << "no error";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("state-action graph"), std::string::npos) << text;
    EXPECT_NE(text.find("or 3 MiB for the values of all subsets, where 2 MiB are allowed"),
              std::string::npos)
        << text;
  }
}

// The callable cannot be asked about states that precedence keeps away: connection 1 gone before 0.
TEST(ValueIterationMethod, DoesNotAskACallableAboutStatesThatAreNotReached) {
  ProblemSpec spec = chain(20);
  spec.precedence.push_back({"2-3", {"1-2"}, {}});
  Callable callable;
  std::atomic<bool> first_is_there = false;
  callable.reward = [&](const Step& step) {
    if (step.connection == 0 && step.a.size() + step.b.size() == 2 && step.after > 0) {
      first_is_there = true;
    }
    return -1.0;
  };
  spec.objective = {"callable", callable};
  const Problem problem(spec);
  const TransitionSystem system(problem);
  EXPECT_FALSE(dense_values_safe(system));
  Budget small;
  small.max_bytes = 3'000'000;
  EXPECT_THROW((void)value_iteration(system, {}, small), InputError);
  EXPECT_FALSE(first_is_there);
  spec.precedence.clear();
  const Problem free_of_precedence(spec);
  EXPECT_TRUE(dense_values_safe(TransitionSystem(free_of_precedence)));
}

}  // namespace
}  // namespace orasp
