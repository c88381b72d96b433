#include "orasp/model/validate.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/detail/wording.h"
#include "orasp/model/random.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using Ids = std::vector<std::string>;

Evaluation evaluate_ids(const ProblemSpec& spec, const Ids& ids) {
  return evaluate(Problem(spec), std::span<const std::string>(ids));
}

// The one plan of the sandwich: 0 - (0.0967 + 0.1248) + 1 = 0.7785.
TEST(Evaluate, AddsUpALegalPlan) {
  const Evaluation evaluation = evaluate_ids(instances::sandwich(), {"1-2", "2-3", "1-3"});
  EXPECT_TRUE(evaluation.valid);
  EXPECT_TRUE(evaluation.violations.empty());
  ASSERT_EQ(evaluation.steps.size(), 3U);
  EXPECT_EQ(evaluation.steps[0].reward, 0);
  EXPECT_NEAR(evaluation.steps[1].reward, -0.2215, 1e-12);
  EXPECT_EQ(evaluation.steps[2].reward, 1);
  EXPECT_NEAR(evaluation.reward, 0.7785, 1e-12);
}

// 1-3 first is legal, but then 1-2 pulls 1 out of the middle (step 2); 2-3 is free of both by step
// 3.
TEST(Evaluate, NamesTheViolatedConstraintAndTheStep) {
  const Evaluation evaluation = evaluate_ids(instances::sandwich(), {"1-3", "1-2", "2-3"});
  EXPECT_FALSE(evaluation.valid);
  ASSERT_EQ(evaluation.violations.size(), 1U);
  EXPECT_EQ(evaluation.violations[0].step, 2U);
  EXPECT_EQ(evaluation.violations[0].connection, "1-2");
  EXPECT_EQ(constraint_name(evaluation.violations[0].violation.constraint), "blocking");
  EXPECT_EQ(evaluation.steps.size(), 3U);  // judged to the end
}

TEST(Evaluate, ReportsEveryFaultOfAList) {
  const Evaluation evaluation =
      evaluate_ids(instances::greedy_trap(), {"1-2", "9-9", "1-2", "2-3"});
  EXPECT_FALSE(evaluation.valid);
  ASSERT_EQ(evaluation.violations.size(), 3U);
  EXPECT_EQ(evaluation.violations[0].connection, "9-9");  // unknown
  EXPECT_EQ(evaluation.violations[0].step, 2U);
  EXPECT_EQ(evaluation.violations[1].connection, "1-2");  // for the second time
  EXPECT_EQ(evaluation.violations[1].step, 3U);
  EXPECT_EQ(evaluation.violations[2].connection, "3-4");  // missing
  EXPECT_EQ(evaluation.steps.size(), 2U);
}

// A plan file may hold any text in the place of an id, and messages go to terminals.
TEST(Evaluate, EscapesAnIdThatTheProblemDoesNotHave) {
  const Evaluation evaluation = evaluate_ids(instances::one_connection(), {"1-2", "\x1b[31m"});
  ASSERT_EQ(evaluation.violations.size(), 1U);
  EXPECT_EQ(evaluation.violations[0].violation.message,
            "the problem has no connection " + detail::in_quotes("\x1b[31m"));
  EXPECT_EQ(evaluation.violations[0].violation.message.find('\x1b'), std::string::npos);
}

TEST(Evaluate, TheEmptyPlanOfNothingIsValid) {
  EXPECT_TRUE(evaluate_ids(instances::nothing(), {}).valid);
  EXPECT_FALSE(evaluate_ids(instances::one_connection(), {}).valid);
}

TEST(Evaluate, APlanFromAStartWithTooManySubassembliesIsNotValid) {
  ProblemSpec spec = instances::two_pieces();
  spec.limits.max_subassemblies = 1;
  EXPECT_FALSE(evaluate_ids(spec, {"1-2", "3-4"}).valid);
}

// Sequences of all connections in any order, legal or not: every step's verdict is the oracle's.
TEST(Evaluate, AgreesWithTheOracleOnAnySequence) {
  int valid = 0;
  int invalid = 0;
  for (std::uint64_t seed = 4000; seed < 4000 + some_of(300U); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    const Problem problem(spec);
    SplitMix64 random(seed);
    for (int round = 0; round < 5; ++round) {
      std::vector<ConnectionIndex> sequence(problem.num_connections());
      std::iota(sequence.begin(), sequence.end(), 0U);
      for (std::size_t i = sequence.size(); i > 1; --i)
        std::swap(sequence[i - 1], sequence[random.below(i)]);
      SCOPED_TRACE(spec.name);
      const Evaluation evaluation = evaluate(problem, std::span<const ConnectionIndex>(sequence));
      const oracle::OracleReplay replay = oracle::replay(spec, sequence);
      ASSERT_EQ(evaluation.valid, replay.valid);
      ++(replay.valid ? valid : invalid);
      ASSERT_EQ(evaluation.steps.size(), replay.steps.size());
      ASSERT_NEAR(evaluation.reward, replay.reward, reward_tolerance(replay.reward));
      std::set<std::size_t> bad;
      for (const StepViolation& violation : evaluation.violations) {
        if (violation.step > 0) bad.insert(violation.step);  // 0: the start itself
      }
      for (std::size_t i = 0; i < replay.steps.size(); ++i) {
        // A step that comes too late is not blamed.
        const bool blamed = replay.steps[i].broken != replay.steps[i].too_late;
        ASSERT_EQ(bad.contains(i + 1), blamed) << "step " << i + 1;
      }
    }
  }
  EXPECT_GE(valid, more_than(300));
  EXPECT_GE(invalid, more_than(300));
}

}  // namespace
}  // namespace orasp
