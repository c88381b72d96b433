#pragma once

#include <span>
#include <string>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// A constraint that bears on a step of a plan and is met, and why, said for both orders of the
/// plan.
struct Ground {
  Constraint constraint = Constraint::Precedence;
  /// The place in the problem file, such as "precedence[2]" or "limits.max_moved_parts".
  std::string where;
  /// The reason as a sentence without its full stop, for a plan that takes apart and for one that
  /// puts together; steps are counted in the order of each.
  std::string disassembly;
  std::string assembly;
};

/// What allows each step of a plan: `steps` are those of evaluate(), in the order of the problem's
/// direction, from the start on. A step that no constraint bears on has no grounds. Constraints
/// that a step breaks are left out; they are in Evaluation::violations. Shares the rules with
/// Expander and nothing with planners. O(steps * (parts + connections)).
[[nodiscard]] std::vector<std::vector<Ground>> grounds(const TransitionSystem& system,
                                                       std::span<const Step> steps);

}  // namespace orasp
