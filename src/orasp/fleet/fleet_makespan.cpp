#include "orasp/fleet/fleet_makespan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <utility>

namespace orasp {
namespace {

constexpr std::uint32_t kWorkBetweenPolls = 4096;

/// Subassemblies that a state may hold: one a site, two parts or more each.
std::size_t most_blocks(const FleetProblem& fleet) {
  return std::max<std::size_t>(1, std::min(fleet.most_subassemblies(), fleet.num_parts() / 2));
}

}  // namespace

template <class Parts>
FleetMakespanSearch<Parts>::FleetMakespanSearch(FleetExpander<Parts>& expander,
                                                const Budget& budget)
    : expander_(expander),
      budget_(budget),
      robots_(expander.fleet().robots()),
      most_(most_blocks(expander.fleet())),
      shapes_(expander),
      table_(most_),
      key_(most_),
      numbered_(most_),
      levels_(expander.fleet().num_parts() + 2) {
  nodes_[number_of({})].upper = 0;  // nothing is left: state 0
  expander_.set_interrupt([this] { return expired(); });
}

template <class Parts>
typename FleetMakespanSearch<Parts>::StateNumber FleetMakespanSearch<Parts>::number_of(
    std::span<const Parts> subassemblies) {
  std::ranges::transform(subassemblies, numbered_.begin(),
                         [this](Parts piece) { return shapes_.of(piece); });
  return number_of_shapes({numbered_.data(), subassemblies.size()});
}

template <class Parts>
typename FleetMakespanSearch<Parts>::StateNumber FleetMakespanSearch<Parts>::number_of_shapes(
    std::span<Shape> shapes) {
  std::ranges::sort(shapes);
  std::ranges::fill(key_, std::uint64_t{0});  // shape + 1; 0: no more
  std::ranges::transform(shapes, key_.begin(),
                         [](Shape shape) { return shape + std::uint64_t{1}; });
  const auto [number, is_new] = table_.insert(key_.data());
  if (is_new) {
    std::size_t parts = 0;
    for (const Shape shape : shapes) parts += size_of(shapes_.piece(shape));
    Node node;
    node.lower = static_cast<std::uint16_t>((parts + robots_ - 1) / robots_);
    nodes_.push_back(node);
  }
  return number;
}

template <class Parts>
std::span<const std::uint64_t> FleetMakespanSearch<Parts>::shapes_of(StateNumber state) const {
  const std::uint64_t* const key = table_.key(state);
  std::size_t count = 0;
  while (count < most_ && key[count] != 0) ++count;
  return {key, count};
}

template <class Parts>
std::vector<Parts> FleetMakespanSearch<Parts>::pieces(StateNumber state) const {
  std::vector<Parts> pieces;
  for (const std::uint64_t shape : shapes_of(state))
    pieces.push_back(shapes_.piece(static_cast<Shape>(shape - 1)));
  return pieces;
}

template <class Parts>
std::uint64_t FleetMakespanSearch<Parts>::bytes() const {
  return table_.bytes() + nodes_.bytes() + shapes_.bytes() + expander_.bytes();
}

template <class Parts>
bool FleetMakespanSearch<Parts>::expired() {
  if (is_replaying_) return false;
  if (stop_ == Stop::None) stop_ = budget_.expired(bytes(), statistics_.expanded);
  budget_.report({.phase = "search", .done = statistics_.expanded, .states = num_states()});
  return stop_ != Stop::None;
}

template <class Parts>
void FleetMakespanSearch<Parts>::improve(StateNumber state, StateNumber next) {
  Node& node = nodes_[state];
  const std::size_t steps = nodes_[next].upper + std::size_t{1};
  if (steps >= node.upper) return;
  node.upper = static_cast<std::uint16_t>(steps);
  node.next = next;
}

template <class Parts>
std::uint64_t FleetMakespanSearch<Parts>::rank(StateNumber state) const {
  std::array<std::size_t, kMostParts<Parts> + 1> peeled{};  // parts of each round, of all pieces
  std::size_t rounds = 0;
  std::size_t largest = 0;
  std::size_t parts = 0;
  for (const Parts& piece : pieces(state)) {
    largest = std::max(largest, size_of(piece));
    parts += size_of(piece);
    std::size_t round = 0;
    for (Parts left = piece; left != 0; ++round) {
      Parts outer = 0;
      for_each_part(left, [&](std::size_t part) {
        const Parts beside = expander_.neighbours(part) & left;
        if (without_first(beside) == 0) outer |= only<Parts>(part);
      });
      if (outer == 0) outer = left;  // a core without ends
      peeled[round] += size_of(outer);
      left &= ~outer;
    }
    rounds = std::max(rounds, round);
  }
  std::uint64_t steps = 0;
  std::uint64_t depth = 0;
  std::size_t inner = 0;
  for (std::size_t round = rounds; round-- > 0;) {
    inner += peeled[round];
    steps = std::max<std::uint64_t>(steps, round + (inner + robots_ - 1) / robots_);
    depth += round * peeled[round];
  }
  static_assert(kFleetMaxParts <= 1024);  // so 20 bits hold the depth, 11 the others but `lower`
  return std::min<std::uint64_t>(nodes_[state].lower, 0x7ff) << 53 | steps << 42 |
         std::uint64_t{largest} << 31 | depth << 11 | parts;
}

template <class Parts>
typename FleetMakespanSearch<Parts>::StateNumber FleetMakespanSearch<Parts>::alone(
    StateNumber state, std::size_t i) {
  auto shape = static_cast<Shape>(table_.key(state)[i] - 1);
  return number_of_shapes({&shape, 1});
}

template <class Parts>
std::size_t FleetMakespanSearch<Parts>::raised_by_pieces(StateNumber state) {
  std::size_t bound = nodes_[state].lower;
  const std::size_t count = shapes_of(state).size();
  if (count < 2) return bound;
  for (std::size_t i = 0; i < count; ++i) bound = std::max(bound, lower(alone(state, i)));
  nodes_[state].lower = static_cast<std::uint16_t>(bound);
  return bound;
}

template <class Parts>
template <class Visit>
void FleetMakespanSearch<Parts>::for_each_successor(StateNumber state, const Demand& demand,
                                                    Visit&& visit) {
  const std::vector<Parts> before = pieces(state);
  std::vector<Parts> after(most_);
  std::vector<std::size_t> from(most_);
  std::uint32_t work = 0;

  struct Left {
    std::size_t robots;
    std::size_t held;
    std::size_t freed;  ///< still needed
    std::size_t blocks;
  };
  const auto choose = [&](auto& self, std::size_t i, std::size_t num_after,
                          const Left& left) -> bool {
    if (i == before.size())
      return left.freed > 0 || visit(std::span<const Parts>(after).first(num_after), from);
    if (left.robots < left.freed) return true;
    const Parts piece = before[i];
    const auto locks = expander_.locks(before, piece);
    const typename FleetExpander<Parts>::Means means = {
        .robots = left.robots, .held = left.held, .cluster = demand.cluster};
    return expander_.for_each_split(piece, locks, means, [&](const FleetSplit<Parts>& split) {
      if (stop_ != Stop::None || (++work % kWorkBetweenPolls == 0 && expired())) return false;
      const std::size_t more = split.moved.size() + (split.stays != 0 ? 1 : 0);
      if (more > left.blocks) return true;
      std::size_t end = num_after;
      if (split.stays != 0) after[end++] = split.stays;
      for (const Parts& block : split.moved) after[end++] = block;
      std::fill(from.begin() + static_cast<std::ptrdiff_t>(num_after),
                from.begin() + static_cast<std::ptrdiff_t>(end), i);
      const std::size_t freed_here = size_of(split.freed);
      return self(self, i + 1, end,
                  Left{.robots = left.robots - split.robots(),
                       .held = left.held - split.held,
                       .freed = left.freed - std::min(left.freed, freed_here),
                       .blocks = left.blocks - more});
    });
  };
  choose(
      choose, 0, 0,
      Left{.robots = robots_, .held = demand.held, .freed = demand.freed, .blocks = demand.blocks});
}

template <class Parts>
void FleetMakespanSearch<Parts>::list_successors(StateNumber state, const Demand& demand,
                                                 std::vector<Successor>& successors) {
  ++statistics_.expanded;
  ++listings_;
  successors.clear();
  for_each_successor(state, demand, [&](std::span<const Parts> after, const auto& /*from*/) {
    ++statistics_.generated;
    const StateNumber next = number_of(after);
    Node& node = nodes_[next];
    if (node.listed != listings_ && next != state) {
      node.listed = listings_;
      successors.push_back({next, 0});
    }
    return successors.size() < demand.most;
  });
}

/// What a step must do, if `steps` steps with this one are to finish `state`.
template <class Parts>
typename FleetMakespanSearch<Parts>::Demand FleetMakespanSearch<Parts>::demand_of(
    StateNumber state, std::size_t steps) const {
  std::size_t parts = 0;
  for (const Parts& piece : pieces(state)) parts += size_of(piece);
  const std::size_t later = robots_ * (steps - 1);
  const std::size_t freed = parts > later ? parts - later : 0;
  return {.held = robots_ - freed, .freed = freed, .blocks = steps == 1 ? 0 : most_};
}

template <class Parts>
bool FleetMakespanSearch<Parts>::finishes(StateNumber state, std::size_t steps) {
  steps = std::min(steps, expander_.fleet().num_parts());  // each step cuts, so more are not needed
  if (nodes_[state].upper <= steps) return true;
  if (nodes_[state].lower > steps || stop_ != Stop::None) return false;
  if (expired_by_now()) return false;

  // Each subassembly alone.
  const std::size_t count = shapes_of(state).size();
  if (count > 1) {
    for (std::size_t i = 0; i < count; ++i) {
      const StateNumber piece = alone(state, i);
      if (finishes(piece, steps)) continue;
      if (stop_ == Stop::None)
        nodes_[state].lower = std::max(nodes_[state].lower, nodes_[piece].lower);
      return false;
    }
  }

  const Demand demand = demand_of(state, steps);
  std::vector<Successor>& successors = levels_[steps];
  list_successors(state, demand, successors);
  if (stop_ != Stop::None) return false;

  // What was not listed takes more than the steps left.
  std::size_t least = demand.freed > 0 || steps == 1 ? steps : kNoPlan;
  std::size_t kept = 0;
  for (const Successor successor : successors) {
    const std::size_t bound = raised_by_pieces(successor.state);
    if (nodes_[successor.state].upper < steps) {
      improve(state, successor.state);
      return true;
    }
    if (bound >= steps) {
      least = std::min(least, bound);
      ++statistics_.pruned;
      continue;
    }
    successors[kept++] = {successor.state, rank(successor.state)};
  }
  successors.resize(kept);
  std::ranges::sort(successors, {}, [](const Successor& successor) {
    return std::pair(successor.rank, successor.state);
  });
  for (std::size_t i = 0; i < successors.size(); ++i) {
    const StateNumber next = successors[i].state;
    if (finishes(next, steps - 1)) {
      improve(state, next);
      return true;
    }
    if (stop_ != Stop::None) return false;
    least = std::min(least, lower(next));
  }
  nodes_[state].lower = static_cast<std::uint16_t>(std::min<std::size_t>(least + 1, kNoPlan));
  return false;
}

template <class Parts>
void FleetMakespanSearch<Parts>::find_plan(StateNumber start, std::size_t width,
                                           std::size_t cluster) {
  constexpr std::size_t kSuccessorsEnough = 20'000;
  const Demand demand = {
      .held = robots_, .blocks = most_, .cluster = cluster, .most = kSuccessorsEnough};
  struct Met {
    StateNumber state;
    std::uint32_t parent;  ///< position in the layer before
    std::uint64_t rank;
  };
  std::vector<Successor> successors;
  for (std::size_t wide = 1; wide <= width && stop_ == Stop::None; wide *= 8) {
    std::vector<std::vector<Met>> layers = {{{start, 0, 0}}};
    while (!layers.back().empty() && layers.size() < nodes_[start].upper) {
      std::vector<Met> next;
      for (std::uint32_t i = 0; i < layers.back().size() && !expired_by_now(); ++i) {
        list_successors(layers.back()[i].state, demand, successors);
        for (const Successor successor : successors) {
          raised_by_pieces(successor.state);
          next.push_back({successor.state, i, rank(successor.state)});
        }
      }
      if (stop_ != Stop::None) return;
      std::ranges::sort(next, {},
                        [](const Met& met) { return std::tuple(met.rank, met.state, met.parent); });
      next.erase(std::unique(next.begin(), next.end(),
                             [](const Met& a, const Met& b) { return a.state == b.state; }),
                 next.end());
      if (next.size() > wide) next.resize(wide);
      layers.push_back(std::move(next));
      if (!layers.back().empty() && nodes_[layers.back().front().state].upper == 0) break;
    }
    if (layers.back().empty() || layers.back().front().state != 0) continue;
    std::uint32_t at = 0;
    for (std::size_t layer = layers.size() - 1; layer > 0; --layer) {
      const Met& met = layers[layer][at];
      improve(layers[layer - 1][met.parent].state, met.state);
      at = met.parent;
    }
    if (upper(start) == lower(start)) return;
  }
}

template <class Parts>
std::vector<std::vector<Parts>> FleetMakespanSearch<Parts>::plan_from(StateNumber start) {
  std::vector<std::vector<Parts>> states = {expander_.start()};
  is_replaying_ = true;
  const Stop stop = std::exchange(stop_, Stop::None);
  std::vector<std::size_t> place(expander_.fleet().num_parts());
  for (StateNumber state = start; nodes_[state].upper > 0; state = nodes_[state].next) {
    std::vector<Parts> now = states.back();
    // In the order of the shapes that stand for them.
    std::ranges::stable_sort(now, {}, [this](const Parts& piece) { return shapes_.of(piece); });
    std::vector<Parts>& next = states.emplace_back();
    bool is_found = false;
    for (const std::size_t cluster : {kFirstClusters, robots_}) {
      Demand demand = demand_of(state, nodes_[state].upper);
      demand.cluster = cluster;
      for_each_successor(state, demand, [&](std::span<const Parts> after, const auto& from) {
        if (number_of(after) != nodes_[state].next) return true;
        is_found = true;
        for (std::size_t i = 0; i < after.size(); ++i) {
          shapes_.match(now[from[i]], place);
          Parts block = 0;
          for_each_part(after[i], [&](std::size_t part) { block |= only<Parts>(place[part]); });
          next.push_back(block);
        }
        return false;
      });
      if (is_found) break;
    }
    assert(is_found);
  }
  is_replaying_ = false;
  stop_ = stop;
  return states;
}

ORASP_FOR_EVERY_PART_SET(FleetMakespanSearch);

}  // namespace orasp
