#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/graph/state_graph.h"
#include "orasp/task/budget.h"

namespace orasp {

/// One of the best plans.
struct Alternative {
  double reward = 0;
  /// The connections in the order of the direction of the problem.
  std::vector<ConnectionIndex> sequence;
  /// The same step by step, where there is more to steps (TransitionSystem::wide); else empty.
  std::vector<PlanStep> steps{};
};

/// What H holds beside one optimal plan. Empty: not asked for, or not reached within the budget.
struct Alternatives {
  /// The number of optimal sequences in decimal digits.
  std::optional<std::string> optimal_sequences;
  /// Of these, the number of those that no exchange of equal parts takes into one another
  /// (symmetry/symmetry.h); empty where there is nothing to exchange, or nothing is known of it.
  std::optional<std::string> optimal_up_to_symmetry;
  /// The best plans, the very best first.
  std::optional<std::vector<Alternative>> plans;
  /// What ended the work early, if anything did.
  Stop stop = Stop::None;
};

/// Losses up to this are rounding: kRewardTolerance, or where rewards are so large that sums of
/// them are less exact, four roundings a step of the greatest value. `values` are those of
/// value_iteration().
[[nodiscard]] double loss_tolerance(const StateGraph& graph, std::span<const double> values);

/// Number of optimal sequences, as decimal digits; "0" if there is no plan.
///
/// Idea.       An action is optimal if r(s, a) + V(s after a) falls short of V(s) by no more than
///             loss_tolerance(). Paths of optimal actions are counted forwards, layer by layer, as
///             graph_size() counts all paths.
/// Guarantee.  Exact integers of any size. Counts every sequence whose reward falls short of the
///             best by no more than the tolerance, and none in which a single step loses more.
/// Cost.       O(actions); an integer a state (8 bytes up to 20 connections, 16 up to 34, big
///             beyond).
[[nodiscard]] std::string count_optimal(const StateGraph& graph, std::span<const double> values);

/// The `most` best plans, or all if there are fewer: distinct sequences, best first.
///
/// Idea.       Best first over paths with V as the perfect heuristic. From a state on, the best
///             path is known: follow V. Any other plan leaves some found plan at one step by
///             another action and then follows V; the losses of its departures add up. So each plan
///             found puts the departures from its later steps into a heap, and the next best plan
///             is at its top: nothing is ever expanded in vain.
/// Reference.  Eppstein (1998), Finding the k shortest paths, SIAM J. Computing 28(2), 652-673 (the
///             heap of departures, here without his sharing of it, which needs more code than these
///             sizes repay).
/// Guarantee.  Exact, in the order of the reward up to loss_tolerance(); each plan once. Among
///             equals: those found first, from earlier plans first, then from earlier steps, then
///             by lower connection. The first is the plan of value_iteration().
/// Cost.       O(most * n * b * log(most)) time for n connections and b actions a state; at most 2
///             most + n b departures of 40 bytes, since more than `most` are never needed.
/// Repeatable. Independent of threads.
/// @returns the plans found before the budget ended.
[[nodiscard]] Alternatives best_plans(const StateGraph& graph, std::span<const double> values,
                                      std::uint64_t most, const Budget& budget);

/// Builds H and does both, as asked: the number of optimal sequences if `count`, the `most` best
/// plans unless 0. Whether H fits is for the caller to ask before (graph_obstacle); the
/// budget's memory holds in any case.
[[nodiscard]] Alternatives find_alternatives(const TransitionSystem& system, bool count,
                                             std::uint64_t most, const Budget& budget);

}  // namespace orasp
