#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "orasp/graph/state_graph.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

struct ValueIterationOptions {
  enum class Order {
    /// The last layer first, in place: one sweep finds the values, one confirms them.
    Layers,
    /// The order of the paper: V_{k+1} from V_k, states in order of generation. Each sweep gets one
    /// layer more right.
    Textbook,
  };
  Order order = Order::Layers;
  /// V_0 of every state but the goal, whose value is 0.
  double initial_value = 0;
  /// The sweeps end when no value has changed by this much or more.
  double epsilon = 1e-9;
  std::uint64_t max_sweeps = std::numeric_limits<std::uint64_t>::max();

  friend bool operator==(const ValueIterationOptions&, const ValueIterationOptions&) = default;
};

/// @throws InputError where an option makes no sense.
void require_valid(const ValueIterationOptions& options);

/// Why value_iteration() does not take the problem: neither H nor the table of all subsets is
/// estimated to fit. A clause that goes on from the method's name; empty where one of them fits.
[[nodiscard]] std::optional<std::string> value_iteration_obstacle(
    const TransitionSystem& system, const ValueIterationOptions& options, const Budget& budget);

/// Finds an optimal plan by graph-based value iteration.
///
/// Problem.    Maximise the sum of rewards from the start to the goal of H.
/// Idea.       V(s) <- max over legal a of r(s, a) + V(s after a), until no value changes by
///             epsilon; then roll out the greedy policy. States that cannot reach the goal have the
///             value -infinity.
/// Reference.  The paper, Algorithm 1 (graph-based value iteration); Bellman (1957).
/// Guarantee.  Exact: H is acyclic, so in layer order one sweep is right whatever the initial
///             values, and the textbook order needs at most connections + 1. Stopped by max_sweeps
///             before that: Feasible, not Optimal.
/// Cost.       O(actions) a sweep, parallel over the states of a layer (layer order) or of H
///             (textbook order); 8 bytes a state (16 in textbook order) beside H.
/// Limit.      H must fit in memory, or the table of dense_value_iteration.
/// Repeatable. Ties go to the lowest connection; any number of threads gives the same bytes.
///
/// With default options, H is not built but dense_value_iteration() answers where nothing is
/// constrained, since then H holds every subset and the table finds the same plan several times as
/// fast; and where H does not fit, by the estimate or while it grows, but the table does.
/// Result::values is then empty; build H and use the second form for values.
/// @throws InputError if neither is estimated to fit (value_iteration_obstacle).
[[nodiscard]] Result value_iteration(const TransitionSystem& system,
                                     const ValueIterationOptions& options, const Budget& budget);
/// The same on an H that is already there; Result::values holds V by StateId.
[[nodiscard]] Result value_iteration(const StateGraph& graph, const ValueIterationOptions& options,
                                     const Budget& budget);

}  // namespace orasp
