// The oracle itself: against plain enumeration (agreement_test.cpp) and, here, against published
// and hand-worked values.

#include "tests/oracle.h"

#include <string>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "tests/instances.h"

namespace orasp::oracle {
namespace {

struct Row {
  const char* scenario;
  std::uint64_t states;
  std::uint64_t actions;
  double best;
  double worst;
};

// Found by an exhaustive search of its own, before this library was written.
TEST(Oracle, FindsThePublishedValues) {
  for (const Row& row : {Row{"3piece", 8, 12, 0.7785, 0.7785}, Row{"4brick", 8, 12, 0.5570, 0.5450},
                         Row{"4piece", 16, 32, 0.5570, 0.5450}, Row{"2x3", 96, 304, 0.3636, 0.0900},
                         Row{"lattice", 1'296, 6'048, 0.0735, -0.4617}}) {
    SCOPED_TRACE(row.scenario);
    const OracleResult result = brute_force(load_scenario(row.scenario).spec());
    EXPECT_TRUE(result.feasible);
    EXPECT_EQ(result.states, row.states);
    EXPECT_EQ(result.actions, row.actions);
    EXPECT_NEAR(result.best, row.best, 1e-9);
    EXPECT_NEAR(result.worst, row.worst, 1e-9);
  }
}

TEST(Oracle, FindsThePublishedValuesOfOtherObjectives) {
  const Problem problem = load_scenario("2x3");
  for (const auto& [type, best] :
       {std::pair{"cubesat_zone", 0.497600}, std::pair{"custom", -6.600000},
        std::pair{"indexed", 13.0}, std::pair{"time", -12.0}, std::pair{"fuel", -1.001866},
        std::pair{"completion", 1493.0}}) {
    EXPECT_NEAR(brute_force(problem.with_objective(Objective::named(type)).spec()).best, best,
                5.1e-7)
        << type;
  }
}

// The numbers are worked out beside the drawings.
TEST(Oracle, FindsWhatTheDrawingsSay) {
  EXPECT_NEAR(brute_force(instances::greedy_trap()).best, 0.5570, 1e-12);
  EXPECT_NEAR(brute_force(instances::greedy_trap()).worst, 0.5450, 1e-12);
  EXPECT_NEAR(brute_force(instances::two_pieces()).best, 0.8066, 1e-12);
  EXPECT_FALSE(brute_force(instances::locked_ring()).feasible);
  EXPECT_FALSE(brute_force(instances::boxed_in()).feasible);
  const OracleResult sandwich = brute_force(instances::sandwich());
  EXPECT_NEAR(sandwich.best, 0.7785, 1e-12);
  EXPECT_EQ(sandwich.states, 5U);
  EXPECT_EQ(sandwich.actions, 4U);
  EXPECT_EQ(sandwich.dead_ends, 1U);
  EXPECT_EQ(sandwich.sequences, 1U);
  EXPECT_EQ(sandwich.tree_nodes, 5U);
  const OracleResult nothing = brute_force(instances::nothing());
  EXPECT_TRUE(nothing.feasible);
  EXPECT_EQ(nothing.best, 0);
}

TEST(Oracle, ReplayFindsEveryFault) {
  const ProblemSpec spec = instances::sandwich();
  EXPECT_TRUE(replay(spec, {1, 2, 0}).valid);
  EXPECT_FALSE(replay(spec, {0, 1, 2}).valid);  // 1-2 pulls 1 out of the middle
  EXPECT_FALSE(replay(spec, {2, 1, 0}).valid);  // 2-3 before 1-2
  EXPECT_FALSE(replay(spec, {1, 2}).valid);     // 1-3 is missing
  EXPECT_FALSE(replay(spec, {1, 2, 2}).valid);  // 2-3 twice
  EXPECT_FALSE(replay(spec, {1, 2, 3}).valid);  // no such connection
}

TEST(Oracle, EvaluatesFormulas) {
  EXPECT_EQ(formula_value("1 + 2*3 - 8/4/2", {}), 6);
  EXPECT_EQ(formula_value("-(a - 2.5)*b", {{"a", 0.5}, {"b", 3}}), 6);
  EXPECT_EQ(formula_value("0.25*moved_parts - -1", {{"moved_parts", 8}}), 3);
}

}  // namespace
}  // namespace orasp::oracle
