#pragma once

#include "orasp/model/transition_system.h"
#include "orasp/planners/budget.h"
#include "orasp/planners/result.h"

namespace orasp {

/// H up to this many actions is simply built: it takes seconds and gives a proof.
inline constexpr double kAutomaticMostActions = 2e8;

/// Chooses a method by the size of the problem and says which and why (Result::method,
/// Result::notes).
///
/// Idea.       Where H has at most kAutomaticMostActions actions and fits: value-iteration, which
///             proves the optimum. Elsewhere a greedy plan first: if it earns as much as the upper
///             bound (planners/bounds.h) it is proved; otherwise orasp-search from there to the
///             limit. Where no bound is known the greedy plan is the answer.
/// Guarantee.  That of the method chosen.
[[nodiscard]] Result automatic(const TransitionSystem& system, std::uint64_t seed,
                               const Budget& budget);

}  // namespace orasp
