#pragma once

#include <cstdint>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

struct DenseValueIterationOptions {
  enum class Values {
    /// Double for up to 28 connections where half of the memory allowed holds that, else
    /// FixedPoint.
    Automatic,
    /// Values take 8 bytes a state.
    Double,
    /// Values take 4 bytes a state: they are whole multiples of a power of ten.
    FixedPoint,
  };
  Values values = Values::Automatic;
};

/// Finds an optimal plan by value iteration over all subsets of the connections, reachable or not.
///
/// Problem.    Maximise the sum of rewards from the start to the goal.
/// Idea.       A state is the bit mask of its open connections, and its value stands at that place
///             of one array: V[mask] = max over legal c of r(mask, c) + V[mask without c], V[0] =
///             0. No state, no action and no reward is stored, nothing is hashed. A successor is a
///             smaller number, so ascending masks need one sweep. The low bits of a mask make a
///             block that fits in the cache; blocks whose high bits are equally many are
///             independent of each other and shared among the threads, and each reads the blocks
///             below it as streams. In an assembly without cycles and constraints, with an
///             objective that sees only sizes, 32 masks that differ in their lowest five bits are
///             worked out at once, in bytes.
/// Fixed point. Four bytes a state where eight would be too many. The unit is the least power of
/// ten in which no sum of rewards can overflow, by TransitionSystem::reward_range, or, where that
/// is unknown, by the rewards met (a coarser unit and another sweep if one is too large). Decimal
/// rewards, such as all of `cubesat`, are whole multiples: nothing is rounded. Otherwise each step
/// is off by at most half a unit, and the value of the start plus the sum of the errors is the
/// bound.
/// Reference.  Bellman (1957); over all subsets: Held, Karp (1962), J. SIAM 10(1), 196-210.
/// Guarantee.  Exact: Optimal, or Infeasible. In fixed point with rewards that are not whole
///             multiples: Feasible with a proved bound, at most connections * unit above the plan,
///             unless the two meet.
/// Cost.       2^n states for n connections, constraints or not; time 2^(n-1) n actions; memory 8
///             or 4 bytes a state. `iss` (31 connections): docs/performance.md.
/// Limit.      Memory: 28 to 32 connections. Result::values stays empty: they are by mask, not by
///             StateId.
/// Repeatable. Ties go to the lowest connection; any number of threads gives the same bytes.
/// @throws InputError if the table does not fit (dense_table_bytes); and as
/// Expander::legal_actions: with constraints also for a state that no plan reaches, so a caller
/// with an expression or a callable and constraints had better use H (dense_values_safe).
[[nodiscard]] Result dense_value_iteration(const TransitionSystem& system,
                                           const DenseValueIterationOptions& options,
                                           const Budget& budget);

/// Memory of the table under Automatic, as a number that does not overflow.
[[nodiscard]] double dense_table_bytes(const TransitionSystem& system, const Budget& budget);

/// Whether that is within allowed_bytes(budget).
[[nodiscard]] bool dense_table_fits(const TransitionSystem& system, const Budget& budget);

/// Whether no reward of a state that no plan reaches can be an error: the objective holds no
/// expression and no callable, or nothing is constrained, so that every state is reached.
[[nodiscard]] bool dense_values_safe(const TransitionSystem& system);

}  // namespace orasp
