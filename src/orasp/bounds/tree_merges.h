#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "orasp/bounds/cut_trees.h"
#include "orasp/model/index.h"

namespace orasp {

/// What the least spanning tree of a piece (CutTrees) saves where some of its parts count as one.
///
/// Idea.       Kruskal's algorithm joins two components at each connection of the tree. With the
///             parts of a set P made one from the start, just those connections are left out at
///             which two components meet that both hold parts of P. The joints are the inner nodes
///             of a binary tree over the parts of the piece.
/// Cost.       build(): a Kruskal run. saved(): the way from each part of P up to where it meets
///             that of another one.
/// Reference.  The reconstruction tree of Kruskal (1956), Proc. American Mathematical Society 7(1),
///             48-50.
class TreeMerges {
 public:
  /// For the piece with these parts; they hang together.
  void build(CutTrees& trees, std::span<const PartIndex> piece);
  /// By how much the least spanning tree costs less when `parts` of the piece count as one.
  [[nodiscard]] double saved(std::span<const PartIndex> parts);

 private:
  static constexpr std::uint32_t kNone = 0xFFFF'FFFF;
  std::uint32_t top(std::uint32_t node);

  struct Node {
    std::uint32_t above = kNone;
    std::uint32_t top = kNone;  ///< some node above, as far as build() has come
    std::uint64_t met_in = 0;   ///< the call of saved() that came by last
    double cost = 0;
  };
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> leaf_of_;  ///< by part
  std::uint64_t calls_ = 0;
};

}  // namespace orasp
