#pragma once

#include "orasp/bounds/bound_kinds.h"
#include "orasp/model/transition_system.h"
#include "orasp/symmetry/symmetry.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

struct AStarOptions {
  BoundKind bound = BoundKind::Best;
  SymmetryUse symmetry = SymmetryUse::Off;
};

/// Finds an optimal plan by A*: expands the state whose path so far and bound on the rest promise
/// most.
///
/// Idea.       f(s) = g(s) + h(s), g the best reward from the start and h an upper bound on what is
///             left (bounds/bound_kinds.h). Nothing that promises less than the optimum is ever
///             expanded. All paths to a state have the same length, and h is consistent, so a state
///             is expanded once but for rounding. Values of f that differ by less than
///             kRewardTolerance are equal, and among equals the state nearest to the goal comes
///             first, then the latest.
///             With symmetry (symmetry/symmetry.h) each state met is exchanged for the one that
///             stands for it; h is worked out anew where that one is expanded, since a bound may
///             say more of one than of the other, and a state may then be expanded again.
///             SymmetryUse::Auto looks for it after 2,000 expansions and then begins anew, so that
///             what is quickly done does not pay for it.
/// Reference.  Hart, Nilsson and Raphael (1968), IEEE Trans. Systems Science and Cybernetics 4(2),
///             100-107.
/// Guarantee.  Exact. Stopped early: the greedy plan, and the greatest f still open as a proved
///             bound.
/// Cost.       Held per state generated: its key, 12 to 24 bytes of index, 8 for g, 2 for the step
///             that led there (6 with symmetry); 16 an open entry.
/// Limit.      Memory, by budget.max_bytes.
/// Repeatable. No random numbers; one thread.
/// @throws InputError where the bound knows nothing about the problem, or where symmetry is asked
/// for and nothing is known of it.
[[nodiscard]] Result a_star(const TransitionSystem& system, const AStarOptions& options,
                            const Budget& budget);

}  // namespace orasp
