#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// What the check of a plan found.
struct PlanCheck {
  bool legal = false;
  /// The first step at which a rule is broken, from 1; 0 if the start breaks one (or none is
  /// broken), and one more than there are steps if something is missing at the end.
  std::size_t step = 0;
  /// One sentence that names step, connection and rule: step 3 removes "1-2", but ...; empty if the
  /// plan is legal.
  std::string fault;
  double reward = 0;  ///< the sum over the steps that can be made
  /// Of each of them, in the order of the plan; empty where steps take parts.
  std::vector<double> rewards;
  /// By how much another honest sum of the same rewards can differ: 1e-9 of the sum of the absolute
  /// values of all rewards and terms (or of 1, if that is less), and what positions, masses and
  /// formulas that look at them lose when they are added up in another order.
  double tolerance = 0;
};

/// Checks a plan: whether every step is legal, nothing is missing, and what it earns.
/// Problem.   An answer leaves the program only if something that shares no formula with whoever
///            found it agrees: a mistake in the rules that planners follow would otherwise pass
///            every replay by the same rules.
/// Idea.      The plan is replayed in the direction in which pieces only merge, from the problem's
///            own data: ends, masses, positions, clauses, blockers, limits, and the sentences of
///            docs/format.md about rewards, written a second time. TransitionSystem and Expander
///            are not used.
/// Guarantee. As in TransitionSystem, `situation` says what is open, inaccessible, cannot be next
///            and is late; `sequence` holds the steps still to come, in the order of the problem's
///            direction. `directions` is empty or has the direction that the plan states for each
///            step, if any: a step breaks a rule if its moved piece cannot leave in it. It means
///            nothing where nothing moves or the problem has no blocking. Where attempts may fail,
///            the reward is that of the plan in which none does.
/// Cost.      O((parts + connections) log parts + size of precedence and blocking * log parts): a
///            few milliseconds for 16,384 parts. A callable sees whole steps: O(parts) for each of
///            them. A late step that is made while others are open costs O(parts + connections) for
///            each of these at worst.
/// Limit.     Two masses count as the same if they differ by at most 1e-9, relatively. Where sums
///            of masses differ by that to the last bit, rounding decides.
/// Errors.    @throws InputError where an expression or a callable yields a reward that is not
///            finite, an expression cannot be compiled, the objective is one of fleets, or
///            the situation is over other connections, or there are directions for another number
///            of steps.
[[nodiscard]] PlanCheck check_plan(const Problem& problem, const Situation& situation,
                                   std::span<const ConnectionIndex> sequence,
                                   std::span<const std::optional<DirectionIndex>> directions = {});
/// The same for a plan where there is more to steps (TransitionSystem::wide).
[[nodiscard]] PlanCheck check_plan(const Problem& problem, const Situation& situation,
                                   std::span<const PlanStep> steps);

namespace detail {
struct PlanFault;
/// One sentence about a fault of a plan with so many steps.
[[nodiscard]] std::string fault_sentence(const Problem& problem, const PlanFault& fault,
                                         std::size_t steps);
}  // namespace detail

/// Whether `claimed` is the reward that `check` found, within its tolerance. Nothing but NaN is the
/// same as NaN.
[[nodiscard]] bool same_reward(double claimed, const PlanCheck& check);

}  // namespace orasp
