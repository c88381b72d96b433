#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "orasp/model/transition_system.h"
#include "orasp/planners/detail/dense_numbers.h"
#include "orasp/task/result.h"

/// What the tables of all subsets on one process and on several share: the sizes of rewards, which
/// choose the number system, and what is proved in the end.
namespace orasp::detail {

/// The greatest sizes of rewards: of any step, and of the step that completes.
struct RewardSizes {
  double step = 0;
  double last = 0;
};

/// The greatest sizes as TransitionSystem::reward_range tells them; where it does not, a guess:
/// twice what is met on the way of the greedy plan.
[[nodiscard]] RewardSizes reward_sizes(const TransitionSystem& system);

/// Writes what is proved of the plan of `result`, which follows the best values, where `start` is
/// the value of the start and `error` the greatest rounding error of a step.
template <class Numbers>
void judge_dense(const Numbers& numbers, std::size_t connections, typename Numbers::Value start,
                 double error, Result& result) {
  result.status = Status::Optimal;
  result.bound = result.reward;
  if constexpr (std::is_same_v<Numbers, FixedPoint>) {
    const auto steps = static_cast<double>(connections);
    const double most = numbers.value(start) + steps * error;
    const double rounding = steps * std::numeric_limits<double>::epsilon() *
                            (steps * numbers.most_step + numbers.most_last);
    std::string unit = "1e" + std::to_string(std::lround(-std::log10(numbers.per_unit)));
    if (!std::isfinite(rounding) || most - result.reward > kRewardTolerance + rounding) {
      result.status = Status::Feasible;
      if (std::isfinite(most)) {
        result.bound = most;
      } else {
        result.bound.reset();
      }
      result.notes.push_back("values were rounded to multiples of " + unit +
                             ", to hold them in four bytes each; the bound allows for it");
    }
  }
}

}  // namespace orasp::detail
