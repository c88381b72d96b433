#include "orasp/model/detail/connectivity.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

namespace orasp::detail {

namespace {

constexpr std::uint32_t kUnmet = std::numeric_limits<std::uint32_t>::max();

/// The transpose of an 8 x 8 bit matrix, row i in byte i. Reference: Warren, Hacker's Delight, 7-3.
std::uint64_t transposed(std::uint64_t x) {
  std::uint64_t t = (x ^ (x >> 7)) & 0x00aa00aa00aa00aaULL;
  x ^= t ^ (t << 7);
  t = (x ^ (x >> 14)) & 0x0000cccc0000ccccULL;
  x ^= t ^ (t << 14);
  t = (x ^ (x >> 28)) & 0x00000000f0f0f0f0ULL;
  return x ^ t ^ (t << 28);
}

}  // namespace

AssemblyGraph::AssemblyGraph(const Problem& problem)
    : begin_(problem.num_parts() + 1, 0), starting_piece_(problem.num_parts(), 0) {
  const std::size_t parts = problem.num_parts();
  const auto connections = static_cast<ConnectionIndex>(problem.num_connections());
  if (connections <= 64) incident_.assign(parts, 0);
  std::size_t edges = 0;
  for (ConnectionIndex c = 0; c < connections; ++c) {
    ends_.push_back(problem.ends(c));
    const auto [u, v] = ends_.back();
    if (u == v) {
      loops_.push_back(c);
      continue;
    }
    ++edges;
    ++begin_[u + 1];
    ++begin_[v + 1];
    if (connections > 64) continue;
    incident_[u] |= std::uint64_t{1} << c;
    incident_[v] |= std::uint64_t{1} << c;
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  half_edges_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (ConnectionIndex c = 0; c < connections; ++c) {
    const auto [u, v] = ends_[c];
    if (u == v) continue;
    half_edges_[next[u]++] = {v, c};
    half_edges_[next[v]++] = {u, c};
  }

  // Breadth first: starting pieces, and the edges of a spanning forest, each after those above it.
  std::vector<PartIndex> piece;
  std::vector<std::uint32_t> slots(parts);
  num_slots_ = connections;
  for (PartIndex root = 0; root < parts; ++root) {
    if (starting_piece_[root] != 0) continue;
    piece.assign(1, root);
    starting_piece_[root] = 1;
    slots[root] = static_cast<std::uint32_t>(num_slots_++);
    for (std::size_t i = 0; i < piece.size(); ++i) {
      for (const HalfEdge& half : around(piece[i])) {
        if (starting_piece_[half.other] != 0) continue;
        starting_piece_[half.other] = 1;
        slots[half.other] = half.connection;
        forest_.push_back({half.connection, slots[piece[i]], half.other});
        piece.push_back(half.other);
      }
    }
    for (const PartIndex part : piece)
      starting_piece_[part] = static_cast<std::uint32_t>(piece.size());
  }
  is_forest_ = forest_.size() == edges;
}

Connectivity::Connectivity(const AssemblyGraph& graph, bool lists)
    : graph_(graph),
      one_word_(graph.num_connections() <= 64),
      lists_(lists || !graph.is_forest()),
      lower_end_(graph.num_connections(), 0) {
  const std::size_t parts = graph.num_parts();
  if (!lists_) {
    for (const AssemblyGraph::ForestEdge& edge : graph.forest()) {
      lower_end_[edge.connection] = edge.child;
    }
    batch_.resize(graph.num_slots());
    singles_.resize(graph.num_slots());
    lanes_with_.resize(words_for(graph.num_connections()) * 64);
    return;
  }
  below_.assign(graph.num_connections(), 0);
  piece_.assign(graph.num_connections(), 0);
  order_.resize(parts);
  position_.resize(parts);
  subtree_end_.resize(parts);
  low_.resize(parts);
  root_.resize(parts);
  parent_.resize(parts);
  parent_connection_.resize(parts);
  if (one_word_) {
    pending_.resize(parts);
  } else {
    cursor_.resize(parts);
  }
}

void Connectivity::analyse(SetView present, bool isolated) {
  if (!lists_) {
    single_ = true;
    subassemblies_ = measure(singles_, [&](ConnectionIndex c) {
      return static_cast<std::uint16_t>(0 - static_cast<int>(contains(present, c)));
    });
    return;
  }
  std::ranges::fill(position_, kUnmet);
  visited_ = 0;
  subassemblies_ = 0;
  const auto walk = [&](PartIndex part) {
    if (position_[part] != kUnmet) return;
    if (one_word_) {
      search_from<true>(part, present);
    } else {
      search_from<false>(part, present);
    }
  };
  // Roots are ends of the lowest connections, so that a piece is walked the same way in every state
  // that holds it: sums over its parts are then the same number, bit for bit.
  for_each_connection(present, [&](ConnectionIndex c) { walk(graph_.ends(c)[0]); });
  if (isolated) {
    for (PartIndex part = 0; part < graph_.num_parts(); ++part) walk(part);
  }
}

// Sizes of subtrees from the leaves up, then sizes of pieces from the roots down; presence is a
// mask, not a branch: whether a connection is present is a coin toss to the processor. Returns the
// number of pieces with two or more parts.
template <class Number, class MaskOf>
Number Connectivity::measure(std::vector<Slot<Number>>& slots, MaskOf&& mask_of) {
  const auto number = [](auto value) { return (Number)value; };  // vectors know no static_cast
  const Number one = number(Number{} + 1);
  const auto has_two = [&](Number parts) { return number(number(parts > one) & one); };
  const std::span<const AssemblyGraph::ForestEdge> forest = graph_.forest();
  for (Slot<Number>& slot : slots) slot.below = one;
  for (const ConnectionIndex c : graph_.loops()) slots[c].below = Number{};
  for (std::size_t i = forest.size(); i-- > 0;) {
    const AssemblyGraph::ForestEdge& edge = forest[i];
    Slot<Number>& slot = slots[edge.connection];
    slot.present = mask_of(edge.connection);
    Slot<Number>& parent = slots[edge.parent_slot];
    parent.below = number(parent.below + (slot.below & slot.present));
  }
  // A piece is counted at its top part, which no present connection holds from above.
  Number tops = {};
  for (std::size_t s = graph_.num_connections(); s < slots.size(); ++s) {
    slots[s].piece = slots[s].below;
    tops = number(tops + has_two(slots[s].below));
  }
  for (const AssemblyGraph::ForestEdge& edge : forest) {
    Slot<Number>& slot = slots[edge.connection];
    slot.piece =
        number((slots[edge.parent_slot].piece & slot.present) | (slot.below & ~slot.present));
    tops = number(tops + (has_two(slot.below) & ~slot.present));
  }
  return tops;
}

void Connectivity::analyse_batch(std::span<const std::uint64_t> states) {
  const std::size_t words = words_for(graph_.num_connections());
  const std::size_t lanes = states.size() / words;
  // Bit matrices of 8 states by 8 connections, transposed.
  for (std::size_t block = 0; block * 8 < graph_.num_connections(); ++block) {
    std::uint64_t rows = 0;
    for (std::size_t l = 0; l < lanes; ++l) {
      rows |= (states[l * words + block / 8] >> (block % 8 * 8) & 0xffU) << (l * 8);
    }
    const std::uint64_t columns = transposed(rows);
    for (std::size_t i = 0; i < 8; ++i) {
      lanes_with_[block * 8 + i] = static_cast<std::uint8_t>(columns >> (i * 8));
    }
  }
  constexpr Lanes kBit = {1, 2, 4, 8, 16, 32, 64, 128};
  tops_with_two_.parts = measure(batch_, [&](ConnectionIndex c) {
    const std::uint16_t with = lanes_with_[c];
    return (Lanes)((kBit & with) != 0);
  });
}

// A connection separates exactly when nothing in the subtree below it reaches above it otherwise.
template <bool kOneWord>
void Connectivity::search_from(PartIndex start, SetView present) {
  const auto enter = [&](PartIndex part, PartIndex from, ConnectionIndex by) {
    position_[part] = visited_;
    low_[part] = visited_;
    order_[visited_++] = part;
    root_[part] = start;
    parent_[part] = from;
    parent_connection_[part] = by;
    if constexpr (kOneWord) {
      pending_[part] = present[0] & graph_.incident(part);
      if (by != kUnmet) pending_[part] &= ~(std::uint64_t{1} << by);
    } else {
      cursor_[part] = 0;
    }
  };

  separating_.clear();
  enter(start, kUnmet, kUnmet);
  PartIndex v = start;
  while (true) {
    PartIndex other = kUnmet;
    ConnectionIndex by = kUnmet;
    if constexpr (kOneWord) {
      if (pending_[v] != 0) {
        by = static_cast<ConnectionIndex>(std::countr_zero(pending_[v]));
        pending_[v] &= pending_[v] - 1;
        const auto [first, second] = graph_.ends(by);
        other = first ^ second ^ v;
      }
    } else {
      const auto around = graph_.around(v);
      while (cursor_[v] < around.size()) {
        const AssemblyGraph::HalfEdge& half = around[cursor_[v]++];
        if (half.connection == parent_connection_[v] || !contains(present, half.connection))
          continue;
        by = half.connection;
        other = half.other;
        break;
      }
    }
    if (other != kUnmet) {
      if (position_[other] == kUnmet) {
        enter(other, v, by);
        v = other;
      } else {
        low_[v] = std::min(low_[v], position_[other]);
        below_[by] = 0;
      }
      continue;
    }
    subtree_end_[v] = visited_;
    if (v == start) break;
    const PartIndex above = parent_[v];
    if (low_[v] == position_[v]) {
      const ConnectionIndex c = parent_connection_[v];
      below_[c] = visited_ - position_[v];
      lower_end_[c] = v;
      separating_.push_back(c);
    } else {
      below_[parent_connection_[v]] = 0;
    }
    low_[above] = std::min(low_[above], low_[v]);
    v = above;
  }
  const std::uint32_t size = visited_ - position_[start];
  for (const ConnectionIndex c : separating_) piece_[c] = size;
  if (size >= 2) ++subassemblies_;
}

Side Connectivity::lower_side(ConnectionIndex c) const {
  return {{std::span(order_).subspan(position_[lower_end_[c]], below_[c]), {}}};
}

Side Connectivity::upper_side(ConnectionIndex c) const {
  const PartIndex child = lower_end_[c];
  const PartIndex root = root_[child];
  const std::span<const PartIndex> all(order_);
  return {{all.subspan(position_[root], position_[child] - position_[root]),
           all.subspan(subtree_end_[child], subtree_end_[root] - subtree_end_[child])}};
}

Side Connectivity::piece_of(PartIndex part) const {
  const PartIndex root = root_[part];
  return {{std::span(order_).subspan(position_[root], subtree_end_[root] - position_[root]), {}}};
}

}  // namespace orasp::detail
