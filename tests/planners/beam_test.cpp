#include "orasp/planners/beam.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "orasp/io/formula_parser.h"
#include "orasp/orasp.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

Objective formula(const std::string& text) {
  return {"expression",
          Expression{.formula = text, .constants = {}, .depot = {}, .compiler = compile_formula}};
}

Result run(const Problem& problem, const BeamOptions& options = {}, const Budget& budget = {}) {
  const TransitionSystem system(problem);
  return beam(system, options, budget);
}

Budget expansions(std::uint64_t most) {
  Budget budget;
  budget.max_expansions = most;
  return budget;
}

// The bound that peeling single parts meets.
TEST(Beam, ProvesTheSpaceStationAndTheTelescope) {
  const std::pair<const char*, double> known[] = {
      {"iss", -2.1506}, {"iss-upc", -2.1506}, {"jwst", -16.7118}, {"jwst-upc", -16.7118}};
  for (const auto& [name, reward] : known) {
    SCOPED_TRACE(name);
    const Problem problem = load_scenario(name);
    const Result result = run(problem);
    EXPECT_EQ(status_name(result.status), "optimal");
    EXPECT_NEAR(result.reward, reward, 1e-9);
    EXPECT_TRUE(evaluate(problem, result.sequence).valid);
  }
}

TEST(Beam, HasAPlanForAThousandConnectionsAfterOnePass) {
  for (const char* type : {"cubesat", "indexed", "time"}) {
    SCOPED_TRACE(type);
    ProblemSpec spec = chain(1001);
    spec.objective = Objective::named(type);
    const Problem problem(spec);
    Budget one_pass;
    one_pass.max_expansions = 1500;
    const Result result = run(problem, {}, one_pass);
    ASSERT_TRUE(result.has_plan());
    const oracle::OracleReplay replay = oracle::replay(problem.spec(), result.sequence);
    EXPECT_TRUE(replay.valid);
    EXPECT_NEAR(replay.reward, result.reward, reward_tolerance(result.reward));
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_GE(*result.bound, result.reward - 1e-6);
  }
}

// What was known stays known: an incumbent is never exchanged for a worse plan, however soon the
// search ends.
TEST(Beam, NeverReturnsLessThanTheIncumbent) {
  const Problem problem = load_scenario("hubble").with_objective(Objective::named("indexed"));
  for (const char* method : {"value-iteration", "greedy", "random"}) {
    const Result incumbent = solve(problem, method);
    for (const std::uint64_t limit : {0U, 1U, 10U, 100U, 1000U}) {
      SCOPED_TRACE(std::string(method) + ", " + std::to_string(limit));
      const Result result = run(problem, {.incumbent = &incumbent}, expansions(limit));
      ASSERT_TRUE(result.has_plan());
      EXPECT_GE(result.reward, incumbent.reward);
      if (result.reward == incumbent.reward) {
        EXPECT_EQ(result.sequence, incumbent.sequence);
      }
      EXPECT_NEAR(evaluate(problem, result.sequence).reward, result.reward, 1e-9);
    }
  }
}

TEST(Beam, NeverReturnsAWorsePlanForMoreTime) {
  const Problem problem = load_scenario("hubble").with_objective(chance_objective());
  const double best = solve(problem, "value-iteration").reward;
  double reward = -std::numeric_limits<double>::infinity();
  double bound = std::numeric_limits<double>::infinity();
  std::size_t plans = 0;
  for (std::uint64_t limit = 20; limit < 40'000; limit *= 2) {
    SCOPED_TRACE(limit);
    const Result result = run(problem, {}, expansions(limit));
    ASSERT_TRUE(result.has_plan());
    EXPECT_GE(result.reward, reward);
    if (result.reward > reward) ++plans;
    reward = result.reward;
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_LE(*result.bound, bound + 1e-9);
    EXPECT_GE(*result.bound, best - 1e-9);
    bound = *result.bound;
  }
  EXPECT_GE(plans, 2U) << "the first plan was the best already: nothing was tested";
}

// No bound is known where nothing is known of what a formula may yield: only a pass that left
// nothing out proves.
TEST(Beam, ProvesWithoutAnyBound) {
  for (const char* text :
       {"-before*separates*tan(moved_parts)", "sin(7*before*index) + tan(moved_parts)"}) {
    for (const char* name : {"2x3", "lattice"}) {
      SCOPED_TRACE(std::string(text) + ", " + name);
      const Problem problem = load_scenario(name).with_objective(formula(text));
      const TransitionSystem system(problem);
      ASSERT_FALSE(make_bound(system, BoundKind::Best)->known());
      const Result truth = solve(problem, "value-iteration");
      const Result result = run(problem);
      EXPECT_EQ(status_name(result.status), "optimal");
      EXPECT_NEAR(result.reward, truth.reward, reward_tolerance(truth.reward));
      // Before the end nothing is proved.
      const Result soon = run(problem, {}, expansions(30));
      EXPECT_EQ(status_name(soon.status), "feasible");
      EXPECT_FALSE(soon.bound.has_value());
      // A bound that was asked for by name and knows nothing is an error.
      EXPECT_THROW((void)run(problem, {.bound = BoundKind::Sizes}), InputError);
    }
  }
}

TEST(Beam, AgreesWithValueIterationUnderEveryBound) {
  std::size_t solved = 0;
  std::size_t infeasible = 0;
  for (std::uint64_t seed = 200; seed < 200 + some_of(120U); ++seed) {
    const ProblemSpec spec = larger_random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const Result truth = solve(problem, "value-iteration");
    for (const BoundKind bound :
         {BoundKind::None, BoundKind::Connections, BoundKind::Parts, BoundKind::Best}) {
      if (bound != BoundKind::Best && !make_bound(system, bound)->known()) continue;
      SCOPED_TRACE(kBoundNames[static_cast<std::size_t>(bound)]);
      const Result result = run(problem, {.bound = bound});
      EXPECT_EQ(status_name(result.status), status_name(truth.status));
      truth.has_plan() ? ++solved : ++infeasible;
      if (!truth.has_plan()) continue;
      EXPECT_NEAR(result.reward, truth.reward, reward_tolerance(truth.reward));
      EXPECT_TRUE(evaluate(problem, result.sequence).valid);
    }
  }
  EXPECT_GE(solved, least_of(150U));
  EXPECT_GE(infeasible, least_of(30U));
}

TEST(Beam, ThreadsDoNotChangeTheAnswer) {
  for (const char* name : {"hubble-upc", "grid:3x4"}) {
    const Problem problem = load_scenario(name).with_objective(Objective::named("indexed"));
    Budget budget = expansions(30'000);
    const Result one = run(problem, {}, budget);
    for (const unsigned threads : {2U, 3U}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(threads));
      budget.threads = threads;
      expect_same_answer(one, run(problem, {}, budget));
    }
  }
}

}  // namespace
}  // namespace orasp
