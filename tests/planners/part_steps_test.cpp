#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/problem.h"
#include "orasp/model/random.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/random_rewards.h"

namespace orasp {
namespace {

/// Parts that hang together at random, taken off one after another: any connected set of them may
/// be a step, so there are exponentially many.
ProblemSpec many_sets(std::size_t parts, std::size_t connections, std::uint64_t seed,
                      Direction direction) {
  SplitMix64 random(seed);
  ProblemSpec spec;
  spec.action = StepKind::Part;
  spec.direction = direction;
  spec.objective = Objective::named("fuel");
  for (std::size_t p = 0; p < parts; ++p) {
    Part part;
    part.id = "p" + std::to_string(p);
    part.mass = static_cast<double>(1 + random.below(9));
    spec.parts.push_back(std::move(part));
  }
  const auto join = [&](std::size_t a, std::size_t b) {
    Connection connection;
    connection.id = "c" + std::to_string(spec.connections.size());
    connection.parts = {"p" + std::to_string(a), "p" + std::to_string(b)};
    spec.connections.push_back(std::move(connection));
  };
  for (std::size_t p = 1; p < parts; ++p) join(random.below(p), p);
  while (spec.connections.size() < connections) {
    const std::size_t a = random.below(parts);
    const std::size_t b = random.below(parts);
    if (a != b) join(a, b);
  }
  return spec;
}

TEST(PartSteps, EveryMethodEndsAtItsLimitWithAPlanHoweverManySetsOfPartsThereAre) {
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    const Problem problem(many_sets(40, 70, 1, direction));
    for (const Planner* planner : one_robot_planners()) {
      if (obstacle(problem, planner->name)) continue;
      SCOPED_TRACE(std::string(planner->name));
      // What there is after so short a time is checked by solve().
      static_cast<void>(solve(problem, planner->name, {}, Budget::with_time_limit(0.002)));
      const Result result = solve(problem, planner->name, {}, Budget::with_time_limit(0.3));
#if defined(__SANITIZE_ADDRESS__)
      // A sanitizer may leave no time for the quick plan.
      ASSERT_TRUE(result.has_plan() || result.stop == Stop::TimeLimit);
#else
      ASSERT_TRUE(result.has_plan());  // which solve() has checked
#endif
      EXPECT_GE(result.bound.value_or(kInfinity), result.reward);
      // Measured to be some hundredths of a second; a list that nobody leaves takes hours.
      EXPECT_LT(result.statistics.seconds, 10);
    }
  }
}

TEST(PartSteps, AGoalIsReachedOrTheTimeIsOver) {
  ProblemSpec spec = many_sets(12, 20, 1, Direction::Disassembly);
  spec.goal.emplace().free = {"p11", "p5"};
  const Problem problem(spec);
  for (const Planner* planner : one_robot_planners()) {
    if (obstacle(problem, planner->name)) continue;
    SCOPED_TRACE(std::string(planner->name));
    for (int milliseconds = 1; milliseconds <= 40; ++milliseconds) {
      const Result result =
          solve(problem, planner->name, {}, Budget::with_time_limit(milliseconds * 1e-3));
      EXPECT_GE(result.bound.value_or(kInfinity), result.reward);
    }
  }
}

TEST(PartSteps, AnAssemblyIsAQuickPlanOfItsReverse) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Problem taken_apart(many_sets(24, 30, seed, Direction::Disassembly));
    const Problem made(many_sets(24, 30, seed, Direction::Assembly));
    const TransitionSystem removing(taken_apart);
    const TransitionSystem making(made);
    const Result back = detail::plan_of_few_moves(removing, {});
    const Result forth = detail::plan_of_few_moves(making, {});
    ASSERT_TRUE(back.has_plan());
    EXPECT_NEAR(forth.reward, back.reward, 1e-9);
    EXPECT_EQ(forth.steps.size(), back.steps.size());
    EXPECT_TRUE(check_plan(made, Situation::whole(made.num_connections()), forth.steps).legal);
  }
}

TEST(PartSteps, APieceThatTouchesManyIsPutOnAll) {
  ProblemSpec spec;
  spec.action = StepKind::Part;
  spec.direction = Direction::Assembly;
  spec.objective = Objective::named("cubesat");
  spec.parts.emplace_back().id = "hub";
  for (int i = 0; i < 40; ++i) {
    const std::string screw = "screw " + std::to_string(i);
    spec.parts.emplace_back().id = screw;
    Connection& connection = spec.connections.emplace_back();
    connection.id = "c" + std::to_string(i);
    connection.parts = {"hub", screw};
  }
  const Result result = solve(Problem(std::move(spec)), "auto");
  EXPECT_EQ(result.status, Status::Optimal);
  EXPECT_DOUBLE_EQ(result.reward, 1);
}

TEST(PartSteps, QuickPlansAreNoSamples) {
  const Problem problem(many_sets(40, 70, 1, Direction::Disassembly));
  const TransitionSystem system(problem);
  const RandomRewards drawn = draw_rewards(system, 5, 1, false, Budget::with_time_limit(0.2));
  EXPECT_TRUE(drawn.rewards.empty());
  EXPECT_EQ(drawn.last.stop, Stop::TimeLimit);
}

}  // namespace
}  // namespace orasp
