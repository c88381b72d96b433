// Episodes side by side: what is legal and earned there is what the rules say.

#include "orasp/learning/environment.h"

#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"

namespace orasp {
namespace {

TEST(Environment, ObservesAndMasksByHand) {
  // Three connections in a row: the middle one must not be first.
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.precedence.push_back({.connection = "2-3", .after = {"1-2"}, .after_any = {}});
  const Problem problem(spec);
  const TransitionSystem system(problem);
  Environment world(system, 2);
  std::vector<float> row(3);
  world.observe(0, row);
  EXPECT_EQ(row, (std::vector<float>{1, 1, 1}));
  world.mask(0, row);
  EXPECT_EQ(row, (std::vector<float>{1, 0, 1}));
  EXPECT_EQ(world.num_open(0), 3U);

  world.step(0, 0);
  world.observe(0, row);
  EXPECT_EQ(row, (std::vector<float>{0, 1, 1}));
  world.mask(0, row);
  EXPECT_EQ(row, (std::vector<float>{0, 1, 1}));
  world.mask(1, row);
  EXPECT_EQ(row, (std::vector<float>{1, 0, 1})) << "the other episode stands where it stood";
}

TEST(Environment, ForbiddenConnectionsAreNeverLegalAndNeedNotBeHandled) {
  const Problem problem(instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}}));
  const TransitionSystem system(problem);
  Environment world(system, 1);
  ConnectionSet forbidden(3);
  forbidden.insert(2);
  world.forbid(forbidden);
  std::vector<float> mask(3);
  world.mask(0, mask);
  EXPECT_EQ(mask, (std::vector<float>{1, 1, 0}));
  world.step(0, 0);
  EXPECT_FALSE(world.done(0));
  EXPECT_THROW(world.step(0, 2), InputError) << "forbidden";
  EXPECT_THROW(world.step(0, 0), InputError) << "handled before";
  world.step(0, 1);
  EXPECT_TRUE(world.done(0));
  EXPECT_FALSE(world.dead_end(0));
}

TEST(Environment, KnowsADeadEnd) {
  ProblemSpec spec = instances::assembly(3, {{1, 2}, {2, 3}});
  spec.precedence.push_back({.connection = "1-2", .after = {}, .after_any = {"2-3"}});
  spec.precedence.push_back({.connection = "2-3", .after = {"1-2"}, .after_any = {}});
  const Problem problem(spec);
  const TransitionSystem system(problem);
  Environment world(system, 1);
  EXPECT_FALSE(world.done(0));
  EXPECT_TRUE(world.dead_end(0));
  EXPECT_TRUE(world.over(0));
  // From the middle of a plan that could never begin.
  ConnectionSet left(2);
  left.insert(1);
  world.reset(0, left);
  EXPECT_FALSE(world.dead_end(0));
  EXPECT_EQ(world.num_open(0), 1U);
}

/// Plays random episodes side by side; what they add up to is what the independent checker and the
/// oracle say.
TEST(Environment, RewardsAddUpToThePlansReward) {
  std::size_t finished = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    const ProblemSpec spec = random_problem(seed);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    if (system.infeasibility()) continue;
    Environment world(system, 5);
    SplitMix64 random(seed);
    std::vector<std::vector<ConnectionIndex>> sequences(world.size());
    bool any = true;
    while (any) {
      any = false;
      for (std::size_t i = 0; i < world.size(); ++i) {
        if (world.over(i)) continue;
        any = true;
        const auto actions = world.actions(i);
        const ConnectionIndex c = actions[random.below(actions.size())].connection;
        sequences[i].push_back(c);
        world.step(i, c);
      }
    }
    for (std::size_t i = 0; i < world.size(); ++i) {
      if (!world.done(i)) continue;
      ++finished;
      const Evaluation evaluation =
          evaluate(problem, std::span<const ConnectionIndex>(sequences[i]));
      EXPECT_TRUE(evaluation.valid);
      EXPECT_NEAR(world.total(i), evaluation.reward, 1e-9 * (1 + std::abs(evaluation.reward)));
      EXPECT_NEAR(world.total(i), oracle::replay(spec, sequences[i]).reward,
                  1e-9 * (1 + std::abs(evaluation.reward)));
    }
  }
  EXPECT_GT(finished, 100U);
}

}  // namespace
}  // namespace orasp
