#pragma once

#include "orasp/model/transition_system.h"
#include "orasp/planners/budget.h"
#include "orasp/planners/result.h"

namespace orasp {

/// H up to this many actions is simply built: it takes seconds and gives a proof.
inline constexpr double kAutomaticMostActions = 2e8;

/// Chooses a method by the size of the problem and its objective, and says what it did and why (Result::notes).
///
/// Idea.       Where the objective sees only sizes, a greedy plan guided by SizeBound first: if it earns as much as the
///             bound it is optimal, at any size. Otherwise, where H has at most kAutomaticMostActions actions and fits,
///             value-iteration. Elsewhere orasp-search from the best greedy plan to the limit; where no bound is known
///             (planners/bounds.h) the greedy plan is the answer.
/// Guarantee.  Optimal only with one of these proofs; otherwise the best plan found and the best bound known.
[[nodiscard]] Result automatic(const TransitionSystem& system, std::uint64_t seed,
                               const Budget& budget);

}  // namespace orasp
