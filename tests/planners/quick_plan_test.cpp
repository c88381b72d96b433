// quick_plan() against the replay that shares no formula with it.

#include "orasp/planners/detail/quick_plan.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/validate.h"
#include "orasp/planners/planner_support.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// The plan in the order of the problem's direction, after the replay has agreed with it.
Result replayed_plan(const Problem& problem) {
  const TransitionSystem system(problem);
  Result plan = detail::from_the_end(system, detail::quick_plan);
  if (!plan.has_plan()) return plan;
  const Evaluation evaluation = evaluate(problem, std::span<const ConnectionIndex>(plan.sequence));
  EXPECT_TRUE(evaluation.valid);
  EXPECT_TRUE(detail::meets(plan.reward, evaluation.reward));
  EXPECT_TRUE(detail::meets(evaluation.reward, plan.reward));
  return plan;
}

TEST(QuickPlan, IsLegalAndEarnsWhatItSays) {
  std::size_t planned = 0;
  std::size_t with_precedence = 0;
  std::size_t assemblies = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(2'000); ++seed) {
    for (ProblemSpec spec : {random_problem(seed), larger_random_problem(seed)}) {
      SCOPED_TRACE(spec.name);
      spec.limits = {};
      spec.blocking.reset();
      const Problem problem(std::move(spec));
      const TransitionSystem system(problem);
      if (system.infeasibility()) continue;
      if (!replayed_plan(problem).has_plan()) continue;
      ++planned;
      with_precedence += problem.precedence().empty() ? 0 : 1;
      assemblies += problem.direction() == Direction::Assembly ? 1 : 0;
    }
  }
  EXPECT_GE(planned, more_than(500U));
  EXPECT_GE(with_precedence, more_than(100U));
  EXPECT_GE(assemblies, more_than(50U));
}

TEST(QuickPlan, PlansThousandsOfPartsBothWays) {
  for (const char* const name : {"chain:3000", "grid:40x40", "random:1000:3000:1"}) {
    const Problem problem = load_scenario(name);
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      SCOPED_TRACE(name);
      EXPECT_TRUE(replayed_plan(problem.with_direction(direction)).has_plan());
    }
  }
}

// Where each of many methods is stopped before it has a plan, there still is one.
TEST(QuickPlan, IsWhatAMethodAnswersThatIsStoppedInALargeProblem) {
  const Problem problem = load_scenario("chain:5000");
  for (const char* const method : {"auto", "a-star", "beam", "orasp-search"}) {
    SCOPED_TRACE(method);
    Budget budget;
    budget.max_expansions = 3;
    const Result result = solve(problem, method, {}, budget);
    // auto peels a plan at the bound and looks at three states of the last pieces alone.
    const bool proves = std::string(method) == "auto";
    EXPECT_EQ(result.status, proves ? Status::Optimal : Status::Feasible);
    EXPECT_EQ(result.sequence.size(), problem.num_connections());
  }
}

// A thousand parts around one: each step would list what is left of them.
TEST(QuickPlan, LeavesAPlanThatIsTooLongToWrite) {
  ProblemSpec spec;
  spec.parts.push_back({.id = "hub"});
  for (int i = 0; i < 9'000; ++i) {
    spec.parts.push_back({.id = std::to_string(i)});
    spec.connections.push_back({.parts = {"hub", std::to_string(i)}});
  }
  const Problem problem(std::move(spec));
  EXPECT_FALSE(replayed_plan(problem).has_plan());
}

}  // namespace
}  // namespace orasp
