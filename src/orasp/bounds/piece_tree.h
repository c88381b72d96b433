#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "orasp/bounds/cut_trees.h"
#include "orasp/model/index.h"

namespace orasp {

/// The least spanning tree of a piece (CutTrees), and what it tells of pieces that are made of it.
///
/// One part.   What the tree saves where some parts of the piece count as one. Kruskal's algorithm
///             joins two components at each connection of the tree. With the parts of a set P made
///             one from the start, just those connections are left out at which two components meet
///             that both hold parts of P. The joints are the inner nodes of a binary tree over the
///             parts of the piece.
/// Cuts.       Where just one connection of the tree crosses a cut, the rest of it is the least
///             spanning trees of both sides.
/// Cost.       build(): a Kruskal run. saved(): the way from each part of P up to where it meets
///             that of another one. only_crossing(): the connections of the tree at some parts.
/// Reference.  The reconstruction tree of Kruskal (1956), Proc. American Mathematical Society 7(1),
///             48-50.
class PieceTree {
 public:
  /// For the piece with these parts; they hang together.
  void build(CutTrees& trees, std::span<const PartIndex> piece);
  /// By how much the least spanning tree costs less when `parts` of the piece count as one.
  [[nodiscard]] double saved(std::span<const PartIndex> parts);
  /// The cost of the connection of the tree between `parts` of the piece and all others, where it
  /// is the only one; is_inside(part) tells whether one is of `parts`.
  template <class IsInside>
  [[nodiscard]] std::optional<double> only_crossing(std::span<const PartIndex> parts,
                                                    IsInside&& is_inside) const {
    std::optional<double> crossing;
    for (const PartIndex part : parts) {
      for (const Branch& branch : around_[part]) {
        if (is_inside(branch.other)) continue;
        if (crossing) return std::nullopt;
        crossing = branch.cost;
      }
    }
    return crossing;
  }
  /// What the whole tree costs.
  [[nodiscard]] double cost() const { return cost_; }

 private:
  static constexpr std::uint32_t kNone = 0xFFFF'FFFF;
  std::uint32_t top(std::uint32_t node);

  struct Node {
    std::uint32_t above = kNone;
    std::uint32_t top = kNone;  ///< some node above, as far as build() has come
    std::uint64_t met_in = 0;   ///< the call of saved() that came by last
    double cost = 0;
  };
  struct Branch {
    PartIndex other;
    double cost;
  };
  double cost_ = 0;
  std::vector<Node> nodes_;
  std::vector<std::vector<Branch>> around_;  ///< by part
  std::vector<std::uint32_t> leaf_of_;       ///< by part
  std::uint64_t calls_ = 0;
};

}  // namespace orasp
