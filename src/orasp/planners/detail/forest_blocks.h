#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "orasp/model/transition_system.h"
#include "orasp/planners/detail/dense_numbers.h"

namespace orasp::detail {

/// More connections would need more than 4 TiB of four-byte values.
inline constexpr std::size_t kMostDenseConnections = 40;
/// 32 states are worked out at once.
inline constexpr std::size_t kLaneBits = 5;
inline constexpr std::size_t kLanes = std::size_t{1} << kLaneBits;

/// What ForestBlocks needs to know of an assembly whose connections form a forest. Each edge, and
/// each root that has an edge, has a slot (as in AssemblyGraph::forest(), but numbered anew): first
/// the edges in their order, then the roots.
struct DenseForest {
  struct Edge {
    ConnectionIndex connection;
    /// The slot above the edge.
    std::uint32_t parent;
    /// Whether the lower part of the edge is the first part of its connection.
    bool lower_is_a;
  };
  std::vector<Edge> edges;
  std::size_t slots = 0;
  std::vector<ConnectionIndex> loops;
  bool assembly = false;
};

/// The forest of a problem that ForestBlocks can work out; empty where it cannot.
[[nodiscard]] std::optional<DenseForest> dense_forest_of(const TransitionSystem& system);

/// Works out the values of states where nothing is constrained, rewards depend on sizes alone and
/// the connections form a forest.
///
/// 32 states are worked out at once: those whose masks differ in their lowest five bits, one in
/// each lane of a vector. There are at most connections + 1 parts below an edge and in its piece,
/// so sizes are bytes, and two of them are the index of a table of rewards. Each thread has one of
/// its own.
template <class Numbers>
class ForestBlocks {
 public:
  using Value = typename Numbers::Value;

  /// The width of the table of rewards, more than the parts of any piece.
  static constexpr std::size_t kStride = 64;
  static_assert(kMostDenseConnections + 1 < kStride);

  ForestBlocks(const DenseForest& forest, const TransitionSystem& system, const Numbers& numbers)
      : forest_(forest), below_(forest.slots), piece_(forest.slots) {
    const std::size_t most = std::min(system.num_connections() + 1, system.problem().num_parts());
    for (std::vector<Value>& table : rewards_) table.assign(kStride * kStride, Value{});
    const auto reward = [&](std::size_t a, std::size_t b) {
      const double exact = system.greatest_size_reward(a, b, false);
      error_ = std::max(error_, numbers.error(exact));
      return numbers.rounded(exact);
    };
    for (std::size_t all = 2; all <= most; ++all) {
      for (std::size_t below = 1; below < all; ++below) {
        rewards_[0][below * kStride + all] = reward(all - below, below);
        rewards_[1][below * kStride + all] = reward(below, all - below);
      }
    }
    if (!forest.loops.empty()) loop_reward_ = reward(0, 0);
    Expander expander(system);
    for (ConnectionIndex c = 0; c < system.num_connections(); ++c) {
      const Mask alone = bit(c);
      const double exact = expander.legal_actions(SetView(&alone, 1)).front().reward;
      error_ = std::max(error_, numbers.error(exact));
      last_.push_back(numbers.rounded(exact));
    }
    for (std::size_t l = 0; l < kLanes; ++l) {
      all_[l] = 0xff;
      none_[l] = 0;
      for (std::size_t c = 0; c < kLaneBits; ++c) {
        const bool open = (l >> c & 1U) != 0;
        low_[c][l] = open != forest.assembly ? 0xff : 0;
      }
    }
  }

  /// Greatest difference between a reward and its value.
  [[nodiscard]] double error() const { return error_; }

  /// Works out the masks from `first` to first + size - 1, ascending; both are multiples of 32.
  void work_out(Mask first, Mask size, Value* values) {
    work_out_at(first, size, [values](Mask mask) { return values + mask; });
  }
  /// The same where at(mask) points to the value of a mask, with those of the lanes beside it.
  template <class At>
  void work_out_at(Mask first, Mask size, At at) {
    for (Mask mask = first; mask < first + size; mask += kLanes) work_out_lanes(mask, at);
  }

 private:
  using Bytes = std::array<std::uint8_t, kLanes>;

  static void look_up(const Value* table, const std::array<std::uint16_t, kLanes>& places,
                      std::array<Value, kLanes>& rewards) {
// Measured: 16 is quicker than 8 and than all 32.
#pragma GCC unroll 16
    for (std::size_t l = 0; l < kLanes; ++l) rewards[l] = table[places[l]];
  }

  template <class At>
  void work_out_lanes(Mask high, At at) {
    measure(high);
    std::array<Value, kLanes> best;
    best.fill(Numbers::kNever);
    std::array<std::array<Value, kLanes>, kLaneBits> low_rewards;
    for (std::size_t e = 0; e < forest_.edges.size(); ++e) {
      const DenseForest::Edge& edge = forest_.edges[e];
      const bool is_low = edge.connection < kLaneBits;
      if (!is_low && (high & bit(edge.connection)) == 0) continue;
      std::array<std::uint16_t, kLanes> places;
      const Bytes& below = below_[e];
      const Bytes& above = piece_[edge.parent];
      // In disassembly an open connection is there, so the slot above counts both sides of it. In
      // assembly it is missing, so the slot above counts the upper side alone.
      if (forest_.assembly) {
        for (std::size_t l = 0; l < kLanes; ++l) {
          places[l] = static_cast<std::uint16_t>(below[l] * kStride + below[l] + above[l]);
        }
      } else {
        for (std::size_t l = 0; l < kLanes; ++l)
          places[l] = static_cast<std::uint16_t>(below[l] * kStride + above[l]);
      }
      const Value* const table = rewards_[edge.lower_is_a ? 1 : 0].data();
      if (is_low) {
        look_up(table, places, low_rewards[edge.connection]);
        continue;
      }
      const Value* const left = at(high ^ bit(edge.connection));
      std::array<Value, kLanes> rewards;
      look_up(table, places, rewards);
      for (std::size_t l = 0; l < kLanes; ++l) {
        const Value sum = rewards[l] + left[l];
        best[l] = best[l] < sum ? sum : best[l];
      }
    }
    for (const ConnectionIndex c : forest_.loops) {
      if (c < kLaneBits) {
        low_rewards[c].fill(loop_reward_);
      } else if ((high & bit(c)) != 0) {
        const Value* const left = at(high ^ bit(c));
        for (std::size_t l = 0; l < kLanes; ++l) {
          best[l] = std::max<Value>(best[l], loop_reward_ + left[l]);
        }
      }
    }
    // The steps that handle a low connection lead from one lane to another, which is worked out
    // before: lanes go upwards.
    const bool at_most_one_high = (high & (high - 1)) == 0;
    if (at_most_one_high)
      best[0] = high == 0 ? Value{} : last_[static_cast<std::size_t>(std::countr_zero(high))];
    for (std::size_t l = 1; l < kLanes; ++l) {
      if (high == 0 && std::has_single_bit(l)) {
        best[l] = last_[static_cast<std::size_t>(std::countr_zero(l))];
        continue;
      }
      for (std::size_t c = 0; c < kLaneBits; ++c) {
        if ((l >> c & 1U) != 0) {
          best[l] = std::max<Value>(best[l], low_rewards[c][l] + best[l ^ (std::size_t{1} << c)]);
        }
      }
    }
    std::ranges::copy(best, at(high));
  }

  // Counts the parts below each edge, and then the parts of the piece that each slot belongs to.
  void measure(Mask high) {
    const Mask present = forest_.assembly ? ~high : high;
    const auto mask_of = [&](ConnectionIndex c) -> const Bytes& {
      return c < kLaneBits ? low_[c] : (present & bit(c)) != 0 ? all_ : none_;
    };
    std::memset(below_.data(), 1, below_.size() * sizeof(Bytes));
    for (std::size_t e = forest_.edges.size(); e-- > 0;) {
      const DenseForest::Edge& edge = forest_.edges[e];
      const Bytes& mask = mask_of(edge.connection);
      const Bytes& mine = below_[e];
      Bytes& parent = below_[edge.parent];
      for (std::size_t l = 0; l < kLanes; ++l) {
        parent[l] = static_cast<std::uint8_t>(parent[l] + (mine[l] & mask[l]));
      }
    }
    for (std::size_t s = forest_.edges.size(); s < forest_.slots; ++s) piece_[s] = below_[s];
    for (std::size_t e = 0; e < forest_.edges.size(); ++e) {
      const DenseForest::Edge& edge = forest_.edges[e];
      const Bytes& mask = mask_of(edge.connection);
      const Bytes& mine = below_[e];
      const Bytes& parent = piece_[edge.parent];
      Bytes& piece = piece_[e];
      for (std::size_t l = 0; l < kLanes; ++l) {
        piece[l] = static_cast<std::uint8_t>((parent[l] & mask[l]) | (mine[l] & ~mask[l]));
      }
    }
  }

  const DenseForest& forest_;
  /// By slot: the parts below it, and the parts of its piece.
  std::vector<Bytes> below_;
  std::vector<Bytes> piece_;
  /// The rewards of cuts: the second table where the lower side is the connection's first, each at
  /// parts below * kStride + parts of both sides.
  std::array<std::vector<Value>, 2> rewards_;
  /// The reward of handling a connection of a part to itself.
  Value loop_reward_{};
  /// The reward of each connection where it is the last step.
  std::vector<Value> last_;
  /// Masks over the lanes: where a connection is there in all of them, in none, and where each low
  /// connection is there.
  Bytes all_;
  Bytes none_;
  std::array<Bytes, kLaneBits> low_;
  double error_ = 0;
};

}  // namespace orasp::detail
