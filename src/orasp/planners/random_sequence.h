#pragma once

#include <cstdint>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

struct RandomOptions {
  std::uint64_t seed = 1;
};

/// Draws one legal sequence: in every state each legal action is as likely as any other.
///
/// Reference.  The paper's random sequences (section "Reinforcement learning methods"): the
///             distribution to beat.
/// Guarantee.  A plan if there is one (Feasible); Infeasible only after everything was tried. At a
///             dead end it goes back one step and draws among the actions not tried there; failed
///             states are remembered.
/// Cost.       As greedy.
/// Repeatable. The same seed gives the same sequence on every machine (SplitMix64).
[[nodiscard]] Result random_sequence(const TransitionSystem& system, const RandomOptions& options,
                                     const Budget& budget);

}  // namespace orasp
