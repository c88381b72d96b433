#pragma once

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/model/problem.h"
#include "tests/oracle.h"

namespace orasp {

/// Rewards agree to this, relative where they are large.
[[nodiscard]] inline double reward_tolerance(double reward) {
  return 1e-9 * std::max(1.0, std::isfinite(reward) ? std::abs(reward) : 1.0);
}

/// What planners run with where their answers must be right but not the best: training is one round
/// of episodes.
[[nodiscard]] inline Options quick_options() {
  Options options;
  options.dqn.episodes = 65;  // 64 random ones, and a round
  options.dqn.updates_per_step = 1;
  options.dqn.hidden = {16};
  return options;
}

/// Everything that must hold of any answer of any planner to `problem`, stopped or not: a plan is
/// legal and its reward is right (by the oracle and by evaluate()), claims of optimality and
/// infeasibility and the bound are true, and a planner that was not stopped has settled what it
/// must. `truth` is brute_force() of the problem.
void expect_honest(const Problem& problem, const oracle::OracleResult& truth,
                   const Planner& planner, const Result& result);

/// Two runs answered the same: everything but times and sizes.
void expect_same_answer(const Result& one, const Result& other);

/// An objective under which no bound is strong, so that no search is done at once: each step earns
/// between 0 and 1, by chance of its connection and of how many are present.
[[nodiscard]] Objective chance_objective();

/// A formula of finite values that nothing is known of but by trying.
[[nodiscard]] Objective unbounded_formula();

/// Whether reward_range() can know a bound: no expression and no callable without a range in the
/// objective.
[[nodiscard]] bool range_is_known(const Objective& objective);

}  // namespace orasp
