#pragma once

#include "orasp/graph/uncertain_graph.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Finds a policy with the greatest expected reward where attempts may fail.
///
/// Problem.    Maximise the expected sum of rewards until no connection is open or the job ends:
///             a stochastic shortest path. A policy that may end in a state that is not the goal
///             and has no legal step is worth -infinity.
/// Idea.       Bellman's equation V(s) = max over c of p (r + V(s \ c)) + (1 - p) (what a failure
///             earns + V(where it leads)). An attempt that leaves the state as it is when it fails
///             solves to r / p + V(s \ c), so one sweep, fewest open connections first, is exact.
///             The textbook order iterates the plain operator on all states from initial_value.
/// Reference.  Bertsekas and Tsitsiklis (1991), Mathematics of Operations Research 16(3), 580-595.
/// Guarantee.  `layers`: Optimal. Every policy ends with probability 1, so a residual e (the most
///             by which the operator changes V, and what rounding can hide of it) puts V within
///             e * N of the optimum at the start, N being the greatest expected number of attempts
///             of any policy: unroll V <= T V + e along the greedy policy and V >= T V - e along an
///             optimal one. Textbook: Optimal where the policy found meets V + e * N, else Feasible
///             with this as the bound.
/// Cost.       O(attempts) a sweep; memory as UncertainGraph and 28 bytes a state (44 textbook).
/// Limit.      The graph must fit in memory; Unknown where the budget ends before it is built.
/// Repeatable. One thread; ties go to the lowest connection.
///
/// Result::reward is the expected reward of the policy; Result::sequence is its order where no
/// failure changes the state; Result::expectation holds the policy.
[[nodiscard]] Result uncertain_value_iteration(const TransitionSystem& system,
                                               const ValueIterationOptions& options,
                                               const Budget& budget);
/// The same on a graph that is there, guided or not.
[[nodiscard]] Result uncertain_value_iteration(const UncertainGraph& graph,
                                               const ValueIterationOptions& options,
                                               const Budget& budget);

}  // namespace orasp
