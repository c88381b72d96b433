#pragma once

#include <optional>

#include "orasp/graph/state_graph.h"
#include "orasp/symmetry/orbit_form.h"

namespace orasp {

/// Builds H where states and steps are wide (TransitionSystem::wide), and H up to symmetry
/// (symmetry/symmetry.h), which holds one state for all that are exchanged for one another; actions
/// then lead to the states that stand for those that they lead to.
///
/// Idea.       A step may handle several connections, and a plan may end early, so there are no
///             layers to go through one by one. States are expanded in the order of how many
///             connections are open, most first: then none is met again after it was expanded. They
///             are found by a hash table that holds all of them, and numbered anew at the end: the
///             start first, the goal last, every successor after its state.
/// Guarantee.  As StateGraph::build. Actions of a state stand in the order in which
///             Expander::legal_actions gives them.
/// Cost.       O(states * cost of an expansion + actions) time, on one thread. While it works, 12
///             to 24 bytes a state and 12 an action beyond what the graph then holds.
class WideGraphBuilder {
 public:
  WideGraphBuilder(const TransitionSystem& system, const Budget& budget)
      : system_(system), budget_(budget) {}
  WideGraphBuilder(const TransitionSystem& system, const OrbitForm& form, const Budget& budget)
      : system_(system), budget_(budget), form_(form) {}
  /// `most_states`: gives up beyond so many, with Stop::ExpansionLimit.
  [[nodiscard]] StateGraph build(std::uint64_t most_states = StateGraph::kMostStates);

 private:
  const TransitionSystem& system_;
  const Budget& budget_;
  std::optional<OrbitForm> form_;
};

}  // namespace orasp
