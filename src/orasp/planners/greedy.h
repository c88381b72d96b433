#pragma once

#include "orasp/bounds/piece_bound.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Takes the action with the greatest reward in every state; a first plan for any size.
///
/// Idea.       Depth first, best reward first. At a dead end it goes back one step and takes the
///             next best; states from which everything failed are remembered, so none is tried
///             twice.
/// Guarantee.  A plan if there is one, not the best one (Feasible); Infeasible only after
///             everything was tried.
/// Cost.       O(connections * (parts + connections)) without dead ends; exponential at worst with
///             them, and one table entry for each failed state.
/// Repeatable. Ties go to the lowest connection.
[[nodiscard]] Result greedy(const TransitionSystem& system, const Budget& budget);

/// The same, but what counts is the reward and what it does to the bound on the rest: an action
/// that keeps the bound within reach comes before all others. `bound` must be known(). Where every
/// choice keeps it the plan meets the bound and so is optimal; the caller compares.
[[nodiscard]] Result guided_greedy(const TransitionSystem& system, PieceBound& bound,
                                   const Budget& budget);

/// Looks for a plan that meets the bound, and so is optimal: depth first over the actions that lose
/// nothing against it. Feasible with such a plan, Unknown without one (there may be none, or the
/// budget ended). `bound` must be known(); the caller compares the rewards, since the bound of the
/// last step is an upper one.
[[nodiscard]] Result plan_at_bound(const TransitionSystem& system, PieceBound& bound,
                                   const Budget& budget);
/// The same for what is left of a plan, from the state `from` on.
[[nodiscard]] Result rest_at_bound(const TransitionSystem& system, PieceBound& bound,
                                   const ConnectionSet& from, const Budget& budget);

}  // namespace orasp
