#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "orasp/model/detail/connectivity.h"

namespace orasp::detail {

/// A spanning forest of an assembly: of each piece, just enough connections to hold it together.
struct SpanningForest {
  static constexpr std::uint32_t kNoPart = std::numeric_limits<std::uint32_t>::max();

  /// The part above each part; kNoPart for roots.
  std::vector<std::uint32_t> parent;
  /// All parts, each after the one above it.
  std::vector<PartIndex> order;
};

/// Draws a spanning forest: depth first, in an order that the seed shuffles. So the trees are long
/// paths with short branches, which can be cut into halves nearly anywhere. O(parts + connections).
[[nodiscard]] SpanningForest random_spanning_forest(const AssemblyGraph& graph, std::uint64_t seed);

}  // namespace orasp::detail
