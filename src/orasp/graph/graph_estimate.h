#pragma once

#include <optional>
#include <string>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"

namespace orasp {

/// How large the state-action graph H (state_graph.h) of a problem would be.
struct GraphEstimate {
  double states = 0;
  double actions = 0;
  /// The memory that is needed to hold H and to plan on it.
  double bytes = 0;
  /// Whether the numbers are exact: where no constraint is stated there are 2^connections states.
  bool exact = false;
};

/// Estimates the size of H without building it, in milliseconds.
///
/// Idea.       Layer by layer, N(k+1) = N(k) * b(k) / p(k+1), where b is the mean number of legal
///             actions of sampled states of layer k, and p the mean number of legal ways into
///             sampled states of layer k + 1: both count the actions between the two layers.
/// Guarantee.  Exact without constraints; the same numbers in every run. Elsewhere they may be off
///             by a factor of two or so.
/// Wide.       Where there is more to steps (TransitionSystem::wide) a part of H is built, as much
///             as takes about a second; the deadline and the stop of `limits` end that sooner.
/// Sooner.     Where there are more than `enough_actions` the numbers are those of the first layers
///             that have as many.
[[nodiscard]] GraphEstimate estimate_graph(const TransitionSystem& system,
                                           const Budget& limits = {},
                                           double enough_actions = kInfinity);

/// Whether the problem states no constraint, so that every subset of the connections is a state.
[[nodiscard]] bool unconstrained(const TransitionSystem& system);

/// The size that H would have if nothing were constrained: 2^connections states. Constraints only
/// take states away.
[[nodiscard]] GraphEstimate estimate_without_constraints(const TransitionSystem& system);

/// Whether H is estimated to fit in allowed_bytes(budget).
[[nodiscard]] bool graph_fits(const TransitionSystem& system, const Budget& budget);

/// Why a method that builds H does not take the problem, known before memory is taken: H is
/// estimated not to fit in allowed_bytes(budget) (a sampled estimate may exceed it twofold: the
/// limit still ends the build). A clause that goes on from the method's name and gives the
/// estimate; empty where H fits. `other_bytes`, if not 0, is what a table of all subsets would
/// take, to be named too.
[[nodiscard]] std::optional<std::string> graph_obstacle(const TransitionSystem& system,
                                                        const Budget& budget,
                                                        double other_bytes = 0);

}  // namespace orasp
