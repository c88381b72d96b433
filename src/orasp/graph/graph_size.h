#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "orasp/graph/state_graph.h"

namespace orasp {

struct LayerSize {
  std::uint64_t states = 0;
  std::uint64_t actions = 0;
};

/// The sizes of H and of the tree H~ that it consolidates.
struct GraphSize {
  std::uint64_t states = 0;
  std::uint64_t actions = 0;
  std::vector<LayerSize> layers;
  /// The number of states other than the goal that have no legal action.
  std::uint64_t dead_ends = 0;
  /// The nodes of H~: the legal sequences from the start, partial ones and the empty one counted.
  std::string tree_nodes;
  /// The legal sequences from the start to the goal.
  std::string sequences;
};

/// Counts H~ on H without building it: the number of paths to a state is the sum over its
/// predecessors. Exact: 64-bit integers up to 20 connections (20! < 2^64), 128-bit up to 34 (34! <
/// 2^128), Boost's big integers beyond; decimal text, since the numbers exceed every machine word
/// (20 connections: 2.4e18 sequences). O(actions).
[[nodiscard]] GraphSize graph_size(const StateGraph& graph);

}  // namespace orasp
