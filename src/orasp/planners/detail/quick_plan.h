#pragma once

#include <cstddef>

#include "orasp/model/transition_system.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// Beyond so many connections a method that looks at states may take long to have any plan.
inline constexpr std::size_t kManyConnections = 600;
/// See quick_plan().
inline constexpr std::size_t kMostListed = 20'000'000;

/// Some plan of a large problem, in near linear time: the better one of two.
///
/// Idea.       One takes off part after part: of the connections that precedence lets go, next
///             comes one of a part that has fewest left (as smallest-last orders do: Matula and
///             Beck 1983, J. ACM 30(3), 417-427), and then what is left of that part. The other,
///             where there is no precedence, halves first: of each large piece, what lies nearer to
///             one end goes off the rest (level structures as in nested dissection: George 1973,
///             SIAM J. Numer. Anal. 10(2), 345-363). What steps separate is found at the end, by
///             putting the connections back in the opposite order and joining the pieces (union by
///             size: Tarjan 1975, J. ACM 22(2), 215-225), so no state is ever looked at.
/// Applies.    To systems that take apart, one connection a step, where nothing judges cuts (no
///             limits, no blocking), precedence asks for absence alone (no `made_after_any`),
///             nothing is ordered and rewards depend on sizes alone. Without a plan where it does
///             not apply, where precedence can never be met, and where the pieces of all steps
///             hold more than kMostListed parts together: to write such a plan takes longer than
///             to find it.
/// Guarantee.  The plan is legal; nothing is said of how good it is.
/// Cost.       O((connections + ids in precedence) log connections).
[[nodiscard]] Result quick_plan(const TransitionSystem& system);

}  // namespace orasp::detail
