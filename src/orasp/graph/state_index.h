#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "orasp/containers/growing_array.h"
#include "orasp/graph/state_graph.h"

namespace orasp {

/// Finds a state of a StateGraph by what is open in it.
///
/// Idea.       Open addressing over 4-byte numbers that point at the graph's own states; linear
///             probing, at most half full. The states are different from each other, so filling it
///             compares nothing.
/// Guarantee.  find() is exact, and may be called by many threads at once.
/// Cost.       O(states) to make, O(words of a state) expected to find.
/// Held.       8 to 16 bytes a state.
///
/// Reads the graph's states where they lie: they must outlive it (a graph may be moved, and
/// reweighed, meanwhile).
///
///     const StateIndex index(graph);
///     if (const auto state = index.find(open)) use(graph.begin(*state), graph.end(*state));
class StateIndex {
 public:
  explicit StateIndex(const StateGraph& graph);
  // A graph that goes out of scope at once.
  explicit StateIndex(const StateGraph&&) = delete;

  /// The state in which just `open` is open (as many words as a state of the graph has); nothing if
  /// there is none.
  [[nodiscard]] std::optional<StateId> find(SetView open) const;

  [[nodiscard]] std::uint64_t bytes() const { return slots_.bytes(); }

 private:
  static constexpr StateId kEmpty = std::numeric_limits<StateId>::max();

  /// The states of the graph, words_ words each.
  std::span<const std::uint64_t> states_;
  std::size_t words_;
  std::size_t mask_;
  detail::GrowingArray<StateId> slots_;
};

}  // namespace orasp
