#include "orasp/fleet/fleet_travel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <utility>

#include "orasp/fleet/detail/fleet_plan_builder.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

constexpr std::uint32_t kWorkBetweenPolls = 4096;
/// Travel closer than this counts as equal, m^2: sums of the same numbers in another order.
constexpr double kTravelTolerance = 1e-9;
/// Ways to place a known plan that are followed from step to step.
constexpr std::size_t kPlacingsKept = 256;
constexpr std::size_t kPointsInWord = 8;
/// A search that is not done after so many expansions looks for a better plan meanwhile.
constexpr std::uint64_t kExpansionsBeforeBeam = 5000;
constexpr std::size_t kBeamWidth = 32;
constexpr std::ptrdiff_t kPlacingsOfOneState = 2;

template <class Parts>
double times(const Parts& parts, double each) {
  return static_cast<double>(size_of(parts)) * each;
}

}  // namespace

template <class Parts>
FleetTravelSearch<Parts>::FleetTravelSearch(FleetExpander<Parts>& expander,
                                            FleetMakespanSearch<Parts>& makespan,
                                            const Budget& budget)
    : expander_(expander),
      makespan_(makespan),
      budget_(budget),
      robots_(expander.fleet().robots()),
      first_site_{kDepot},
      room_{0},
      table_(1 + (makespan.most_pieces() + kPointsInWord - 1) / kPointsInWord),
      levels_(kFleetMaxTravelSteps + 1) {
  const FleetProblem& fleet = expander.fleet();
  constexpr std::size_t kMostSites = 255;
  if (fleet.num_sites() > kMostSites)
    throw InputError("fleet.sites: the search for the least travel takes at most " +
                     std::to_string(kMostSites) + " sites, and there are " +
                     std::to_string(fleet.num_sites()));
  for (PlaceIndex site = 1; site < fleet.num_places(); ++site) {
    std::size_t point = 1;
    while (point < first_site_.size() && fleet.place(first_site_[point]) != fleet.place(site))
      ++point;
    if (point == first_site_.size()) {
      first_site_.push_back(site);
      room_.push_back(0);
    }
    ++room_[point];
  }
  const std::size_t points = first_site_.size();
  distance_.assign(points, std::vector<double>(points));
  for (std::size_t a = 0; a < points; ++a) {
    for (std::size_t b = 0; b < points; ++b)
      distance_[a][b] = fleet.squared_distance(first_site_[a], first_site_[b]);
  }
  hops_.push_back(std::vector<double>(points, kInfinity));
  hops_[0][kDepot] = 0;
  for (std::size_t steps = 1; steps <= points + 1; ++steps) {
    std::vector<double> hops = hops_.back();
    for (std::size_t a = 1; a < points; ++a) {
      hops[a] = std::min(hops[a], distance_[a][kDepot]);
      for (std::size_t b = 1; b < points; ++b)
        hops[a] = std::min(hops[a], distance_[a][b] + hops_.back()[b]);
    }
    hops_.push_back(std::move(hops));
  }
}

template <class Parts>
std::uint64_t FleetTravelSearch<Parts>::bytes() const {
  return table_.bytes() + nodes_.bytes() + makespan_.bytes();
}

template <class Parts>
bool FleetTravelSearch<Parts>::expired() {
  if (stop_ == Stop::None) stop_ = budget_.expired(bytes(), statistics_.expanded);
  budget_.report({.phase = "travel", .done = statistics_.expanded, .states = num_states()});
  return stop_ != Stop::None;
}

template <class Parts>
double FleetTravelSearch<Parts>::hops(std::span<const Placed> placed, std::size_t steps) const {
  double sum = 0;
  for (const Placed& piece : placed) sum += times(piece.parts, hop(piece.point, steps));
  return sum;
}

template <class Parts>
std::uint32_t FleetTravelSearch<Parts>::number_of(std::span<const Placed> placed,
                                                  std::size_t steps) {
  struct Standing {
    Shape shape;
    std::uint8_t point;
    auto operator<=>(const Standing&) const = default;
  };
  std::vector<Standing> sorted(placed.size());
  std::ranges::transform(placed, sorted.begin(), [this](const Placed& piece) {
    return Standing{makespan_.shapes().of(piece.parts), piece.point};
  });
  std::ranges::sort(sorted);
  std::vector<Shape> shapes(placed.size());
  std::vector<std::uint64_t> key(1 + (makespan_.most_pieces() + kPointsInWord - 1) / kPointsInWord);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    shapes[i] = sorted[i].shape;
    key[1 + i / kPointsInWord] |= std::uint64_t{sorted[i].point} << (i % kPointsInWord * 8);
  }
  if (placed.empty()) steps = 0;  // the end, whenever it comes
  key[0] = makespan_.number_of_shapes({shapes.data(), placed.size()}) | std::uint64_t{steps} << 32;
  const auto [number, is_new] = table_.insert(key.data());
  if (is_new) {
    nodes_.push_back(placed.empty()
                         ? Node{.lower = 0, .next = 0, .exact = true}
                         : Node{.lower = hops(placed, steps), .next = 0, .exact = false});
  }
  return number;
}

template <class Parts>
typename FleetTravelSearch<Parts>::Places FleetTravelSearch<Parts>::placed(
    std::uint32_t node) const {
  Places places;
  const std::uint64_t* const key = table_.key(node);
  for (const Parts& piece : makespan_.pieces(state(node))) {
    const std::size_t i = places.size();
    places.push_back(
        {piece, static_cast<std::uint8_t>(key[1 + i / kPointsInWord] >> (i % kPointsInWord * 8))});
  }
  return places;
}

template <class Parts>
template <class Visit>
void FleetTravelSearch<Parts>::for_each_placing(std::span<const Parts> blocks, Places& placed,
                                                Visit&& visit) const {
  std::vector<std::size_t> room = room_;
  for (const Placed& piece : placed) {
    if (room[piece.point]-- == 0) return;
  }
  const auto place = [&](auto& self, std::size_t i) -> void {
    if (i == blocks.size()) {
      visit();
      return;
    }
    for (std::size_t point = 1; point < room.size(); ++point) {
      if (room[point] == 0) continue;
      --room[point];
      placed.push_back({blocks[i], static_cast<std::uint8_t>(point)});
      self(self, i + 1);
      placed.pop_back();
      ++room[point];
    }
  };
  place(place, 0);
}

template <class Parts>
double FleetTravelSearch<Parts>::list_successors(std::uint32_t node, double limit,
                                                 std::vector<Successor>& successors) {
  ++statistics_.expanded;
  successors.clear();
  const std::size_t steps = steps_left(node);
  const Places before = placed(node);
  std::vector<Parts> pieces;
  std::size_t parts = 0;
  for (const Placed& piece : before) {
    pieces.push_back(piece.parts);
    parts += size_of(piece.parts);
  }
  const std::size_t later = robots_ * (steps - 1);
  const std::size_t freed = parts > later ? parts - later : 0;
  double least_cut = kInfinity;
  const auto within = [&](double total) {
    if (total <= limit + kTravelTolerance) return true;
    least_cut = std::min(least_cut, total);
    return false;
  };

  std::uint32_t work = 0;
  std::vector<Placed> standing(expander_.fleet().num_parts());
  struct Lifted {
    Parts parts;
    std::size_t point;  ///< that it comes from
  };
  std::vector<Lifted> lifted(expander_.fleet().num_parts());
  std::vector<std::size_t> room = room_;
  struct Left {
    std::size_t robots;
    std::size_t held;
    std::size_t freed;  ///< still needed
    std::size_t blocks;
  };
  // `cost` is paid, `rest` the hops of what stands afterwards and of what is not yet dealt with.
  const auto place = [&](auto& self, std::size_t i, std::size_t num_lifted,
                         std::size_t num_standing, double cost, double rest) -> void {
    if (i == num_lifted) {
      if (num_standing == before.size() &&
          std::is_permutation(before.begin(), before.end(), standing.begin()))
        return;  // waiting
      ++statistics_.generated;
      const std::uint32_t next = number_of({standing.data(), num_standing}, steps - 1);
      const double total = cost + nodes_[next].lower;
      if (makespan_.lower(state(next)) > steps - 1 || !within(total)) {
        ++statistics_.pruned;
        return;
      }
      successors.push_back({next, cost, total, makespan_.rank(state(next))});
      return;
    }
    const Lifted& block = lifted[i];
    for (std::size_t point = 1; point < room.size(); ++point) {
      if (room[point] == 0) continue;
      const double more = times(block.parts, distance_[block.point][point]);
      const double hops = times(block.parts, hop(point, steps - 1));
      if (!within(cost + more + rest + hops)) continue;
      --room[point];
      standing[num_standing] = {block.parts, static_cast<std::uint8_t>(point)};
      self(self, i + 1, num_lifted, num_standing + 1, cost + more, rest + hops);
      ++room[point];
    }
  };
  const auto choose = [&](auto& self, std::size_t i, std::size_t num_lifted,
                          std::size_t num_standing, const Left& left, double cost,
                          double rest) -> void {
    if (i == before.size()) {
      if (left.freed > 0) return;
      for (std::size_t s = 0; s < num_standing; ++s) --room[standing[s].point];
      place(place, 0, num_lifted, num_standing, cost, rest);
      for (std::size_t s = 0; s < num_standing; ++s) ++room[standing[s].point];
      return;
    }
    if (left.robots < left.freed) return;
    const Placed& piece = before[i];
    const double rest_of_others = rest - times(piece.parts, hop(piece.point, steps));
    const auto locks = expander_.locks(pieces, piece.parts);
    expander_.for_each_split(
        piece.parts, locks, {.robots = left.robots, .held = left.held},
        [&](const FleetSplit<Parts>& split) {
          if (stop() != Stop::None || (++work % kWorkBetweenPolls == 0 && expired())) return false;
          const std::size_t more = split.moved.size() + (split.stays != 0 ? 1 : 0);
          if (more > left.blocks) return true;
          if (split.stays != 0 && steps == 1) return true;
          const double paid = cost + times(split.freed, distance_[piece.point][kDepot]);
          double rest_now = rest_of_others;
          std::size_t end = num_standing;
          if (split.stays != 0) {
            rest_now += times(split.stays, hop(piece.point, steps - 1));
            standing[end++] = {split.stays, piece.point};
          }
          if (!within(paid + rest_now + static_cast<double>(split.held) * hop(piece.point, steps)))
            return true;
          for (std::size_t m = 0; m < split.moved.size(); ++m)
            lifted[num_lifted + m] = {split.moved[m], piece.point};
          self(self, i + 1, num_lifted + split.moved.size(), end,
               Left{.robots = left.robots - split.robots(),
                    .held = left.held - split.held,
                    .freed = left.freed - std::min(left.freed, size_of(split.freed)),
                    .blocks = left.blocks - more},
               paid, rest_now);
          return true;
        });
  };
  choose(choose, 0, 0, 0,
         Left{.robots = robots_,
              .held = robots_ - std::min(robots_, freed),
              .freed = freed,
              .blocks = steps == 1 ? 0 : makespan_.most_pieces()},
         0, hops(before, steps));
  return least_cut;
}

template <class Parts>
double FleetTravelSearch<Parts>::solve(std::uint32_t node, double limit) {
  if (nodes_[node].exact || nodes_[node].lower > limit + kTravelTolerance || stop() != Stop::None)
    return nodes_[node].lower;
  if (expired_by_now()) return nodes_[node].lower;
  const std::size_t steps = steps_left(node);
  if (!makespan_.finishes(state(node), steps)) {
    if (stop() == Stop::None) nodes_[node].lower = kInfinity;
    return nodes_[node].lower;
  }

  const Places before = placed(node);
  if (before.size() > 1) {
    // Each subassembly alone.
    std::vector<std::uint32_t> alone;
    double sum = 0;
    for (const Placed& piece : before) {
      alone.push_back(number_of({&piece, 1}, steps));
      sum += nodes_[alone.back()].lower;
    }
    for (const std::uint32_t piece : alone) {
      if (sum > limit + kTravelTolerance) break;
      const double others = sum - nodes_[piece].lower;
      sum = others + solve(piece, limit - others);
      if (stop() != Stop::None) return nodes_[node].lower;
    }
    nodes_[node].lower = std::max(nodes_[node].lower, sum);
    if (sum > limit + kTravelTolerance) return nodes_[node].lower;
  }

  std::vector<Successor>& successors = levels_[steps];
  double least_cut = list_successors(node, limit, successors);
  if (stop() != Stop::None) return nodes_[node].lower;
  std::ranges::sort(successors, {}, [](const Successor& successor) {
    return std::tuple(successor.total, successor.rank, successor.node);
  });
  double best = kInfinity;
  std::uint32_t best_next = 0;
  for (std::size_t i = 0; i < successors.size(); ++i) {
    const auto [next, cost, listed, rank] = successors[i];
    const bool improves =
        cost + nodes_[next].lower <= std::min(limit + kTravelTolerance, best - kTravelTolerance);
    if (improves) {
      solve(next, std::min(limit, best) - cost);
      if (stop() != Stop::None) return nodes_[node].lower;
    }
    const double total = cost + nodes_[next].lower;
    if (nodes_[next].exact && total < best) {
      best = total;
      best_next = next;
    } else if (!nodes_[next].exact) {
      least_cut = std::min(least_cut, total);
    }
  }
  Node& known = nodes_[node];
  if (best <= limit + kTravelTolerance) {
    known = {.lower = best, .next = best_next, .exact = true};
  } else {
    known.lower = std::max(known.lower, std::min(best, least_cut));
  }
  return known.lower;
}

template <class Parts>
void FleetTravelSearch<Parts>::run(StateNumber start, std::size_t steps) {
  const auto first = makespan_.pieces(start);
  const std::vector<Parts> pieces(first.begin(), first.end());
  std::vector<std::uint32_t> starts;
  Places places;
  for_each_placing(pieces, places, [&] { starts.push_back(number_of(places, steps)); });
  const auto by_bound = [this](std::uint32_t node) { return nodes_[node].lower; };
  bool has_looked = false;
  while (true) {
    std::ranges::stable_sort(starts, {}, by_bound);
    lower_ = std::max(lower_, nodes_[starts.front()].lower);
    if (lower_ >= upper_ - kTravelTolerance) {
      lower_ = upper_;
      return;
    }
    if (nodes_[starts.front()].exact || stop() != Stop::None) break;
    if (!has_looked && statistics_.expanded > kExpansionsBeforeBeam) {
      has_looked = true;
      find_plan(starts, Prefer::NearTheEnd);
      find_plan(starts, Prefer::LittleTravel);
      continue;
    }
    const double least = nodes_[starts.front()].lower;
    for (const std::uint32_t node : starts) {
      if (nodes_[node].lower > least + kTravelTolerance) break;
      solve(node, least);
    }
  }
  if (stop() != Stop::None) return;
  best_.clear();
  upper_ = lower_;
  for (std::uint32_t node = starts.front();; node = nodes_[node].next) {
    best_.push_back(placed(node));
    if (best_.back().empty()) return;
  }
}

template <class Parts>
void FleetTravelSearch<Parts>::find_plan(const std::vector<std::uint32_t>& starts, Prefer prefer) {
  struct Met {
    std::uint32_t node;
    std::size_t parent;  ///< position in the layer before
    double cost;         ///< so far
    double total;        ///< with the bound on what is left
    std::uint64_t rank;
  };
  std::vector<std::vector<Met>> layers(1);
  for (const std::uint32_t node : starts) layers[0].push_back({node, 0, 0, nodes_[node].lower, 0});
  std::vector<Successor> successors;
  while (!layers.back().empty()) {
    std::vector<Met> next;
    for (std::size_t i = 0; i < layers.back().size(); ++i) {
      const Met& from = layers.back()[i];
      list_successors(from.node, upper_ - kTravelTolerance - from.cost, successors);
      if (stop() != Stop::None) return;
      for (const Successor& successor : successors)
        next.push_back({successor.node, i, from.cost + successor.cost, from.cost + successor.total,
                        successor.rank});
    }
    std::ranges::sort(next, {}, [prefer](const Met& met) {
      return std::tuple(prefer == Prefer::NearTheEnd ? met.rank : 0, met.total, met.rank, met.node,
                        met.parent);
    });
    std::vector<Met> kept;
    for (const Met& met : next) {
      if (kept.size() == kBeamWidth) break;
      if (state(met.node) == 0) {
        if (met.cost >= upper_ - kTravelTolerance) continue;
        upper_ = met.cost;
        best_.assign(layers.size() + 1, {});
        std::size_t at = met.parent;
        for (std::size_t layer = layers.size(); layer-- > 0; at = layers[layer][at].parent)
          best_[layer] = placed(layers[layer][at].node);
        continue;
      }
      const auto same = [&met](const Met& other) { return other.node == met.node; };
      const auto same_pieces = [&](const Met& other) {
        return state(other.node) == state(met.node);
      };
      if (std::ranges::any_of(kept, same) ||
          std::ranges::count_if(kept, same_pieces) == kPlacingsOfOneState)
        continue;
      if (makespan_.finishes(state(met.node), steps_left(met.node))) kept.push_back(met);
      if (stop() != Stop::None) return;
    }
    layers.push_back(std::move(kept));
  }
}

template <class Parts>
void FleetTravelSearch<Parts>::place_known_plan(StateNumber start) {
  const std::vector<std::vector<Parts>> states = makespan_.plan_from(start);
  struct Placing {
    Places places;
    double cost = 0;
    std::size_t parent = 0;
  };
  std::vector<std::vector<Placing>> layers(1);
  Places places;
  for_each_placing(states[0], places, [&] { layers[0].push_back({places, 0, 0}); });
  const auto keep_best = [this](std::vector<Placing>& layer, std::size_t steps) {
    std::ranges::stable_sort(layer, {}, [&](const Placing& placing) {
      return placing.cost + hops(placing.places, steps);
    });
    std::vector<Placing> kept;
    for (Placing& placing : layer) {
      if (kept.size() == kPlacingsKept) break;
      const auto same = [&](const Placing& other) { return other.places == placing.places; };
      if (std::ranges::none_of(kept, same)) kept.push_back(std::move(placing));
    }
    layer = std::move(kept);
  };

  for (std::size_t t = 1; t < states.size(); ++t) {
    const std::size_t steps = states.size() - t;
    keep_best(layers.back(), steps);
    std::vector<std::vector<detail::MatchingSplit<Parts>>> ways;
    for (const Parts& piece : states[t - 1])
      ways.push_back(detail::matching_splits<Parts>(
          expander_, piece, expander_.locks(states[t - 1], piece), states[t]));
    std::vector<Placing> next;
    std::vector<Parts> stays(ways.size());
    const auto choose = [&](auto& self, std::size_t i, std::size_t robots) -> void {
      if (i < ways.size()) {
        for (const detail::MatchingSplit<Parts>& way : ways[i]) {
          if (way.robots > robots) continue;
          stays[i] = way.stays;
          self(self, i + 1, robots - way.robots);
        }
        return;
      }
      std::vector<Parts> moved;
      for (const Parts& block : states[t]) {
        if (std::ranges::find(stays, block) == stays.end()) moved.push_back(block);
      }
      for (std::size_t parent = 0; parent < layers.back().size(); ++parent) {
        const Placing& from = layers.back()[parent];
        const auto point_before = [&from](Parts block) {
          const auto holds = [block](const Placed& piece) { return (piece.parts & block) != 0; };
          return std::ranges::find_if(from.places, holds)->point;
        };
        double freed_cost = from.cost;
        Places after;
        for (const Placed& piece : from.places) {
          Parts freed = piece.parts;
          for (const Parts& block : states[t]) freed &= ~block;
          freed_cost += times(freed, distance_[piece.point][kDepot]);
        }
        for (const Parts& block : stays) {
          if (block != 0) after.push_back({block, point_before(block)});
        }
        for_each_placing(moved, after, [&] {
          Placing placing{.places = after, .cost = freed_cost, .parent = parent};
          for (const Placed& piece : after)
            placing.cost += times(piece.parts, distance_[point_before(piece.parts)][piece.point]);
          std::ranges::sort(placing.places, {}, &Placed::parts);
          next.push_back(std::move(placing));
        });
      }
    };
    choose(choose, 0, robots_);
    layers.push_back(std::move(next));
  }

  const auto best = std::ranges::min_element(layers.back(), {}, &Placing::cost);
  if (best == layers.back().end() || best->cost >= upper_) return;
  upper_ = best->cost;
  best_.assign(layers.size(), {});
  const Placing* at = &*best;
  for (std::size_t t = layers.size(); t-- > 0;) {
    best_[t] = at->places;
    if (t > 0) at = &layers[t - 1][at->parent];
  }
}

template <class Parts>
FleetPlan FleetTravelSearch<Parts>::plan() {
  std::vector<std::vector<detail::PlacedPiece<Parts>>> states;
  for (const Places& places : best_) {
    std::vector<detail::PlacedPiece<Parts>>& state = states.emplace_back();
    for (const Placed& piece : places) state.push_back({piece.parts, first_site_[piece.point]});
  }
  return detail::build_fleet_plan(expander_, states);
}

ORASP_FOR_EVERY_PART_SET(FleetTravelSearch);

}  // namespace orasp
