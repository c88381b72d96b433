#pragma once

#include "orasp/bounds/companion_bound.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// A plan that moves each group of companions at once and then apart, and every other part alone:
/// one that costs no more than CompanionBound says, if there is one.
///
/// Idea.       Depth first over what still holds the part that stays. A group that may leave by all
///             that is known (Departures) is taken off if what is left then still costs no more
///             than the bound: so a step after which two more parts would have to leave together is
///             seen at once, not at its end. What has failed is not looked at again. The group's
///             joints to the rest go first, then the group comes apart in the same way.
/// Guarantee.  The plan is replayed by check_plan, which says what it earns and whether it obeys
///             the rules. Where none is returned, there may be one all the same.
/// Cost.       Some Departures for each group, most of which are worked out from those before: 69
///             parts take 16 ms. It gives up after a second or two, and ends with the budget.
[[nodiscard]] Result companion_plan(const TransitionSystem& system, const CompanionBound& bound,
                                    const Budget& budget);

}  // namespace orasp::detail
