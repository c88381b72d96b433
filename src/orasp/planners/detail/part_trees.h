#pragma once

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// and_or() where steps take parts off (StepKind::Part): the best tree of such steps.
///
/// Idea.      Where the objective sees the piece only, what is best for a piece does not depend on
///            the others: the value of a piece is the most, over the steps that take a connected
///            set of parts off it, of what the step earns and of the values of the pieces that it
///            leaves, of which there may be many. Values are remembered by piece. The one step that
///            completes stands in one of the pieces: each has a second value for the case that it
///            is this one.
/// Guarantee. The value of the start bounds all plans: rules between pieces (precedence across
///            them, max_subassemblies, `after_any`, `made_after_any`) are left out of it, which
///            only adds plans. Where the tree can be carried out in some order of its steps, that
///            plan is Optimal. Infeasible where no tree takes everything apart. No bound where it
///            is stopped, but that of BoundKind::Best at the start.
/// Reference. Homem de Mello and Sanderson (1991), IEEE Trans. Robotics and Automation 7(2),
///            228-240.
/// Cost.      O(pieces * steps of a piece * (parts + connections)): the pieces are those connected
///            sets of parts that steps can leave, exponentially many at worst; blocking makes them
///            few.
/// Assembly.  The same tree, read from its leaves.
[[nodiscard]] Result part_trees(const TransitionSystem& system, const Budget& budget);

/// Whether steps take parts off and nothing else makes them wide: no goal, no costs between steps.
[[nodiscard]] bool takes_part_trees(const TransitionSystem& system);

}  // namespace orasp::detail
