#pragma once

#include <optional>
#include <string>

#include "orasp/model/transition_system.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Finds a good policy where attempts may fail, and a bound on all of them, where the states that
/// attempts lead to are too many to list (uncertain_value_iteration() lists them).
///
/// Idea.       Each state has an upper bound U on its value, at first from the problem without
///             failures (see "Bound"). A trial goes from the start along the attempts that promise
///             most, taking of their outcomes the one that is not settled and weighs most, to the
///             end; on the way back it takes Bellman's equation at each state, which lowers U. A
///             state is settled when the outcomes of its best attempt are: then U is its value, for
///             a failure keeps or shrinks the set of open connections, so that what is left of
///             cycles, attempts that leave the state as it is, is solved in closed form.
/// Bound.      Let D bound the problem in which an attempt that is made again earns r / p and one
///             that ends the job r, and D(s without b) <= D(s) + w(b) if b comes off by itself.
///             Then
///
///                 U(s) = D(s) + sum over open c of what a failure of c may be worth,
///
///             which is q * (sum of w(b) over what it breaks and is still there), or
///             q * max(0, x - least of r + D) where it ends the job and earns x. An attempt lowers
///             the sum by its own term, which pays for its failure: no attempt promises more than
///             U, so U is admissible. Where no step but the last earns more than 0, so is
///             max(x, D(s) + sum of w(b)), x the most that an end may earn, without the factors q:
///             what leads to an end costs, and no outcome is above that. The smaller of the two is
///             taken.
/// Plan.       The policy that follows U is completed by the same choice wherever it has not been,
///             and evaluated exactly on the states that it can meet.
/// Reference.  Bonet and Geffner (2003), Labeled RTDP, ICAPS, 12-21; Hansen and Zilberstein (2001),
///             LAO*, Artificial Intelligence 129, 35-62; outcomes by their weight: McMahan,
///             Likhachev and Gordon (2005), Bounded real-time dynamic programming, ICML, 569-576.
/// Guarantee.  Result::bound holds at any time. Optimal where the start is settled or the policy
///             earns the bound; Infeasible where every policy may end in a state without a legal
///             step.
/// Cost.       24 bytes an attempt of a state that was looked at, about 60 a state beside its
///             words; a trial costs what its states have attempts.
/// Limit.      A bound must be known (uncertain_search_obstacle()), and memory.
/// Repeatable. One thread, no random numbers; but the clock decides when it ends.
[[nodiscard]] Result uncertain_search(const TransitionSystem& system, const Budget& budget);

/// Why uncertain_search() does not apply, as what stands after the method's name; empty where it
/// does.
[[nodiscard]] std::optional<std::string> uncertain_search_obstacle(const TransitionSystem& system);

/// What `auto` does where attempts may fail and a failure may change something: value iteration on
/// the states that attempts lead to, where they are few, else uncertain_search() until the budget
/// ends.
[[nodiscard]] Result uncertain_automatic(const TransitionSystem& system,
                                         const ValueIterationOptions& options,
                                         const Budget& budget);

}  // namespace orasp
