// The integer program of problems for one robot. That it agrees with brute force on random problems
// is in agreement_test.cpp, that it keeps the contract of planners in planner_contract_test.cpp.

#include "orasp/mip/mip.h"

#include <set>
#include <stop_token>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/io/scenarios.h"
#include "orasp/mip/mip_solver.h"
#include "orasp/model/error.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/planners/value_iteration.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

std::string obstacle(const ProblemSpec& spec) {
  const Problem problem(spec);
  const TransitionSystem system(problem);
  return mip_obstacle(system).value_or("");
}

TEST(MipModelOfAProblem, HasOneColumnForEachStepOfAConnectionAndWhatItDoes) {
  const Problem problem(instances::assembly(3, {{1, 2}, {2, 3}}));
  const MipModel model = mip_model(TransitionSystem(problem));
  std::set<std::string> names;
  for (const MipModel::Column& column : model.columns())
    EXPECT_TRUE(names.insert(column.name).second) << column.name;
  for (const char* name : {"cut_1_1", "cut_1_2", "cut_2_1", "cut_2_2"})
    EXPECT_TRUE(names.contains(name)) << name;
  EXPECT_FALSE(names.contains("keep_1_1"));  // a chain falls apart at every step
  EXPECT_TRUE(names.contains("split_1_2_1"));
}

TEST(MipModelOfAProblem, NamesEachRowOnce) {
  ProblemSpec spec = instances::sandwich();
  spec.limits = {.max_subassemblies = 1, .max_moved_parts = 1, .max_moved_mass = 1};
  spec.parts[1].mass = 0.5;
  const Problem problem(spec);
  const MipModel model = mip_model(TransitionSystem(problem));
  std::set<std::string> names;
  for (const MipModel::Row& row : model.rows())
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
}

// A ring of four: its first removal only keeps, and every later one cuts.
TEST(Mip, KnowsThatTheFirstConnectionOfARingSeparatesNothing) {
  if (!mip_solver_available()) GTEST_SKIP() << "built without CBC";
  const Problem problem(instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}, {1, 4}}));
  const Result result = mip(TransitionSystem(problem), {});
  EXPECT_EQ(status_name(result.status), "optimal");
  // 0 for the first, then a chain of four parts in the middle: -2 * 0.1248 - 2 * 0.0967 + 1
  EXPECT_NEAR(result.reward, 0.5570, 1e-9);
}

TEST(Mip, FindsTheKnownOptimaOfTheSmallScenarios) {
  if (!mip_solver_available()) GTEST_SKIP() << "built without CBC";
  for (const auto& [name, best] :
       {std::pair{"3piece", 0.7785}, {"4brick", 0.5570}, {"4piece", 0.5570}, {"2x3", 0.3636}}) {
    SCOPED_TRACE(name);
    const Problem problem = load_scenario(name);
    const Result result = mip(TransitionSystem(problem), {});
    EXPECT_EQ(status_name(result.status), "optimal");
    EXPECT_NEAR(result.reward, best, 1e-9);
    EXPECT_EQ(result.bound, result.reward);
  }
}

// Masses 1, 3, 1, 1 along a chain, at most 1.5 kg moved: the middle may not be cut, since the
// lighter of its halves has 2 kg; 1-2 is cut first (1 is moved, 1 kg), then 2 may not leave 3-4 (3
// kg) unless 4 goes first.
TEST(Mip, WeighsWhatIsMovedWhereMassesDiffer) {
  if (!mip_solver_available()) GTEST_SKIP() << "built without CBC";
  ProblemSpec spec = instances::greedy_trap();
  spec.parts[1].mass = 3;
  spec.limits.max_moved_mass = 1.5;
  const Problem problem(spec);
  const oracle::OracleResult truth = oracle::brute_force(spec);
  const Result result = mip(TransitionSystem(problem), {});
  expect_honest(problem, truth, find_planner("mip"), result);
  EXPECT_NEAR(result.reward, 0.5450, 1e-9);
}

// agreement_test.cpp looks at all those of at most five connections.
TEST(Mip, AgreesWithValueIterationOnLargerRandomProblems) {
  if (!mip_solver_available()) GTEST_SKIP() << "built without CBC";
  std::size_t solved = 0;
  for (std::uint64_t seed = 0; solved < 8; seed += 7) {
    const ProblemSpec spec = random_problem(seed);
    if (spec.connections.size() < 6 || spec.connections.size() > 7) continue;
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    if (mip_obstacle(system)) continue;
    ++solved;
    const Result truth = value_iteration(system, {}, {});
    const Result result = mip(system, {});
    EXPECT_EQ(status_name(result.status), status_name(truth.status));
    if (truth.has_plan() && result.has_plan()) {
      EXPECT_NEAR(result.reward, truth.reward, reward_tolerance(truth.reward));
      EXPECT_TRUE(oracle::replay(spec, result.sequence).valid);
    }
  }
}

TEST(Mip, PlansWhatIsLeftWithInaccessibleConnections) {
  if (!mip_solver_available()) GTEST_SKIP() << "built without CBC";
  for (std::uint64_t seed = 0; seed < some_of(240U); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    if (spec.connections.size() < 3 || spec.connections.size() > 6) continue;
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    Situation situation = Situation::whole(problem.num_connections());
    situation.open.erase(0);
    situation.inaccessible.insert(static_cast<ConnectionIndex>(1 + seed % 2));
    const TransitionSystem system(problem, situation);
    if (mip_obstacle(system)) continue;
    const Result result = mip(system, {});
    const Result truth = value_iteration(system, {}, {});
    EXPECT_EQ(status_name(result.status), status_name(truth.status));
    EXPECT_EQ(result.has_plan(), truth.has_plan());
    if (truth.has_plan()) {
      EXPECT_NEAR(result.reward, truth.reward, reward_tolerance(truth.reward));
    }
  }
}

TEST(Mip, SaysWhichObjectiveItCannotTake) {
  ProblemSpec spec = instances::greedy_trap();
  EXPECT_EQ(obstacle(spec), "");
  spec.objective = Objective::named("indexed");
  EXPECT_EQ(obstacle(spec), "");
  spec.objective = Objective::named("fuel");
  EXPECT_EQ(obstacle(spec), "");  // masses are equal: the sizes say what a cut costs
  spec.parts[0].mass = 2;
  EXPECT_NE(obstacle(spec).find("'fuel' sees more"), std::string::npos) << obstacle(spec);
  const Problem problem(spec);
  EXPECT_THROW((void)mip_model(TransitionSystem(problem)), InputError);
}

TEST(Mip, SaysHowManyConnectionsAreTooMany) {
  EXPECT_EQ(obstacle(chain(33)), "");
  const std::string text = obstacle(chain(34));
  EXPECT_EQ(text, "takes at most 32 connections for its integer program; this problem has 33");
}

TEST(Mip, SaysThatItCannotWaitForALatePart) {
  const Problem problem(instances::greedy_trap());
  Situation situation = Situation::whole(3);
  situation.late.insert(0);
  const TransitionSystem system(problem, situation);
  ASSERT_TRUE(mip_obstacle(system));
  EXPECT_NE(mip_obstacle(system)->find("late"), std::string::npos);
}

TEST(Mip, HasAPlanAndABoundWhenItIsStopped) {
  if (!mip_solver_available()) GTEST_SKIP() << "built without CBC";
  const Problem problem = load_scenario("lattice");
  Budget budget;
  int calls = 0;
  std::stop_source source;
  budget.stop = source.get_token();
  budget.progress = [&](const Progress& progress) {
    EXPECT_EQ(progress.phase, "integer program");
    if (++calls == 2) source.request_stop();
  };
  const Result result = mip(TransitionSystem(problem), budget);
  EXPECT_GE(calls, 2);
  EXPECT_EQ(stop_name(result.stop), "interrupted");
  EXPECT_EQ(status_name(result.status), "feasible");
  EXPECT_TRUE(oracle::replay(problem.spec(), result.sequence).valid);
}

}  // namespace
}  // namespace orasp
