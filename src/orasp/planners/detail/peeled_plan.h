#pragma once

#include "orasp/bounds/piece_bound.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// Plans that take one part off after another, in near linear time: the plans that meet the bound
/// wherever it is best to cut off single parts.
///
/// Idea.       Walk a spanning tree of each piece in preorder. Whatever part comes last in it can
///             be taken off, since what comes before it hangs together along the tree: all its
///             connections to them go, and the last of these separates it. So a whole plan is
///             known without a look at any state. Where it ends decides what it is worth, and
///             there are two such plans:
///             * One ends with the part that costs most to move, which so is never moved. That is
///               what the bound by what is moved (PiecePrices) asks for.
///             * One stops at pieces so small that single parts are no longer the best to cut off,
///               by the bound, and a search among the steps that keep the bound takes those apart
///               (plan_at_bound). The tree is one of breadth-first search from an end of the
///               piece, its deepest branch first, so what is left is a path as often as it can be,
///               and a path can be cut into any two sizes.
///             Both are replayed by check_plan, which says what they earn and whether they obey the
///             rules; one that does not is dropped.
/// Reference.  Every connected graph has a part that does not cut it, a leaf of a spanning tree:
///             Diestel, Graph Theory, proposition 1.4.1. The end of a piece by two searches:
///             Handler (1973), Transportation Science 7(3), 287-293.
/// Applies.    To systems that take apart, one connection a step, without precedence, in which
///             nothing is ordered. Without a plan elsewhere.
/// Guarantee.  The plan is legal and earns what it says; nothing is said of how good it is.
/// Cost.       O((parts + connections) log parts), and up to some hundreds of states for the small
///             pieces.
[[nodiscard]] Result peeled_plan(const TransitionSystem& system, PieceBound& bound,
                                 const Budget& budget);
/// The first of the two alone, where no bound is at hand, and not where a formula or a function of
/// the user works out rewards.
[[nodiscard]] Result peeled_plan(const TransitionSystem& system);

}  // namespace orasp::detail
