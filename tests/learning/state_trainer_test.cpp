// Training where there is more to states and steps than open connections of which one is handled.

#include "orasp/learning/detail/state_trainer.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/policy_file.h"
#include "orasp/io/problem_json.h"
#include "orasp/learning/network.h"
#include "orasp/model/error.h"
#include "orasp/planners/greedy.h"
#include "tests/seeds.h"
#include "tests/wide_oracle.h"
#include "tests/wide_problems.h"

namespace orasp {
namespace {

class OnStates : public testing::Test {
 protected:
  void SetUp() override {
    if (!network_available()) GTEST_SKIP() << "built without libtorch";
  }
};

/// Without the best episode, which alone would make the kept policy a good one.
DqnOptions without_help(std::uint64_t episodes) {
  DqnOptions options;
  options.seed = 3;
  options.episodes = episodes;
  options.hidden = {32};
  options.imitation = 0;
  options.stop_when_proved = false;
  return options;
}

/// The first random problems whose greedy plan is not the best.
std::vector<std::uint64_t> trapping_seeds() {
  return {4, 13, 24};
}

/// The plan never earns more than brute force finds, and where `greedy` misses the optimum the
/// network that training ends with mostly does not: what it does better it has learned.
TEST_F(OnStates, RandomProblemsOfEveryKindAreLearned) {
  std::size_t greedy_misses = 0;
  std::size_t learned = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(40); ++seed) {
    const ProblemSpec spec = wide_random_problem(seed);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    if (!system.wide()) continue;
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + problem_text(problem));
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    const Training training = train(system, without_help(800), Budget{});
    if (!truth.best) {
      EXPECT_EQ(training.result.status, Status::Infeasible);
      continue;
    }
    ASSERT_TRUE(training.result.has_plan());
    const double least = *truth.best - 1e-7;
    EXPECT_LE(training.result.reward, *truth.best + 1e-7);
    EXPECT_TRUE(training.result.status != Status::Optimal || training.result.reward >= least);
    const double missed = *truth.best - greedy(system, Budget{}).reward;
    if (missed < 1e-7) continue;
    ++greedy_misses;
    if (*truth.best - training.record.greedy < 0.5 * missed) ++learned;
  }
  EXPECT_GT(greedy_misses, 0U);
  EXPECT_GE(3 * learned, 2 * greedy_misses) << learned << " of " << greedy_misses;
}

/// From the bytes of its file a policy makes the plan that training says it makes.
TEST_F(OnStates, APolicyOutlivesItsFile) {
  for (const std::uint64_t seed : trapping_seeds()) {
    const Problem problem(wide_random_problem(seed));
    const TransitionSystem system(problem);
    ASSERT_TRUE(system.wide());
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Training training = train(system, without_help(200), Budget{});
    const PolicyFile file{problem_digest(problem), problem.name(), training.trained};
    const std::string bytes = policy_bytes(file);
    const PolicyFile read = parse_policy(bytes);
    EXPECT_EQ(read.trained.policy, training.trained.policy);
    const Result followed = follow_policy(system, read.trained.policy, Budget{});
    EXPECT_EQ(followed.reward, training.trained.reward);
    std::string damaged = bytes;
    damaged.replace(damaged.find("\"states\""), 8, "\"stores\"");
    EXPECT_THROW(static_cast<void>(parse_policy(damaged)), InputError);
  }
}

TEST_F(OnStates, TheSameSeedIsTheSameRunAndAnotherGoesOn) {
  const Problem problem(wide_random_problem(trapping_seeds().front()));
  const TransitionSystem system(problem);
  const DqnOptions options = without_help(160);
  const Training first = train(system, options, Budget{});
  const Training again = train(system, options, Budget{});
  EXPECT_EQ(first.trained.policy, again.trained.policy);
  EXPECT_EQ(first.trained.training.network, again.trained.training.network);
  DqnOptions other = options;
  other.seed = 4;
  EXPECT_NE(train(system, other, Budget{}).trained.policy, first.trained.policy);

  DqnOptions longer = options;
  longer.episodes = 320;
  const Training second = train(system, longer, Budget{}, {}, &first.trained);
  EXPECT_EQ(second.record.episodes, 320U);
  EXPECT_GT(second.record.updates, first.record.updates);
  EXPECT_GE(second.trained.reward, first.trained.reward);
  TrainedPolicy foreign = first.trained;
  foreign.training.hidden = {3};
  EXPECT_THROW(static_cast<void>(train(system, longer, Budget{}, {}, &foreign)), InputError);
}

TEST_F(OnStates, WhatMakesNoSenseIsRefused) {
  const Problem problem(wide_random_problem(trapping_seeds().front()));
  const TransitionSystem system(problem);
  DqnOptions options = without_help(100);
  options.inputs = NetworkInputs::Pieces;
  EXPECT_THROW(static_cast<void>(train(system, options, Budget{})), InputError);
  options.inputs = NetworkInputs::Auto;
  options.known_reward = false;
  EXPECT_THROW(static_cast<void>(train(system, options, Budget{})), InputError);

  const Policy of_states = train(system, without_help(80), Budget{}).trained.policy;
  ASSERT_TRUE(of_states.of_states);
  Policy of_actions = of_states;
  of_actions.of_states = false;
  EXPECT_TRUE(policy_obstacle(system, of_actions).has_value());
  Policy wider = of_states;
  wider.layers.front().inputs += 1;
  EXPECT_TRUE(policy_obstacle(system, wider).has_value());
  EXPECT_FALSE(policy_obstacle(system, of_states).has_value());
  EXPECT_THROW(PolicyEvaluator{of_states}, InputError);
}

/// A plan is there where a limit ends the training.
TEST_F(OnStates, LimitsAreKept) {
  const Problem problem(wide_random_problem(trapping_seeds().back()));
  const TransitionSystem system(problem);
  for (const std::uint64_t expansions : {15, 25}) {
    Budget budget;
    budget.max_expansions = expansions;
    const Training training = train(system, without_help(100'000), budget);
    EXPECT_EQ(training.result.stop, Stop::ExpansionLimit);
    EXPECT_TRUE(training.result.has_plan());
  }
}

}  // namespace
}  // namespace orasp
