#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "orasp/model/connection_set.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// Parts in no particular order, as at most two runs: one side of a separation.
struct Side {
  std::array<std::span<const PartIndex>, 2> runs;

  template <class Visit>
  void for_each(Visit&& visit) const {
    for (const auto& run : runs) {
      for (const PartIndex part : run) visit(part);
    }
  }
  [[nodiscard]] std::size_t parts() const { return runs[0].size() + runs[1].size(); }
};

/// The assembly graph, arranged for walking. Immutable. Connections of a part to itself are left
/// out: they hold nothing together.
class AssemblyGraph {
 public:
  struct HalfEdge {
    PartIndex other;
    ConnectionIndex connection;
  };
  /// An edge of the rooted spanning forest. Every part has a slot: that of the connection above it,
  /// or, for a root, one of those from num_connections() on.
  struct ForestEdge {
    ConnectionIndex connection;  ///< also the slot of `child`
    std::uint32_t parent_slot;
    PartIndex child;
  };

  explicit AssemblyGraph(const Problem& problem);

  [[nodiscard]] std::size_t num_parts() const { return begin_.size() - 1; }
  [[nodiscard]] std::size_t num_connections() const { return ends_.size(); }
  [[nodiscard]] const std::array<PartIndex, 2>& ends(ConnectionIndex c) const { return ends_[c]; }
  [[nodiscard]] std::span<const HalfEdge> around(PartIndex part) const {
    return {half_edges_.data() + begin_[part], half_edges_.data() + begin_[part + 1]};
  }
  /// Connections at a part as one word; only where the problem has at most 64 connections.
  [[nodiscard]] std::uint64_t incident(PartIndex part) const { return incident_[part]; }
  /// Parts of the starting piece that holds `part`.
  [[nodiscard]] std::size_t starting_piece(PartIndex part) const { return starting_piece_[part]; }
  /// Whether there is no cycle (parallel connections are one).
  [[nodiscard]] bool is_forest() const { return is_forest_; }
  /// Edges of the spanning forest (all edges, if it is one), each after those above it.
  [[nodiscard]] std::span<const ForestEdge> forest() const { return forest_; }
  /// Calls visit(std::span<const PartIndex>) with the parts of each piece that the connections of
  /// `present` hold together, single parts included, by flood fill. O(parts + connections).
  template <class Visit>
  void for_each_piece(SetView present, Visit&& visit) const {
    std::vector<unsigned char> seen(num_parts(), 0);
    std::vector<PartIndex> piece;
    for (PartIndex root = 0; root < num_parts(); ++root) {
      if (seen[root] != 0) continue;
      piece.assign(1, root);
      seen[root] = 1;
      for (std::size_t i = 0; i < piece.size(); ++i) {
        for (const HalfEdge& half : around(piece[i])) {
          if (seen[half.other] != 0 || !contains(present, half.connection)) continue;
          seen[half.other] = 1;
          piece.push_back(half.other);
        }
      }
      visit(std::span<const PartIndex>(piece));
    }
  }
  /// Connections of a part to itself.
  [[nodiscard]] std::span<const ConnectionIndex> loops() const { return loops_; }
  /// num_connections() and one for each root.
  [[nodiscard]] std::size_t num_slots() const { return num_slots_; }

 private:
  std::vector<std::array<PartIndex, 2>> ends_;
  std::vector<std::uint32_t> begin_;
  std::vector<HalfEdge> half_edges_;
  std::vector<std::uint64_t> incident_;
  std::vector<std::uint32_t> starting_piece_;
  bool is_forest_ = true;
  std::vector<ForestEdge> forest_;
  std::vector<ConnectionIndex> loops_;
  std::size_t num_slots_ = 0;
};

/// Finds for a set of present connections, all at once, which of them separate and how many parts
/// are on either side.
///
/// Idea.       In an assembly without cycles every connection separates: subtree sizes of one fixed
///             rooted forest, without a branch, and for eight states at once in the lanes of
///             vector registers. Otherwise Tarjan's bridges by depth-first search; preorder makes
///             each side of each bridge at most two runs of parts.
/// Reference.  Tarjan (1974), Inf. Proc. Letters 2(6), 160-161.
/// Cost.       O(parts + connections) an analysis. Holds scratch memory: one for each thread.
class Connectivity {
 public:
  /// `lists`: whether sides will be asked for, not only their sizes.
  Connectivity(const AssemblyGraph& graph, bool lists);

  /// States that analyse_batch takes at once.
  static constexpr std::size_t kLanes = 8;

  /// `isolated`: also walk parts without a present connection (needed for piece_of on them).
  void analyse(SetView present, bool isolated);

  /// Whether analyse_batch may be used: no cycles, and only sizes are asked for.
  [[nodiscard]] bool takes_batches() const { return !lists_; }
  /// Analyses 1 to kLanes states that stand one after another; select() then says which one is
  /// asked about.
  void analyse_batch(std::span<const std::uint64_t> states);
  void select(std::size_t lane) {
    lane_ = lane;
    single_ = false;
  }

  /// Parts on one side of a present connection, the side of `lower_end`; 0 if it does not separate.
  [[nodiscard]] std::uint32_t below(ConnectionIndex c) const {
    if (lists_) return below_[c];
    return single_ ? singles_[c].below : batch_[c].below[lane_];
  }
  /// Parts of the piece that holds a present, separating connection.
  [[nodiscard]] std::uint32_t piece(ConnectionIndex c) const {
    if (lists_) return piece_[c];
    return single_ ? singles_[c].piece : batch_[c].piece[lane_];
  }
  [[nodiscard]] PartIndex lower_end(ConnectionIndex c) const { return lower_end_[c]; }
  /// Pieces with two or more parts.
  [[nodiscard]] std::size_t subassemblies() const {
    return lists_ || single_ ? subassemblies_ : tops_with_two_.parts[lane_];
  }

  // With lists only.
  /// The parts that were walked; each side and each piece is one or two runs of them.
  [[nodiscard]] std::span<const PartIndex> walked() const {
    return std::span(order_).first(visited_);
  }
  [[nodiscard]] Side lower_side(ConnectionIndex c) const;
  [[nodiscard]] Side upper_side(ConnectionIndex c) const;
  /// The piece of a part, and whether two parts are in one.
  [[nodiscard]] Side piece_of(PartIndex part) const;
  [[nodiscard]] bool same_piece(PartIndex a, PartIndex b) const { return root_[a] == root_[b]; }

 private:
  /// One number of parts for each of kLanes states (kMaxParts fits in 16 bits).
  using Lanes [[gnu::vector_size(16)]] = std::uint16_t;
  /// Number is Lanes, or std::uint16_t for a single state.
  template <class Number>
  struct Slot {
    Number below;    ///< parts at and below the slot
    Number piece;    ///< parts of the slot's piece
    Number present;  ///< all ones where its connection is present
  };
  template <class Number, class MaskOf>
  Number measure(std::vector<Slot<Number>>& slots, MaskOf&& mask_of);
  struct Count {
    Lanes parts;
  };
  template <bool kOneWord>
  void search_from(PartIndex start, SetView present);

  const AssemblyGraph& graph_;
  bool one_word_;
  bool lists_;
  std::size_t subassemblies_ = 0;
  std::vector<PartIndex> lower_end_;  ///< by connection

  // Forests: batches, and a single state.
  bool single_ = false;
  std::vector<Slot<std::uint16_t>> singles_;
  std::size_t lane_ = 0;
  Count tops_with_two_{};
  std::vector<Slot<Lanes>> batch_;
  std::vector<std::uint8_t> lanes_with_;  ///< by connection: bit l says whether state l has it

  // Depth-first search.
  std::vector<std::uint32_t> below_;  ///< by connection
  std::vector<std::uint32_t> piece_;  ///< by connection

  std::vector<PartIndex> order_;  ///< parts in preorder; each piece and each subtree is one run
  std::vector<std::uint32_t> position_;     ///< of each part in `order_`, kUnmet before
  std::vector<std::uint32_t> subtree_end_;  ///< end of each part's run in `order_`
  std::vector<std::uint32_t> low_;          ///< lowest position that the subtree reaches
  std::vector<PartIndex> root_;
  std::vector<PartIndex> parent_;
  std::vector<ConnectionIndex> parent_connection_;
  std::vector<ConnectionIndex> separating_;  ///< of the piece being walked
  std::vector<std::uint64_t> pending_;       ///< one word: connections of a part not yet followed
  std::vector<std::uint32_t> cursor_;        ///< wide: next half-edge of a part
  std::uint32_t visited_ = 0;
};

}  // namespace orasp::detail
