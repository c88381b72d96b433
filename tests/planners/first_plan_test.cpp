// greedy, random and exhaustive: what is theirs beyond the contract test.

#include <array>
#include <string>

#include <gtest/gtest.h>

#include "orasp/model/error.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/planners/exhaustive.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/random_sequence.h"
#include "tests/instances.h"
#include "tests/oracle.h"

namespace orasp {
namespace {

// greedy_trap: an end first (-0.2335 beats -0.2496), then the next; 0.5450 where 0.5570 is
// possible. Both ends tie: the lowest connection goes first.
TEST(Greedy, TakesTheBestRewardAndTheLowestConnection) {
  const Problem problem(instances::greedy_trap());
  const Result result = greedy(TransitionSystem(problem), Budget{});
  EXPECT_EQ(status_name(result.status), "feasible");
  EXPECT_NEAR(result.reward, 0.5450, 1e-12);
  EXPECT_EQ(result.sequence, (std::vector<ConnectionIndex>{0, 1, 2}));
}

TEST(Greedy, RemembersStatesThatFailed) {
  const Problem problem(instances::hopeless());
  const Result result = greedy(TransitionSystem(problem), Budget{});
  EXPECT_EQ(status_name(result.status), "infeasible");
  EXPECT_LE(result.statistics.expanded, 4'096U);
}

TEST(RandomSequence, RemembersStatesThatFailed) {
  const Problem problem(instances::hopeless());
  const Result result = random_sequence(TransitionSystem(problem), {}, Budget{});
  EXPECT_EQ(status_name(result.status), "infeasible");
  EXPECT_LE(result.statistics.expanded, 4'096U);
}

// Chain of four parts: 3 first actions, then 2: six sequences, each 1 in 6. Of 6,000 seeds 1,000
// each, with a standard deviation of 29; 150 is more than five of these.
TEST(RandomSequence, DrawsEachActionOfAStateEquallyOften) {
  const Problem problem(chain(4));
  const TransitionSystem system(problem);
  std::map<std::vector<ConnectionIndex>, int> times;
  for (std::uint64_t seed = 0; seed < 6000; ++seed)
    ++times[random_sequence(system, {.seed = seed}, Budget{}).sequence];
  EXPECT_EQ(times.size(), 6U);
  for (const auto& [sequence, number] : times) EXPECT_NEAR(number, 1000, 150);
}

// A single dead end must not bias or break the draw: the sandwich has one plan, whatever the seed.
TEST(RandomSequence, GoesBackFromADeadEnd) {
  const Problem problem(instances::sandwich());
  const TransitionSystem system(problem);
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    EXPECT_EQ(random_sequence(system, {.seed = seed}, Budget{}).sequence,
              (std::vector<ConnectionIndex>{1, 2, 0}));
  }
}

// 3 connections without constraints: 3! sequences and 1 + 3 + 6 + 6 = 16 nodes of the tree.
TEST(Exhaustive, ExpandsEveryNodeOfTheTree) {
  const Problem problem(instances::greedy_trap());
  const Result result = exhaustive(TransitionSystem(problem), Budget{});
  EXPECT_EQ(result.statistics.generated, 15U);
  EXPECT_EQ(status_name(result.status), "optimal");
  // Of the two best plans, middle first, the lexicographically smaller.
  EXPECT_EQ(result.sequence, (std::vector<ConnectionIndex>{1, 0, 2}));
}

TEST(Exhaustive, RefusesMoreThanTwelveConnections) {
  const Problem problem(chain(14));
  try {
    (void)exhaustive(TransitionSystem(problem), Budget{});
    FAIL() << "no error";
  } catch (const InputError& error) {
    const std::string text = error.what();
    for (const char* word : {"exhaustive", "12", "13"})
      EXPECT_NE(text.find(word), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace orasp
