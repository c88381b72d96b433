#pragma once

#include <cstddef>
#include <limits>
#include <string>

namespace orasp::detail {

/// The largest size of a reward that a step may have in a plan of so many steps. Sums of such
/// rewards and differences of such sums are finite, in whatever order they are added. Beyond it a
/// plan could be worth minus infinity, which is what having no plan is worth.
[[nodiscard]] constexpr double largest_reward(std::size_t steps) {
  return std::numeric_limits<double>::max() / (8.0 * static_cast<double>(steps + 1));
}

/// What is wrong with a reward that cannot be added up, to stand after "the reward of ... is ".
[[nodiscard]] std::string unfit_reward_text(double reward);

}  // namespace orasp::detail
