#pragma once

#include "orasp/model/transition_system.h"
#include "orasp/planners/step_advice.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// H up to this many actions is simply built: it takes seconds and gives a proof.
inline constexpr double kAutomaticMostActions = 2e8;

/// Chooses a method by the size of the problem and its objective, and says what it did and why
/// (Result::notes).
///
/// Idea.       Where the objective sees the piece only, first a plan that meets the bound on its
///             pieces: it is optimal, at any size; then a short and-or. Where H has at most
///             kAutomaticMostActions actions and fits, value-iteration. Elsewhere beam from the
///             best plan so far and and-or in turn, each turn twice as long as the one before, or
///             four times where that one has narrowed the gap, until the best plan meets the least
///             bound of all, or to the limit; where and-or no longer lowers the bound, once with
///             prices of larger pieces; after a few turns, where memory and time allow, dense value
///             iteration.
/// Guarantee.  Optimal only with one of these proofs; otherwise the best plan found and the least
///             bound proved. The same for any number of threads, unless a limit stops it.
/// @param known  A plan to begin with, or null: only better ones are looked for. Not where
///               TransitionSystem::wide().
/// @param advice  Or null: BeamOptions::advice of its turns with beam.
[[nodiscard]] Result automatic(const TransitionSystem& system, std::uint64_t seed,
                               const Budget& budget, const Result* known = nullptr,
                               const MakeAdvice* advice = nullptr);

}  // namespace orasp
