#pragma once

#include "orasp/graph/state_graph.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Finds an optimal plan by Dijkstra's algorithm on H.
///
/// Idea.       Every path from the start to the goal has as many steps as there are connections, so
///             the same constant may be taken from each reward without changing which plan is best:
///             the length of an action is (greatest reward of H) - r >= 0. States are settled in
///             order of length until the goal is.
/// Reference.  The paper, section "Graph exploration assembly planners"; Dijkstra (1959), Numer.
///             Math. 1, 269-271.
/// Guarantee.  Exact.
/// Cost.       O(actions * log states) time; 20 bytes a state beside H. A 4-ary heap with positions
///             (decrease-key), so that the heap never holds a state twice.
/// Limit.      H must fit in memory.
/// Repeatable. Ties go to the state generated first; no randomness.
/// @throws InputError if H is estimated not to fit (graph_obstacle).
[[nodiscard]] Result dijkstra(const TransitionSystem& system, const Budget& budget);
/// The same on an H that is already there.
[[nodiscard]] Result dijkstra(const StateGraph& graph, const Budget& budget);

}  // namespace orasp
