// peeled_plan(), and what is proved with it, on problems small enough to know better and large
// enough to need it.

#include "orasp/planners/detail/peeled_plan.h"

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/bounds/piece_bound.h"
#include "orasp/catalogue.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/plan_moves.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "orasp/planners/planner_support.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

Result planned(const TransitionSystem& system) {
  return detail::from_the_end(system, [](const TransitionSystem& from) {
    PieceBound bound(from, PieceBound::Kind::Both);
    return bound.known() ? detail::peeled_plan(from, bound, {}) : detail::peeled_plan(from);
  });
}

// Any order, limits, blocking, bases and objectives, both ways: a plan is legal, earns what it says
// and no more than the best one, which a method that knows no bounds finds.
TEST(PeeledPlan, IsLegalAndEarnsWhatItSays) {
  std::size_t plans = 0;
  std::size_t best = 0;
  std::size_t assemblies = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(1'500); ++seed) {
    const Problem problem(random_problem(seed));
    SCOPED_TRACE(problem.spec().name);
    const TransitionSystem system(problem);
    if (problem.objective().of_fleet() || system.infeasibility()) continue;
    const Result plan = planned(system);
    if (!plan.has_plan()) continue;
    const Evaluation evaluation = evaluate(system, std::span<const ConnectionIndex>(plan.sequence));
    ASSERT_TRUE(evaluation.valid);
    EXPECT_TRUE(detail::meets(plan.reward, evaluation.reward));
    EXPECT_TRUE(detail::meets(evaluation.reward, plan.reward));
    if (problem.uncertain()) continue;
    const Result exact = solve(problem, "value-iteration");
    ASSERT_EQ(exact.status, Status::Optimal);
    EXPECT_TRUE(detail::meets(exact.reward, plan.reward));
    ++plans;
    best += detail::meets(plan.reward, exact.reward) ? 1 : 0;
    assemblies += problem.direction() == Direction::Assembly ? 1 : 0;
  }
  EXPECT_GE(plans, more_than(200U));
  EXPECT_GE(best, more_than(50U));
  EXPECT_GE(assemblies, more_than(50U));
}

// Where costs by size are no table the recursion is that of the table.
TEST(PeeledPlan, ProvesThousandsOfPartsBothWays) {
  for (const char* const name :
       {"chain:16000", "tree:16000:1", "grid:90x90", "random:8000:16000:1", "random:3000:9000:1"}) {
    for (const char* const objective : {"cubesat", "custom", "completion", "fuel"}) {
      const Problem problem = load_scenario(name).with_objective(Objective::named(objective));
      for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
        SCOPED_TRACE(std::string(name) + " " + objective);
        const Result result = solve(problem.with_direction(direction), "auto");
        EXPECT_EQ(result.status, Status::Optimal);
        EXPECT_EQ(result.statistics.generated, 0U) << "no state is looked at but by the last cuts";
      }
    }
  }
}

/// A random tree whose parts differ in mass.
Problem heavy_tree(std::size_t parts, Direction direction) {
  ProblemSpec spec = load_scenario("tree:" + std::to_string(parts) + ":3").spec();
  SplitMix64 random(11);
  for (Part& part : spec.parts) part.mass = 1 + static_cast<double>(random.below(1000)) / 100;
  spec.objective = Objective::named("fuel");
  spec.direction = direction;
  return Problem(std::move(spec));
}

// The changes of the bound of thousands of cuts, told all at once, are those of one after another.
TEST(PeeledPlan, BoundsTheCutsOfThousandsOfPartsAsOneByOne) {
  const Problem problem = heavy_tree(5000, Direction::Disassembly);
  const TransitionSystem system(problem);
  PieceBound bound(system, PieceBound::Kind::Parts);
  ASSERT_TRUE(bound.known());
  ConnectionSet open = system.start();
  open.erase(1234);
  Expander expander(system);
  const auto legal = expander.legal_actions(open.view());
  const std::vector<Action> actions(legal.begin(), legal.end());
  std::vector<double> bounds(actions.size());
  bound.of_successors(open.view(), bound(open.view()), actions, bounds);
  for (std::size_t i = 0; i < actions.size(); i += 37) {
    ConnectionSet next = open;
    next.erase(actions[i].connection);
    EXPECT_NEAR(bounds[i], bound(next.view()), 1e-8);
  }
}

TEST(PeeledPlan, ProvesThousandsOfPartsThatDiffer) {
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly})
    EXPECT_EQ(solve(heavy_tree(12'000, direction), "auto").status, Status::Optimal);
}

// The bound by sizes without a table is the one with it: a problem of 4,096 parts has one, and a
// part more has none.
TEST(PeeledPlan, SizesAreBoundedAlikeWithAndWithoutATable) {
  for (const char* const objective : {"cubesat", "custom", "completion"}) {
    std::vector<double> bounds;
    for (const std::size_t parts :
         {PieceGains::kMostPartsInTable, PieceGains::kMostPartsInTable + 1}) {
      const Problem problem = load_scenario("chain:" + std::to_string(parts))
                                  .with_objective(Objective::named(objective));
      const TransitionSystem system(problem);
      const PieceGains gains(system);
      ASSERT_TRUE(gains.sizes_known());
      for (std::size_t n = 1; n <= PieceGains::kMostPartsInTable; n += 13) {
        bounds.push_back(gains.by_size(n));
        if (n > 2) bounds.push_back(gains.gain(n / 3, n - n / 3));
      }
    }
    const std::size_t half = bounds.size() / 2;
    for (std::size_t i = 0; i < half; ++i) EXPECT_NEAR(bounds[i], bounds[half + i], 1e-8);
  }
}

// A table of steps shows what it showed when all parts of both sides were listed.
TEST(PlanMoves, ListWhatMovesAsTheWholeReplayDoes) {
  std::size_t plans = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(500); ++seed) {
    const Problem problem(random_problem(seed));
    const TransitionSystem system(problem);
    if (problem.objective().of_fleet()) continue;
    const Result plan = solve(problem, "greedy");
    if (!plan.has_plan() || !plan.steps.empty()) continue;
    ++plans;
    const Evaluation whole = evaluate(system, std::span<const ConnectionIndex>(plan.sequence));
    const Evaluation brief = evaluate_moves(system, plan.sequence);
    EXPECT_EQ(brief.valid, whole.valid);
    ASSERT_EQ(brief.steps.size(), whole.steps.size());
    for (std::size_t i = 0; i < whole.steps.size(); ++i) {
      EXPECT_EQ(brief.steps[i].connection, whole.steps[i].connection);
      EXPECT_EQ(brief.steps[i].separates, whole.steps[i].separates);
      EXPECT_EQ(brief.steps[i].moved(), whole.steps[i].moved());
      EXPECT_EQ(brief.steps[i].direction, whole.steps[i].direction);
      EXPECT_NEAR(brief.steps[i].reward, whole.steps[i].reward, 1e-9);
    }
  }
  EXPECT_GE(plans, more_than(100U));
}

}  // namespace
}  // namespace orasp
