#pragma once

#include "orasp/bounds/bound_kinds.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/step_advice.h"
#include "orasp/symmetry/symmetry.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

namespace detail {
class Crew;
}

struct BeamOptions {
  BoundKind bound = BoundKind::Best;
  /// A bound of the same system, whose prices serve again; it must outlive the call.
  const Bound* like = nullptr;
  /// A plan to start from; it must outlive the call.
  const Result* incumbent = nullptr;
  /// What to look at first where the bound is loose; it must outlive the call. Not with a crew. Not
  /// looked at where the search goes backwards, since it judges steps forwards.
  const MakeAdvice* advice = nullptr;
  /// A bound on what any plan earns that is proved already.
  double most = kInfinity;
  SymmetryUse symmetry = SymmetryUse::Off;
  /// Copies of this search that share its work (planners/detail/crew.h); null where it is alone.
  detail::Crew* crew = nullptr;
};

/// Finds better and better plans by complete anytime beam search, of any objective and at any size.
///
/// Idea.       Layer by layer, one for each step; of each layer only the `width` states that
///             promise most are kept: those with the greatest reward so far plus bound on the rest.
///             The width doubles from pass to pass. A state that cannot beat the best plan found is
///             left out for good; one that finds no room is not, and the greatest promise among
///             those is a bound on what the pass has not seen. Equal promises are ordered by a hash
///             of the state, another in each pass. Where rewards depend on when steps come, the
///             steps of each new plan are moved about (detail/order_search.h), and where one step
///             alone need be followed, no other is (detail/step_in_front.h). With symmetry
///             (symmetry/symmetry.h) each state is exchanged for the one that stands for it;
///             SymmetryUse::Auto looks for it where a pass begins after 10,000 expansions, and not
///             where steps are followed alone. With advice, passes that keep what it says least
///             against (detail/advised_pass.h) come between these as long as the best plan is a
///             thousandth or more below what is proved; they share no state with them and take
///             less than half of the time.
/// Reference.  Zhang (1998), Complete anytime beam search, AAAI; Libralesso, Bouhassoun, Cambazard
///             and Jost (2020), Tree search for the sequential ordering problem, ECAI; Kuroiwa and
///             Beck (2023), Solving domain-independent dynamic programming problems with anytime
///             heuristic search, ICAPS.
/// Guarantee.  A plan in milliseconds, never a worse one later. Optimal when a pass left nothing
///             out for want of room, or when the best plan meets the bound. Where no bound is known
///             only the first of these proves.
/// Cost.       A pass: O(width * connections) expansions; memory O(width * connections) steps and
///             the layer's states.
/// Limit.      Memory, by budget.max_bytes.
/// Repeatable. The same for any number of threads: a layer's states are expanded in parallel and
/// merged in order. The same for any crew, of which each member holds the states whose hash names
/// it.
[[nodiscard]] Result beam(const TransitionSystem& system, const BeamOptions& options,
                          const Budget& budget);

}  // namespace orasp
