#pragma once

#include <span>

#include "orasp/model/transition_system.h"
#include "orasp/model/validate.h"

namespace orasp {

/// evaluate() for a table of steps: of a legal plan, each step lists the parts that move and not
/// those that stay, which in a plan that takes thousands of parts off one by one are hundreds of
/// millions. Step::moved() and everything else is as there; sums of masses may differ in the last
/// digits. Where there is more to steps (TransitionSystem::wide), where the objective looks at
/// whole steps, and of a plan that is not legal, nothing is left out.
/// O((parts + connections) log parts), and what the lists hold.
[[nodiscard]] Evaluation evaluate_moves(const TransitionSystem& system,
                                        std::span<const ConnectionIndex> sequence);

}  // namespace orasp
