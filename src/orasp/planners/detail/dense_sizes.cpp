#include "orasp/planners/detail/dense_sizes.h"

#include <algorithm>
#include <optional>

namespace orasp::detail {

namespace {

/// The greatest sizes as TransitionSystem::reward_range tells them; empty where it does not.
std::optional<RewardSizes> known_sizes(const TransitionSystem& system) {
  const std::size_t n = system.num_connections();
  RewardSizes sizes;
  for (ConnectionIndex c = 0; c < n; ++c) {
    for (const bool completes : {false, true}) {
      const RewardRange range = system.reward_range(c, n, completes);
      double& size = completes ? sizes.last : sizes.step;
      size = std::max({size, std::abs(range.least), std::abs(range.greatest)});
    }
  }
  if (!std::isfinite(sizes.step) || !std::isfinite(sizes.last)) return std::nullopt;
  return sizes;
}

/// A guess where they are not known: twice what is met on the way of the greedy plan.
RewardSizes sampled_sizes(const TransitionSystem& system) {
  Expander expander(system);
  double most = 0;
  for (Mask mask = bit(system.num_connections()) - 1; mask != 0;) {
    const auto actions = expander.legal_actions(SetView(&mask, 1));
    if (actions.empty()) break;
    for (const Action& action : actions) most = std::max(most, std::abs(action.reward));
    mask ^= bit(std::ranges::max_element(actions, {}, &Action::reward)->connection);
  }
  if (most == 0) most = 1;
  return {2 * most, 2 * most};
}

}  // namespace

RewardSizes reward_sizes(const TransitionSystem& system) {
  const auto known = known_sizes(system);
  return known ? *known : sampled_sizes(system);
}

}  // namespace orasp::detail
