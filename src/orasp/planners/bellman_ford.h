#pragma once

#include "orasp/graph/state_graph.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

struct BellmanFordOptions {
  /// Whether to fill Result::values.
  bool keep_values = true;
};

/// Finds an optimal plan, and the best reward from the start to every state of H, by Bellman-Ford.
///
/// Idea.       Relax every action of H until a sweep changes nothing. In order of generation each
///             layer is final before its actions are relaxed, so one sweep settles everything and
///             one confirms it. Rewards of either sign need no shift.
/// Reference.  The paper, section "Graph exploration assembly planners"; Bellman (1958), Ford
///             (1956), Moore (1959).
/// Guarantee.  Exact. Result::values holds the best reward from the start by StateId, which is what
///             replanning wants.
/// Cost.       O(actions) a sweep, two sweeps; 12 bytes a state beside H.
/// Limit.      H must fit in memory.
/// Repeatable. Ties go to the action generated first; no randomness.
/// @throws InputError if H is estimated not to fit (graph_obstacle).
[[nodiscard]] Result bellman_ford(const TransitionSystem& system, const BellmanFordOptions& options,
                                  const Budget& budget);
/// The same on an H that is already there.
[[nodiscard]] Result bellman_ford(const StateGraph& graph, const BellmanFordOptions& options,
                                  const Budget& budget);

}  // namespace orasp
