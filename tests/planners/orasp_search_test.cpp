#include "orasp/planners/orasp_search.h"

#include <string>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "orasp/model/error.h"
#include "orasp/planners/value_iteration.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"

namespace orasp {
namespace {

// Rewards above zero in either direction: the running reward alone proves nothing there.
TEST(OraspSearch, IsExactWithRewardsOfBothSigns) {
  for (const char* name : {"2x3", "lattice"}) {
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      for (const char* type : {"indexed", "completion", "cubesat", "cubesat_zone"}) {
        SCOPED_TRACE(std::string(name) + ", " + type);
        const Problem problem =
            load_scenario(name).with_direction(direction).with_objective(Objective::named(type));
        const TransitionSystem system(problem);
        const double best = value_iteration(system, {}, Budget{}).reward;
        const Result result = orasp_search(system, {}, Budget{});
        EXPECT_EQ(status_name(result.status), "optimal");
        EXPECT_NEAR(result.reward, best, reward_tolerance(best));
      }
    }
  }
}

TEST(OraspSearch, FindsTheSameRewardFromEveryFirstSequence) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Result result = orasp_search(system, {.seed = seed}, Budget{});
    EXPECT_EQ(status_name(result.status), "optimal");
    EXPECT_NEAR(result.reward, 0.0735, 1e-9);
    EXPECT_EQ(result.seed, seed);
  }
}

// The point of the method: not all of H is generated.
TEST(OraspSearch, AbandonsBranches) {
  const Problem problem = load_scenario("hubble");
  const TransitionSystem system(problem);
  const Result result = orasp_search(system, {}, Budget{});
  EXPECT_GT(result.statistics.pruned, 0U);
  EXPECT_LT(result.statistics.states, 12'096U);
}

// Stopped anywhere, the bound is above the optimum and the plan below it.
TEST(OraspSearch, GivesATrueBoundWhereverItIsStopped) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  for (std::uint64_t limit = 13; limit < 1500; limit = limit * 3 / 2) {
    Budget budget;
    budget.max_expansions = limit;
    const Result result = orasp_search(system, {}, budget);
    SCOPED_TRACE(limit);
    ASSERT_TRUE(result.has_plan());
    EXPECT_LE(result.reward, 0.0735 + 1e-9);
    if (result.bound) {
      EXPECT_GE(*result.bound, 0.0735 - 1e-9);
    }
    if (result.stop != Stop::None) {
      EXPECT_EQ(status_name(result.status), "feasible");
    }
  }
}

TEST(OraspSearch, SaysWhichMethodsNeedNoBound) {
  ProblemSpec spec = instances::greedy_trap();
  spec.objective = unbounded_formula();
  const Problem problem(spec);
  const TransitionSystem system(problem);
  EXPECT_THROW((void)orasp_search(system, {}, Budget{}), Refusal);
  try {
    (void)solve(problem, "orasp-search");
    FAIL() << "no error";
  } catch (const InputError& error) {
    const std::string text = error.what();
    for (const char* word : {"expression", "value-iteration", "dijkstra", "bellman-ford"}) {
      EXPECT_NE(text.find(word), std::string::npos) << text;
    }
  }
}

// A callable whose range is given may be searched, one without may not.
TEST(OraspSearch, TakesACallableWithARange) {
  ProblemSpec spec = instances::greedy_trap();
  Callable callable{.name = "moved", .reward = [](const Step& step) {
                      return step.separates
                                 ? -static_cast<double>(step.moved().size() * step.moved().size())
                                 : 0.0;
                    }};
  spec.objective = {"callable", callable};
  const Problem unbounded(spec);
  EXPECT_THROW((void)orasp_search(TransitionSystem(unbounded), {}, Budget{}), InputError);
  callable.least = -16;
  callable.greatest = 0;
  spec.objective = {"callable", callable};
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const Result result = orasp_search(system, {}, Budget{});
  EXPECT_EQ(status_name(result.status), "optimal");
  EXPECT_NEAR(result.reward, -3, 1e-12);  // one part at a time
}

}  // namespace
}  // namespace orasp
