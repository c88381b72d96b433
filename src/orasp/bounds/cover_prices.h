#pragma once

#include <array>
#include <span>
#include <vector>

#include "orasp/model/index.h"

namespace orasp {

/// What each of `edges` may be charged so that the edges of no node are charged more than `cost` of
/// it, and all edges as much as possible. Every set of nodes that holds an end of each edge then
/// costs at least what all edges together are charged.
///
/// Idea.       The sum is the linear relaxation of the least vertex cover, and half the most that
///             flows from nodes to copies of nodes: each edge leads from either end to the copy of
///             the other one, and no more flows into a node and out of a copy than it costs
///             (Nemhauser and Trotter 1975). The greatest flow by layers (Dinic 1970).
/// Guarantee.  No node is overcharged, but for rounding; the sum is the greatest.
/// Cost.       O(nodes^2 * edges) at worst, near linear in practice.
/// Reference.  Nemhauser and Trotter (1975), Vertex packings: structural properties and algorithms,
///             Mathematical Programming 8, 232-248; Dinic (1970), Soviet Math. Doklady 11,
///             1277-1280.
///
/// @param cost   not negative; may be infinite, as long as no edge has two such ends
/// @param edges  of two different nodes; others are charged nothing
/// @returns by edge
[[nodiscard]] std::vector<double> cover_prices(std::span<const double> cost,
                                               std::span<const std::array<PartIndex, 2>> edges);

}  // namespace orasp
