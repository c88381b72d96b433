#include "orasp/fleet/fleet_makespan.h"

#include <algorithm>
#include <array>
#include <bit>

namespace orasp {
namespace {

constexpr std::uint32_t kWorkBetweenPolls = 4096;

/// Subassemblies that a state may hold: one a site, two parts or more each.
std::size_t most_blocks(const FleetProblem& fleet) {
  return std::max<std::size_t>(1, std::min(fleet.most_subassemblies(), fleet.num_parts() / 2));
}

}  // namespace

FleetMakespanSearch::FleetMakespanSearch(FleetExpander& expander, const Budget& budget)
    : expander_(expander),
      budget_(budget),
      robots_(expander.fleet().robots()),
      most_(most_blocks(expander.fleet())),
      table_(most_),
      levels_(kFleetMaxParts + 2) {
  nodes_[number_of({})].upper = 0;  // nothing is left: state 0
  expander_.set_interrupt([this] { return expired(); });
}

FleetMakespanSearch::StateNumber FleetMakespanSearch::number_of(
    std::span<const PartMask> subassemblies) {
  std::array<PartMask, kFleetMaxParts / 2> key{};
  std::ranges::copy(subassemblies, key.begin());
  std::sort(key.begin(), key.begin() + static_cast<std::ptrdiff_t>(subassemblies.size()),
            std::greater());
  const auto [number, is_new] = table_.insert(key.data());
  if (is_new) {
    std::size_t parts = 0;
    for (const PartMask piece : subassemblies) parts += size_of(piece);
    Node node;
    node.lower = static_cast<std::uint8_t>((parts + robots_ - 1) / robots_);
    nodes_.push_back(node);
  }
  return number;
}

std::span<const PartMask> FleetMakespanSearch::pieces(StateNumber state) const {
  const PartMask* const key = table_.key(state);
  std::size_t count = 0;
  while (count < most_ && key[count] != 0) ++count;
  return {key, count};
}

std::uint64_t FleetMakespanSearch::bytes() const {
  return table_.bytes() + nodes_.bytes() + expander_.bytes();
}

bool FleetMakespanSearch::expired() {
  if (stop_ == Stop::None) stop_ = budget_.expired(bytes(), statistics_.expanded);
  budget_.report({.phase = "search", .done = statistics_.expanded, .states = num_states()});
  return stop_ != Stop::None;
}

void FleetMakespanSearch::improve(StateNumber state, StateNumber next) {
  Node& node = nodes_[state];
  const std::size_t steps = nodes_[next].upper + std::size_t{1};
  if (steps >= node.upper) return;
  node.upper = static_cast<std::uint8_t>(steps);
  node.next = next;
}

std::uint64_t FleetMakespanSearch::rank(StateNumber state) const {
  std::array<std::size_t, kFleetMaxParts + 1> peeled{};  // parts of each round, of all pieces
  std::size_t rounds = 0;
  std::size_t largest = 0;
  std::size_t parts = 0;
  for (const PartMask piece : pieces(state)) {
    largest = std::max(largest, size_of(piece));
    parts += size_of(piece);
    std::size_t round = 0;
    for (PartMask left = piece; left != 0; ++round) {
      PartMask outer = 0;
      for_each_part(left, [&](std::size_t part) {
        const PartMask beside = expander_.neighbours(part) & left;
        if ((beside & (beside - 1)) == 0) outer |= PartMask{1} << part;
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
  return std::uint64_t{nodes_[state].lower} << 48 | steps << 40 | std::uint64_t{largest} << 32 |
         depth << 8 | parts;
}

std::size_t FleetMakespanSearch::raised_by_pieces(StateNumber state) {
  std::size_t bound = nodes_[state].lower;
  const std::size_t count = pieces(state).size();
  if (count < 2) return bound;
  for (std::size_t i = 0; i < count; ++i) {
    const PartMask piece = pieces(state)[i];
    bound = std::max(bound, lower(number_of({&piece, 1})));
  }
  nodes_[state].lower = static_cast<std::uint8_t>(bound);
  return bound;
}

void FleetMakespanSearch::list_successors(StateNumber state, const Demand& demand,
                                          std::vector<Successor>& successors) {
  ++statistics_.expanded;
  ++listings_;
  successors.clear();
  std::array<PartMask, kFleetMaxParts / 2> before;
  const std::size_t count = pieces(state).size();
  std::ranges::copy(pieces(state), before.begin());
  std::array<PartMask, kFleetMaxParts> after;
  std::uint32_t work = 0;

  struct Left {
    std::size_t robots;
    std::size_t held;
    std::size_t freed;  ///< still needed
    std::size_t blocks;
  };
  const auto choose = [&](auto& self, std::size_t i, std::size_t num_after,
                          const Left& left) -> void {
    if (i == count) {
      if (left.freed > 0) return;
      ++statistics_.generated;
      const StateNumber next = number_of({after.data(), num_after});
      Node& node = nodes_[next];
      if (node.listed == listings_ || next == state) return;
      node.listed = listings_;
      successors.push_back({next, 0});
      return;
    }
    if (left.robots < left.freed) return;
    const PartMask piece = before[i];
    const auto locks = expander_.locks({before.data(), count}, piece);
    const FleetExpander::Means means = {
        .robots = left.robots, .held = left.held, .cluster = demand.cluster};
    expander_.for_each_split(piece, locks, means, [&](const FleetSplit& split) {
      if (stop_ != Stop::None || (++work % kWorkBetweenPolls == 0 && expired())) return false;
      const std::size_t more = split.moved.size() + (split.stays != 0 ? 1 : 0);
      if (more > left.blocks) return true;
      std::size_t end = num_after;
      if (split.stays != 0) after[end++] = split.stays;
      for (const PartMask block : split.moved) after[end++] = block;
      const std::size_t freed_here = size_of(split.freed);
      self(self, i + 1, end,
           Left{.robots = left.robots - split.robots(),
                .held = left.held - split.held,
                .freed = left.freed - std::min(left.freed, freed_here),
                .blocks = left.blocks - more});
      return successors.size() < demand.most;
    });
  };
  choose(
      choose, 0, 0,
      Left{.robots = robots_, .held = demand.held, .freed = demand.freed, .blocks = demand.blocks});
}

bool FleetMakespanSearch::finishes(StateNumber state, std::size_t steps) {
  steps = std::min(steps, kFleetMaxParts);  // each step cuts, so more are not needed
  if (nodes_[state].upper <= steps) return true;
  if (nodes_[state].lower > steps || stop_ != Stop::None) return false;
  if (expired_by_now()) return false;

  // Each subassembly alone.
  const std::size_t count = pieces(state).size();
  if (count > 1) {
    for (std::size_t i = 0; i < count; ++i) {
      const PartMask piece = pieces(state)[i];
      const StateNumber alone = number_of({&piece, 1});
      if (finishes(alone, steps)) continue;
      if (stop_ == Stop::None)
        nodes_[state].lower = std::max(nodes_[state].lower, nodes_[alone].lower);
      return false;
    }
  }

  std::size_t parts = 0;
  for (const PartMask piece : pieces(state)) parts += size_of(piece);
  const std::size_t later = robots_ * (steps - 1);
  const std::size_t freed = parts > later ? parts - later : 0;
  std::vector<Successor>& successors = levels_[steps];
  list_successors(state,
                  {.held = robots_ - freed, .freed = freed, .blocks = steps == 1 ? 0 : most_},
                  successors);
  if (stop_ != Stop::None) return false;

  // What was not listed takes more than the steps left.
  std::size_t least = freed > 0 || steps == 1 ? steps : kNoPlan;
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
  nodes_[state].lower = static_cast<std::uint8_t>(std::min<std::size_t>(least + 1, kNoPlan));
  return false;
}

void FleetMakespanSearch::find_plan(StateNumber start, std::size_t width, std::size_t cluster) {
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

std::vector<std::vector<PartMask>> FleetMakespanSearch::plan_from(StateNumber start) const {
  std::vector<std::vector<PartMask>> states;
  for (StateNumber state = start;; state = nodes_[state].next) {
    const auto now = pieces(state);
    states.emplace_back(now.begin(), now.end());
    if (now.empty()) return states;
  }
}

}  // namespace orasp
