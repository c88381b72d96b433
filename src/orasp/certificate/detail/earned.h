#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "orasp/certificate/detail/attempts.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// What a plan earns, and how far sums of its rewards may be off, twice.
struct Earned {
  double reward = 0;
  double tolerance = 0;
};

/// By the replay of a plan, which has every attempt succeed: with the attempts that each step takes
/// on average.
[[nodiscard]] inline Earned earned_by(const Problem& problem, const PlanCheck& replay,
                                      std::span<const ConnectionIndex> plan) {
  if (!problem.uncertain()) return {replay.reward, 2 * replay.tolerance};
  Earned earned;
  double most = 1;
  for (std::size_t i = 0; i < std::min(plan.size(), replay.rewards.size()); ++i) {
    const double attempts = 1 / problem.connections()[plan[i]].success;
    earned.reward += replay.rewards[i] * attempts;
    most = std::max(most, attempts);
  }
  earned.tolerance = 2 * replay.tolerance * most;
  return earned;
}

}  // namespace orasp::detail
