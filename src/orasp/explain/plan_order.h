#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "orasp/model/problem.h"

namespace orasp {

/// Positions in a sequence, from 0: the first must come before the second.
using OrderedPair = std::pair<std::size_t, std::size_t>;

/// What of a plan's order matters: pairs of its steps such that *every* order of the steps which
/// keeps them is a legal plan. Transitively reduced (no pair follows from others), ascending.
/// `sequence` is a legal plan in the order of the problem's direction; of anything else no claim is
/// made. Rewards may differ between these orders.
///
/// Idea.       In disassembly order (assembly: backwards). Precedence: a pair for each connection
///             of an `after`, and for the earliest one of an `after_any`, and goes before the last
///             one of a `made_after_any`. If a limit or blocking
///             judges cuts, also the plan's cut tree: each separating step t (a separator) cuts a
///             piece S into A and B. (i) Every other connection between A and B comes before t.
///             (ii) The separator that created S comes before t. If the tree could give more
///             subassemblies at a time than are allowed, (iii) the separators that change their
///             number keep the plan's order.
/// Proof.      Precedence is met: each entry's pairs imply it. Cuts: take any order that keeps the
///             pairs, and the steps done so far. By (ii) the separators among them are the upper
///             part of the cut tree. Call the pieces at its lower end leaves. Two leaves are not
///             connected: the separator t that parted them is done, and by (i) so is all else
///             between its A and B. A leaf S is connected: no separator below S is done, and they
///             are a spanning tree of S (by induction: those of A, those of B, and t between them;
///             a single part needs none, and the plan cuts down to single parts). So the pieces are
///             just the leaves. Hence a step that is no separator separates nothing, and a
///             separator cuts the same S into the same A and B as in the plan, where the limits on
///             moved pieces and blocking allowed it. Subassemblies: their number is that of the
///             start plus the changes done. Without (iii) no upper part of the tree exceeds the
///             limit. With (iii) the changes done are the first ones of the plan, so the number is
///             the start's, which is allowed, or one that the plan had after a separator.
/// Guarantee.  Sound, as proved; not the weakest such order: other cut trees may be legal too.
/// Cost.       O((connections + pairs) log connections) for the pairs: the cut tree is the
///             union-find tree of the plan made backwards. The reduction O(pairs kept * connections
///             / 64) time, connections^2 / 16 bytes: 17 MB for 16,384 connections.
/// Reference.  Transitive reduction: Aho, Garey and Ullman (1972), SIAM J. Computing 1(2), 131-137.
[[nodiscard]] std::vector<OrderedPair> plan_order(const Problem& problem,
                                                  std::span<const ConnectionIndex> sequence);

}  // namespace orasp
