#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/detail/checked_reward.h"
#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// A step of a plan whose objective looks at the steps before, kept until all of them are known.
struct KeptStep {
  SeenStep seen{};
  Step step{};
  /// The directions in which the moved piece may be said to leave; none: nothing moves.
  std::vector<DirectionIndex> ways{};
};

/// What the steps of a plan earn, in its order, where the objective looks back. A step that may be
/// given several directions is given those that earn most together: the best course for each
/// direction that may be in force is carried along, and Step::direction is set to the best. O(steps
/// * directions^2).
[[nodiscard]] std::vector<CheckedReward::Value> rewards_looking_back(const Problem& problem,
                                                                     const CheckedReward& reward,
                                                                     const Situation& situation,
                                                                     std::span<KeptStep> steps);

}  // namespace orasp::detail
