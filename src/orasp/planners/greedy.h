#pragma once

#include "orasp/model/transition_system.h"
#include "orasp/planners/budget.h"
#include "orasp/planners/result.h"

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

}  // namespace orasp
