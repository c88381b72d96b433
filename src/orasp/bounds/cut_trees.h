#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// What cuts gain less than the bounds by sizes and by moved parts say, because the connection at
/// which a piece is cut has a cost of its own: where attempts are repeated until they succeed, one
/// that fails often makes dear what it separates.
///
/// Idea.       Those bounds allow every cut the best connection there is. The connections at which
///             the cuts of a piece S of n parts happen, n - 1 of them, are a spanning tree of S: a
///             cut parts what hung together. So they cost at least what the least spanning tree of
///             S costs under extra(c), the least by which a cut at c stays below those bounds
///             (Expander::least_extra_costs).
/// Consistent. Let T(S) be the cost of that tree. The trees of A and B and the connection c of a
///             cut of S into A and B are a spanning tree of S: T(S) <= extra(c) + T(A) + T(B). A
///             step that separates nothing takes a connection away, and T does not fall. So a bound
///             G with G(S) >= gain(A, B) + extra(c) + G(A) + G(B) less T is consistent again.
/// Units.      Connections that are kept cost nothing: no cut happens at them.
/// Cost.       O(connections) a state, after sorting once. Kruskal (1956), Proc. American
///             Mathematical Society 7(1), 48-50; what replaces each connection of the tree as in
///             Tarjan (1982), Information Processing Letters 14(1), 30-33.
class CutTrees {
 public:
  /// Nothing costs anything.
  CutTrees() = default;
  explicit CutTrees(const TransitionSystem& system);

  /// Whether any connection costs more than another. Where none does, all below is 0.
  [[nodiscard]] bool any() const { return !order_.empty(); }
  /// What a cut at `connection` costs.
  [[nodiscard]] double cost(ConnectionIndex connection) const {
    return any() ? costs_[connection] : 0;
  }
  /// The cost of the least spanning forest of the connections `present`.
  [[nodiscard]] double of(SetView present);
  /// By how much that grows when `connection` of `present` is taken away; negative where that
  /// separates its piece, which then needs the connection no more. Of the set that
  /// measure_changes() was called with last.
  [[nodiscard]] double change(ConnectionIndex connection) const { return changes_[connection]; }
  void measure_changes(SetView present);
  /// The cost of the least spanning tree of some parts under all connections of the problem.
  [[nodiscard]] double of_parts(std::span<const PartIndex> parts);
  /// Calls visit(part, other, cost) for each connection of that tree, least cost first.
  template <class Visit>
  void for_each_of_parts(std::span<const PartIndex> parts, Visit&& visit) {
    for (const PartIndex part : parts) inside_[part] = 1;
    kruskal(
        parts.size() - 1,
        [&](ConnectionIndex c) { return inside_[ends_[c][0]] != 0 && inside_[ends_[c][1]] != 0; },
        [&](ConnectionIndex c, bool in_tree) {
          if (in_tree) visit(ends_[c][0], ends_[c][1], costs_[c]);
        });
    for (const PartIndex part : parts) inside_[part] = 0;
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFF'FFFF;
  /// Calls use(c, in_tree) for each connection for which is_there(c) holds, least cost first, until
  /// the tree has `most` of them.
  template <class IsThere, class Use>
  void kruskal(std::size_t most, IsThere&& is_there, Use&& use) {
    std::iota(above_.begin(), above_.end(), PartIndex{0});
    for (const ConnectionIndex c : order_) {
      if (most == 0) return;
      if (!is_there(c)) continue;
      const PartIndex first = root(above_, ends_[c][0]);
      const PartIndex second = root(above_, ends_[c][1]);
      if (first != second) {
        above_[first] = second;
        --most;
      }
      use(c, first != second);
    }
  }
  static PartIndex root(std::vector<PartIndex>& above, PartIndex part) {
    while (above[part] != part) part = above[part] = above[above[part]];
    return part;
  }

  /// The connections by their costs, least first; without those of a part with itself.
  std::vector<ConnectionIndex> order_;
  std::vector<std::array<PartIndex, 2>> ends_;
  std::vector<double> costs_;
  std::vector<double> changes_;
  /// Scratch memory, by part: sets of parts that hang together, and the tree that a search roots.
  std::vector<PartIndex> above_;
  std::vector<unsigned char> inside_;
  std::vector<PartIndex> parent_;
  std::vector<ConnectionIndex> to_parent_;
  std::vector<std::uint32_t> depth_;
  std::vector<PartIndex> queue_;
  std::vector<std::vector<ConnectionIndex>> around_;
};

}  // namespace orasp
