#pragma once

#include <cstdint>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/model/transition_system.h"
#include "orasp/symmetry/symmetry.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

struct OraspSearchOptions {
  /// The seed of the random sequence that is the first incumbent.
  std::uint64_t seed = 1;
  /// The bound on what is left; None is that of the paper.
  BoundKind bound = BoundKind::Best;
  /// A bound of the same system, whose prices serve again; it must outlive the call.
  const Bound* like = nullptr;
  /// A result of the same problem: its plan is the first incumbent instead.
  const Result* incumbent = nullptr;
  SymmetryUse symmetry = SymmetryUse::Off;
};

/// Finds an optimal plan by the paper's ORASP Search: depth-first branch and bound that generates H
/// as it goes.
///
/// Idea.       A random legal sequence is the first incumbent; where rewards depend on when steps
///             come, its steps are moved about first (detail/order_search.h). The search expands
///             recursively, best promise first (reward plus bound; with the paper's bound: best
///             reward first); a branch is abandoned as soon as its running reward plus a proved
///             upper bound on what is left cannot beat the incumbent, and so is a state met again
///             no better than before. A better complete sequence becomes the incumbent.
///             With symmetry (symmetry/symmetry.h) a state is met again where one is met into which
///             an exchange of equal parts takes it: the search itself goes on in the state where it
///             is, so that its sequences stay what they are. SymmetryUse::Auto looks for it after
///             2,000 expansions and then begins anew with the plan found so far, so that small
///             searches take none.
/// Reference.  The paper, section "ORASP Method", which assumes rewards of at most zero (there the
///             bound is 0). Rewards above zero, and stronger bounds: bounds/bound_kinds.h.
/// Guarantee.  Exact but for rounding: nothing is abandoned that could beat the incumbent by more
///             than kRewardTolerance and the rounding error of a sum of so many rewards.
/// Cost.       At worst every state once for each better path to it; one table entry (key, reward)
///             a state met.
/// Limit.      The table must fit in budget.max_bytes; stopped there it keeps the incumbent.
/// Repeatable. Seeded; ties go to the lowest connection.
/// @throws InputError where the bound knows nothing about the problem (a callable without a range,
///         an `expression` that may yield any number): the sentence names the methods that need
///         none; and where symmetry is asked for and nothing is known of it.
[[nodiscard]] Result orasp_search(const TransitionSystem& system, const OraspSearchOptions& options,
                                  const Budget& budget);

}  // namespace orasp
