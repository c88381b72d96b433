#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/reward_column.h"
#include "orasp/model/index.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/memory_limit.h"
#include "orasp/task/result.h"

namespace orasp {

/// A state's number in a StateGraph: 0 is the start, then layer by layer.
using StateId = Index<struct StateKind>;
/// An action's number in a StateGraph: rows of states in order, each row ascending by connection.
using ActionId = Index<struct ActionKind, std::uint64_t>;

/// The consolidated state-action graph H: every state reachable from the start, once, with its
/// legal actions.
///
/// Idea.       Breadth first, one layer for each number of connections handled. A layer is expanded
///             in parallel; its successors are merged by their ranks among all subsets of their
///             size where they are a fair part of those, and elsewhere in shards of a hash table
///             that lives only as long as the layer. Constraints prune as it grows: a state that
///             no legal action reaches never exists.
/// Reference.  The paper, section "Our method": consolidation of the tree H~; pruning in section
///             "Constraints".
/// Guarantee.  The same graph, numbered the same way, for any number of threads.
/// Cost.       O(states * (parts + connections) + actions) time; measured in docs/performance.md.
/// Held.       8 bytes a machine word of the state and 8 for its row; 4 bytes an action for the
///             successor, 1 (up to 256 connections) or 2 for the connection, and the reward: 1 byte
///             while at most 256 different rewards occur, 2 up to 65,536, 8 beyond. `hubble-free`:
///             16 bytes a state, 6 an action.
/// Limit.      2^32 - 1 states; memory first.
///
///     const TransitionSystem system(problem);
///     const StateGraph graph = StateGraph::build(system, budget);
///     if (graph.stop() == Stop::None) use(graph.num_states());
///     for (ActionId a = graph.begin(0); a < graph.end(0); ++a)
///       use(graph.successor(a), graph.reward(a));
class StateGraph {
 public:
  static constexpr std::uint64_t kMostStates = std::numeric_limits<StateId>::max() - 1;

  /// Builds H; ends early when the budget does (then stop() says why and only whole layers are
  /// held).
  /// @throws InputError as Expander::legal_actions.
  [[nodiscard]] static StateGraph build(const TransitionSystem& system, const Budget& budget);
  // A system that goes out of scope at once.
  static StateGraph build(const TransitionSystem&&, const Budget&) = delete;

  enum class Reweighed {
    Done,
    /// The other system has other connections, another start, or other legal actions in some state.
    Differs,
    /// The budget ended the work.
    Stopped,
  };
  /// Gives each action what it earns under `system`, which must outlive the graph from then on:
  /// another objective, other durations or masses, on the same states and actions. Every state is
  /// expanded again, and its actions are compared, so a difference (masses under max_moved_mass,
  /// say) is found for certain; but nothing is hashed, sorted or merged. O(states * (parts +
  /// connections)), parallel; any number of threads gives the same bytes. Unless Done, the graph
  /// stays as it was. Only for a graph that is whole.
  /// @throws InputError as Expander::legal_actions, and leaves the graph as it was.
  [[nodiscard]] Reweighed reweigh(const TransitionSystem& system, const Budget& budget);
  Reweighed reweigh(const TransitionSystem&&, const Budget&) = delete;

  [[nodiscard]] const TransitionSystem& system() const { return *system_; }
  /// Why building ended early; Stop::None if H is whole.
  [[nodiscard]] Stop stop() const { return stop_; }
  [[nodiscard]] std::uint64_t num_states() const { return layer_begin_.back(); }
  [[nodiscard]] std::uint64_t num_actions() const { return successors_.size(); }
  /// One more than the number of connections, or fewer where every path ends before the goal. Where
  /// steps are wide a step may pass over layers, and layers may be empty.
  [[nodiscard]] std::size_t num_layers() const { return layer_begin_.size() - 1; }
  /// First state of layer k; layer k ends where layer k + 1 begins.
  [[nodiscard]] StateId layer_begin(std::size_t layer) const { return layer_begin_[layer]; }
  [[nodiscard]] StateId layer_end(std::size_t layer) const { return layer_begin_[layer + 1]; }
  /// The open connections of `state`; valid as long as the graph.
  [[nodiscard]] SetView state(StateId state) const {
    return {states_.data() + state * words_, open_words_};
  }
  /// All words of `state`, its context among them; valid as long as the graph.
  [[nodiscard]] SetView key(StateId state) const {
    return {states_.data() + state * words_, words_};
  }
  /// The words of all states, one after another; valid as long as the graph, wherever it is moved.
  [[nodiscard]] std::span<const std::uint64_t> states() const { return states_.span(); }
  /// The state in which no connection is open, or, where a plan has a goal, the one that stands for
  /// its end; empty if it is not reachable.
  [[nodiscard]] std::optional<StateId> goal() const;

  /// What the steps of a path take, from state to state: `path` holds the states, the start first.
  /// Of several actions between two states it is one that earns most.
  [[nodiscard]] PlanWalk steps_along(std::span<const StateId> path) const;

  /// Actions of `state`: begin(state) <= id < end(state), ascending by connection.
  [[nodiscard]] ActionId begin(StateId state) const { return row_begin_[state]; }
  [[nodiscard]] ActionId end(StateId state) const { return row_begin_[state + 1]; }
  [[nodiscard]] StateId successor(ActionId action) const { return successors_[action]; }
  [[nodiscard]] ConnectionIndex connection(ActionId action) const {
    return wide_connections_.empty() ? narrow_connections_[action] : wide_connections_[action];
  }
  [[nodiscard]] double reward(ActionId action) const { return rewards_[action]; }
  // The arrays themselves, for who goes through all of H; valid as long as the graph, wherever it
  // is moved.

  /// Where the actions of each state begin, and after the last state where they end.
  [[nodiscard]] std::span<const std::uint64_t> row_offsets() const { return row_begin_.span(); }
  /// By action.
  [[nodiscard]] std::span<const StateId> successors() const { return successors_.span(); }
  /// By action, in the first array where a problem has at most 256 connections, else in the second;
  /// The other one is empty.
  [[nodiscard]] std::span<const std::uint8_t> narrow_connections() const {
    return narrow_connections_.span();
  }
  [[nodiscard]] std::span<const std::uint16_t> wide_connections() const {
    return wide_connections_.span();
  }
  /// All rewards, for loops over many actions (detail::RewardColumn::with_reader).
  [[nodiscard]] const detail::RewardColumn& rewards() const { return rewards_; }
  /// Greatest reward of any action; -infinity if there are none.
  [[nodiscard]] double greatest_reward() const;

  /// Memory held now, and the most that was held while building.
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] std::uint64_t peak_bytes() const { return peak_bytes_; }

 private:
  template <std::size_t>
  friend class StateGraphBuilder;
  friend class WideGraphBuilder;
  explicit StateGraph(const TransitionSystem& system)
      : system_(&system), words_(system.words()), open_words_(system.open_words()) {}

  const TransitionSystem* system_;
  std::size_t words_;
  std::size_t open_words_;
  bool goal_reached_ = false;  ///< where steps are wide
  Stop stop_ = Stop::None;
  std::uint64_t peak_bytes_ = 0;
  std::vector<StateId> layer_begin_;
  detail::GrowingArray<std::uint64_t> states_;
  detail::GrowingArray<std::uint64_t> row_begin_;
  detail::GrowingArray<StateId> successors_;
  /// The connections of all actions: in the first array where a problem has at most 256
  /// connections, else in the second. The other one is empty.
  detail::GrowingArray<std::uint8_t> narrow_connections_;
  detail::GrowingArray<std::uint16_t> wide_connections_;
  detail::RewardColumn rewards_;
};

}  // namespace orasp
