// Passes that follow advice: whatever it says, what they prove is so.

#include "orasp/planners/detail/advised_pass.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/problem_source.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/random.h"
#include "orasp/planners/beam.h"
#include "orasp/planners/random_sequence.h"
#include "orasp/planners/value_iteration.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// Advice by a hash of state and step.
class Whim final : public StepAdvice {
 public:
  explicit Whim(std::uint64_t seed, std::atomic<std::uint64_t>* asked = nullptr)
      : seed_(seed), asked_(asked) {}
  void judge(SetView open, std::span<const Action> actions, std::span<double> against) override {
    if (asked_ != nullptr) ++*asked_;
    for (std::size_t i = 0; i < actions.size(); ++i)
      against[i] = static_cast<double>(
          mixed(hash_value(open) + seed_ + 97 * (actions[i].connection + 1U)) % 8);
  }

 private:
  std::uint64_t seed_;
  std::atomic<std::uint64_t>* asked_;
};

MakeAdvice whim(std::uint64_t seed, std::atomic<std::uint64_t>* asked = nullptr) {
  return [=](const TransitionSystem&) { return std::make_unique<Whim>(seed, asked); };
}

/// Advice that knows a plan.
class Prompter final : public StepAdvice {
 public:
  explicit Prompter(const std::vector<ConnectionIndex>& plan) : plan_(plan) {}
  void judge(SetView open, std::span<const Action> actions, std::span<double> against) override {
    const ConnectionIndex next = plan_[plan_.size() - count(open)];
    for (std::size_t i = 0; i < actions.size(); ++i)
      against[i] = actions[i].connection == next ? 0 : 1;
  }

 private:
  std::vector<ConnectionIndex> plan_;
};

TEST(AdvisedPass, BoundsWhatItLeavesOutAndProvesTheOptimum) {
  int left_out = 0;
  int none = 0;
  int solved = 0;
  for (std::uint64_t seed = 0; seed < some_of(std::uint64_t{400}); ++seed) {
    const Problem problem(seed % 4 == 3 ? larger_random_problem(seed) : random_problem(seed));
    const TransitionSystem system(problem);
    if (system.wide() || system.infeasibility()) continue;
    const Result best = value_iteration(system, {}, {});
    const MakeAdvice advice = whim(seed);
    detail::AdvisedPass pass(system, advice, BoundKind::Best, nullptr, 1);
    Result result;
    for (std::size_t width = 1; width <= 1U << 14U; width *= 2) {
      const double left = pass.run(width, 1e-9, {}, result);
      ASSERT_EQ(result.stop, Stop::None);
      if (result.has_plan()) {
        const PlanCheck check = check_plan(problem, system.situation(), result.sequence);
        ASSERT_TRUE(check.legal) << seed << check.fault;
        EXPECT_NEAR(check.reward, result.reward, 1e-7) << seed;
      }
      if (best.has_plan()) {
        const double most = std::max(left, result.has_plan() ? result.reward : -kInfinity);
        EXPECT_GE(most, best.reward - 1e-7) << seed << " at width " << width;
      }
      if (left == -kInfinity) break;
      ++left_out;
      ASSERT_LT(width, 1U << 14U) << "a small problem is gone through at last";
    }
    ASSERT_EQ(result.has_plan(), best.has_plan()) << seed;
    if (!best.has_plan()) {
      ++none;
      continue;
    }
    ++solved;
    EXPECT_NEAR(result.reward, best.reward, 1e-7) << seed;
  }
  EXPECT_GT(left_out, more_than(200));
  EXPECT_GT(solved, more_than(200));
  EXPECT_GT(none, more_than(10));
}

TEST(AdvisedPass, AsWideAsOneStateItFollowsTheAdvice) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Problem problem = find_problem("grid:3x4");
    const TransitionSystem system(problem);
    const Result plan = random_sequence(system, {.seed = seed}, {});
    const MakeAdvice advice = [&](const TransitionSystem&) {
      return std::make_unique<Prompter>(plan.sequence);
    };
    detail::AdvisedPass pass(system, advice, BoundKind::Best, nullptr, 1);
    Result result;
    static_cast<void>(pass.run(1, 1e-9, {}, result));
    ASSERT_TRUE(result.has_plan());
    EXPECT_EQ(result.sequence, plan.sequence) << seed;
    // A better plan is never given away for what the advice says.
    Result better = result;
    better.reward += 1;
    static_cast<void>(pass.run(1, 1e-9, {}, better));
    EXPECT_EQ(better.reward, result.reward + 1);
  }
}

/// A product with limits whose bound under `time` is loose.
Problem loose(const std::string& name) {
  ProblemSpec spec = find_problem(name).spec();
  SplitMix64 random(7);
  for (auto& part : spec.parts)
    part.position = {10 * random.uniform(), 10 * random.uniform(), 10 * random.uniform()};
  spec.objective = Objective::named("time");
  spec.limits.max_subassemblies = 4;
  spec.limits.max_moved_parts = 3;
  return Problem(std::move(spec));
}

TEST(AdvisedPass, BeamTakesAdviceAndIsTheSameForAnyNumberOfThreads) {
  const Problem problem = loose("grid:6x6");
  const TransitionSystem system(problem);
  Budget budget;
  budget.max_expansions = 60'000;
  const Result without = beam(system, {}, budget);
  std::atomic<std::uint64_t> asked = 0;
  const MakeAdvice advice = whim(5, &asked);
  const Result one = beam(system, {.advice = &advice}, budget);
  EXPECT_GT(asked, 100U);
  EXPECT_LT(asked, 2'000U) << "questions are dear";
  EXPECT_NEAR(*one.bound, *without.bound, 1e-9) << "here both prove what the start's bound says";
  budget.threads = 3;
  const Result three = beam(system, {.advice = &advice}, budget);
  EXPECT_EQ(three.sequence, one.sequence);
  EXPECT_EQ(three.reward, one.reward);
  EXPECT_EQ(three.statistics.expanded, one.statistics.expanded);
}

TEST(AdvisedPass, BeamDoesNotAskWhereTheBoundIsTightOrTheSearchGoesBackwards) {
  std::atomic<std::uint64_t> asked = 0;
  const MakeAdvice advice = whim(5, &asked);
  const Problem tight = find_problem("jwst-upc");
  EXPECT_EQ(beam(TransitionSystem(tight), {.advice = &advice}, {}).status, Status::Optimal);
  EXPECT_EQ(asked, 0U);
  ProblemSpec spec = loose("grid:5x5").spec();
  spec.direction = Direction::Assembly;
  const Problem backwards(std::move(spec));
  Budget budget;
  budget.max_expansions = 30'000;
  const TransitionSystem system(backwards);
  static_cast<void>(beam(system, {.advice = &advice}, budget));
  EXPECT_EQ(asked, 0U) << "it judges steps forwards";
}

}  // namespace
}  // namespace orasp
