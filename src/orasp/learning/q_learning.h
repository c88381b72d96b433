#pragma once

#include <cstdint>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

struct QLearningOptions {
  /// The seed of the choice among equally promising actions.
  std::uint64_t seed = 1;
  /// The bound at which the values start.
  BoundKind bound = BoundKind::Best;
};

/// Tabular Q-learning: episodes from the start, each of which learns from what it met.
///
/// Idea.       Q(s, a) is what removing a in s and the best steps after it earn together. An
///             episode takes the action with the greatest Q until nothing is left; then, from its
///             last step to its first (backward replay), Q(s, a) <- r(s, a) + max over a' of Q(s',
///             a'). The world is deterministic, so the learning rate is 1. Values start at an upper
///             bound on what they will be (optimism in the face of uncertainty), which is all the
///             exploration that is needed: what was not tried promises most. Where no bound is
///             known they start at infinity, and every action is tried.
/// Reference.  Watkins and Dayan (1992), Machine Learning 8, 279-292; backward replay: Lin (1992),
///             Machine Learning 8, 293-321; optimistic starts in deterministic domains: Koenig and
///             Simmons (1993), AAAI, 99-105.
/// Guarantee.  Values only fall and never below the truth, since r + max Q is an upper bound if the
///             Q are. So the greatest Q of the start is a bound at all times, and once an episode
///             earns it the plan is optimal. Each earlier episode lowers at least one value of
///             finitely many states: it ends with a proof, or, with all of the start's values at
///             -infinity, with the proof that there is no plan.
/// Cost.       24 bytes for each action of a state that was met and a table entry for the state:
///             for small problems. Episodes: at worst several for each action of H, few where the
///             bound is good.
/// Repeatable. The same seed gives the same episodes on every machine.
[[nodiscard]] Result q_learning(const TransitionSystem& system, const QLearningOptions& options,
                                const Budget& budget);

}  // namespace orasp
