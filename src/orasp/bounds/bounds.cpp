#include "orasp/bounds/bounds.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/tolerance.h"

namespace orasp {

namespace {}  // namespace

void Bound::of_successors(SetView open, double, std::span<const Action> actions,
                          std::span<double> bounds) {
  successor_.assign(open.begin(), open.end());
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    const std::uint64_t bit = std::uint64_t{1} << (c % 64);
    successor_[c / 64] &= ~bit;
    bounds[i] = (*this)(successor_);
    successor_[c / 64] |= bit;
  }
}

ConnectionBound::ConnectionBound(const TransitionSystem& system) {
  const std::size_t connections = system.num_connections();
  last_surplus_ = connections == 0 ? 0 : -kInfinity;
  for (ConnectionIndex c = 0; c < connections; ++c) {
    greatest_.push_back(system.reward_range(c, connections, false).greatest);
    const double last = system.reward_range(c, connections, true).greatest;
    known_ = known_ && std::isfinite(greatest_.back()) && std::isfinite(last);
    last_surplus_ = std::max(last_surplus_, last - greatest_.back());
  }
}

double ConnectionBound::operator()(SetView open) {
  double sum = 0;
  bool goal = true;
  for_each_connection(open, [&](ConnectionIndex c) {
    sum += greatest_[c];
    goal = false;
  });
  if (goal) return 0;
  return known_ ? sum + last_surplus_ : kInfinity;
}

void ConnectionBound::of_successors(SetView open, double here, std::span<const Action> actions,
                                    std::span<double> bounds) {
  const bool last = count(open) == 1;
  for (std::size_t i = 0; i < actions.size(); ++i)
    bounds[i] = last ? 0 : here - greatest_[actions[i].connection];
}

// -------------------------------------------------------------------------------------------------

PieceGains::PieceGains(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  known_ = system.sees_piece_only() && problem.direction() == Direction::Disassembly &&
           problem.num_parts() <= kMostParts;
  if (!known_) return;
  Expander expander(system);
  find_units(system);
  try {
    last_surplus_ = system.num_steps() == 0 ? 0 : -kInfinity;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      own_.push_back(expander.own_reward(c));
      if (system.start().contains(c))
        last_surplus_ = std::max(last_surplus_, expander.completion_surplus(c));
    }
    most_moved_ = problem.limits().max_moved_parts.value_or(problem.num_parts());
    measure_sizes(system, expander);
    measure_parts(expander, problem);
  } catch (const InputError&) {
    // A formula without a value for a step that no plan may ever take, such as 1 / moved_parts
    // where nothing moves.
    known_ = sizes_known_ = parts_known_ = false;
  }
}

void PieceGains::find_units(const TransitionSystem& system) {
  if (system.kept().empty()) return;
  const std::size_t parts = system.problem().num_parts();
  merged_.assign(parts, 0);
  unit_.assign(parts, 0);
  const detail::AssemblyGraph graph(system.problem());
  graph.for_each_piece(system.kept().view(), [&](std::span<const PartIndex> unit) {
    const PartIndex first = *std::ranges::min_element(unit);
    for (const PartIndex part : unit) {
      unit_[part] = first;
      merged_[part] = part == first ? 0 : 1;
    }
  });
}

std::size_t PieceGains::excess(std::span<const PartIndex> piece) const {
  std::size_t sum = 0;
  if (!merged_.empty()) {
    for (const PartIndex part : piece) sum += merged_[part];
  }
  return sum;
}

double PieceGains::gain(std::size_t moved, std::size_t kept) const {
  const std::size_t parts = moved + kept;
  return moved > most_moved_ ? -kInfinity : gains_[(parts - 1) * (parts - 1) / 4 + moved - 1];
}

double PieceGains::by_arms(std::size_t parts, std::size_t arms) const {
  if (arms < 2 || by_arms_.empty()) return by_size_[parts];
  return by_arms_[std::min(arms - 2, by_arms_.size() - 1)][parts];
}

void PieceGains::measure_arms(const Problem& problem) {
  const std::size_t parts = problem.num_parts();
  std::vector<std::size_t> degree(parts, 0);
  std::size_t most_arms = 0;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    for (const PartIndex part : problem.ends(c)) most_arms = std::max(most_arms, ++degree[part]);
  }
  most_arms = std::min(most_arms, kMostArms);
  for (std::size_t arms = 2; arms <= most_arms; ++arms) {
    std::vector<double> best(parts + 1, -kInfinity);
    for (std::size_t n = arms + 1; n <= parts; ++n) {
      for (std::size_t a = 1; a + arms <= n; ++a) {
        best[n] = std::max(best[n], gain(std::min(a, n - a), std::max(a, n - a)) + by_size_[a] +
                                        by_arms(n - a, arms - 1));
      }
    }
    by_arms_.push_back(std::move(best));
  }
}

void PieceGains::measure_sizes(const TransitionSystem& system, Expander& expander) {
  const Problem& problem = system.problem();
  const std::size_t parts = problem.num_parts();
  by_size_.assign(parts + 1, -kInfinity);
  by_size_[0] = 0;
  if (parts >= 1) by_size_[1] = 0;
  for (std::size_t n = 2; n <= parts; ++n) {
    // Row n of the triangle begins at floor((n - 1)^2 / 4) and has floor(n / 2) entries.
    for (std::size_t a = 1; a <= n / 2; ++a) {
      gains_.push_back(a > most_moved_ ? -kInfinity : expander.greatest_gain(a, n - a));
      by_size_[n] = std::max(by_size_[n], gains_.back() + by_size_[a] + by_size_[n - a]);
    }
  }
  // A limit under which some size cannot be cut at all is left to the searches.
  sizes_known_ = std::ranges::all_of(by_size_, [](double best) { return std::isfinite(best); });
  if (has_units()) measure_last(system, expander);
  if (sizes_known_ && has_units()) measure_excess();
  if (sizes_known_ && parts <= kMostPartsWithArms) measure_arms(problem);
}

void PieceGains::measure_last(const TransitionSystem& system, Expander& expander) {
  std::vector<std::size_t> size(unit_.size(), 0);
  for (const PartIndex unit : unit_) ++size[unit];
  surplus_without_cut_ = surplus_of_cut_ = -kInfinity;
  for_each_connection(system.start().view(), [&](ConnectionIndex c) {
    const auto& ends = system.problem().ends(c);
    const std::array<PartIndex, 2> units = {unit_[ends[0]], unit_[ends[1]]};
    const double more = expander.completion_surplus(c);
    if (units[0] == units[1]) {
      surplus_without_cut_ = std::max(surplus_without_cut_, more);
      return;
    }
    const auto [smaller, larger] = std::minmax(size[units[0]], size[units[1]]);
    const auto [place, is_new] = surplus_.try_emplace({smaller, larger}, more);
    if (!is_new) place->second = std::max(place->second, more);
    surplus_of_cut_ = std::max(surplus_of_cut_, more);
  });
}

void PieceGains::measure_excess() {
  constexpr double kMostWork = 1e8;
  const std::size_t parts = merged_.size();
  const auto most = static_cast<std::size_t>(std::ranges::count(merged_, 1));
  const double work = static_cast<double>(parts * most) * static_cast<double>(parts * most) / 8;
  if (work > kMostWork) {
    sizes_known_ = false;
    return;
  }
  for (std::size_t d = 0; d <= most; ++d) {
    if (d > 0) {
      by_excess_.emplace_back(parts + 1, -kInfinity);
      by_excess_.back()[d + 1] = 0;
    }
    std::vector<double>& best = d == 0 ? by_size_ : by_excess_.back();
    std::vector<double>& last = last_by_excess_.emplace_back(parts + 1, -kInfinity);
    for (const auto& [units, more] : surplus_) {
      const std::size_t n = units[0] + units[1];
      if (n == d + 2) last[n] = std::max(last[n], gain(units[0], units[1]) + more);
    }
    for (std::size_t n = d + 2; n <= parts; ++n) {
      for (std::size_t a = 1; a <= n / 2; ++a) {
        const std::size_t b = n - a;
        const double cut = gain(a, b);
        if (cut == -kInfinity) continue;
        const std::size_t first = d + 1 > b ? d + 1 - b : 0;  // what b cannot hold
        for (std::size_t i = first; i < a && i <= d; ++i) {
          const double left = by_size(a, i);
          const double right = by_size(b, d - i);
          best[n] = std::max(best[n], cut + left + right);
          last[n] = std::max(
              last[n], cut + std::max(last_by_size(a, i) + right, left + last_by_size(b, d - i)));
        }
      }
    }
    // As for single parts: a size that no limit allows to cut is left to the searches.
    for (std::size_t n = d + 1; n <= parts; ++n)
      sizes_known_ = sizes_known_ && std::isfinite(best[n]);
  }
}

namespace {

/// A number for a set of up to three parts (kMaxParts is 2^14), whatever their order.
std::uint64_t small_key(std::span<const PartIndex> piece) {
  const auto [least, greatest] = std::ranges::minmax(piece);
  const std::uint64_t between =
      std::accumulate(piece.begin(), piece.end(), std::uint64_t{0}) - least - greatest;
  const std::uint64_t key = ((piece.size() << 20U | least) << 20U | greatest) << 20U | between;
  return key;
}

/// Calls visit(std::span<const PartIndex>) for connected sets of one, two and three parts up to
/// `largest`; some more than once.
template <class Visit>
void for_each_small_set(const detail::AssemblyGraph& graph, std::size_t largest, Visit&& visit) {
  std::array<PartIndex, 3> set{};
  for (PartIndex u = 0; u < graph.num_parts(); ++u) {
    set[0] = u;
    visit(std::span<const PartIndex>(set.data(), 1));
    if (largest < 2) continue;
    for (const auto& first : graph.around(u)) {
      set[1] = first.other;
      visit(std::span<const PartIndex>(set.data(), 2));
      if (largest < 3) continue;
      for (const PartIndex from : {u, first.other}) {
        for (const auto& second : graph.around(from)) {
          if (second.other == u || second.other == first.other) continue;
          set[2] = second.other;
          visit(std::span<const PartIndex>(set));
        }
      }
    }
  }
}

}  // namespace

void PieceGains::measure_parts(Expander& expander, const Problem& problem) {
  // Only where what a cut gains is told from what it moves; moved pieces are listed as long as they
  // are small.
  constexpr std::size_t kMostMoved = 3;
  const std::size_t parts = problem.num_parts();
  prices_.assign(parts, -kInfinity);
  if (parts == 0) return;
  const PartIndex first = 0;
  if (!std::isfinite(expander.greatest_gain_of_moving({&first, 1}))) return;
  const detail::AssemblyGraph graph(problem);
  const std::size_t most = expander.moving_more_costs_more() ? 1 : std::min(most_moved_, parts / 2);
  for_each_small_set(graph, std::min(most, kMostMoved), [&](std::span<const PartIndex> moved) {
    const double gain = expander.greatest_gain_of_moving(moved);
    for (const PartIndex part : moved) prices_[part] = std::max(prices_[part], gain);
  });
  if (most > kMostMoved) {
    // What larger moved pieces gain at most, whatever they are.
    double larger = -kInfinity;
    for (std::size_t a = kMostMoved + 1; a <= most; ++a) {
      for (std::size_t b = a; a + b <= parts; ++b) larger = std::max(larger, gain(a, b));
    }
    for (double& price : prices_) price = std::max(price, larger);
  } else if (most > 1 && !has_units()) {
    lower_prices(expander, problem, graph);
  }
  parts_known_ = std::ranges::all_of(prices_, [](double price) { return std::isfinite(price); });
  if (!has_units()) return;
  for (PartIndex part = 0; part < parts; ++part)
    prices_[unit_[part]] = std::min(prices_[unit_[part]], prices_[part]);
}

void PieceGains::lower_prices(Expander& expander, const Problem& problem,
                              const detail::AssemblyGraph& graph) {
  constexpr std::size_t kMostSets = 100'000;
  struct Moved {
    std::array<PartIndex, 3> parts;
    std::size_t size;
    double worth;  ///< w
  };
  std::vector<Moved> sets;
  // The value of a piece of two or three parts by its own cuts; singles are worth nothing. A cut
  // that blocking forbids is counted all the same: the bound stays finite, and the searches find
  // the dead end.
  const auto moved_gain = [&](PartIndex u, PartIndex v) {
    return std::max(expander.greatest_gain_of_moving({&u, 1}),
                    expander.greatest_gain_of_moving({&v, 1}));
  };
  const auto pair_value = [&](PartIndex u, PartIndex v) {
    double best = -kInfinity;
    for (const auto& half : graph.around(u)) {
      if (half.other != v) continue;
      const bool u_is_a = problem.ends(half.connection)[0] == u;
      const auto gain = u_is_a ? expander.cut_gain({&u, 1}, {&v, 1}, half.connection)
                               : expander.cut_gain({&v, 1}, {&u, 1}, half.connection);
      best = std::max(best, gain ? *gain : moved_gain(u, v));
    }
    return best;
  };
  const auto triple_value = [&](std::span<const PartIndex> piece) {
    double best = -kInfinity;
    for (std::size_t i = 0; i < 3; ++i) {
      const PartIndex alone = piece[i];
      const std::array<PartIndex, 2> others = {piece[(i + 1) % 3], piece[(i + 2) % 3]};
      const double rest = pair_value(others[0], others[1]);
      if (rest == -kInfinity) continue;  // not connected
      for (const auto& half : graph.around(alone)) {
        if (half.other != others[0] && half.other != others[1]) continue;
        const bool alone_is_a = problem.ends(half.connection)[0] == alone;
        const auto gain = alone_is_a ? expander.cut_gain({&alone, 1}, others, half.connection)
                                     : expander.cut_gain(others, {&alone, 1}, half.connection);
        best =
            std::max(best, (gain ? *gain : expander.greatest_gain_of_moving({&alone, 1})) + rest);
      }
    }
    return best;
  };
  // Pieces of three parts need their value even where only two may move.
  bool few = true;
  for_each_small_set(graph, 3, [&](std::span<const PartIndex> piece) {
    if (!few) return;
    double value = 0;
    if (piece.size() > 1) {
      const auto [place, is_new] = small_.try_emplace(small_key(piece), 0);
      if (!is_new) return;
      value = piece.size() == 2 ? pair_value(piece[0], piece[1]) : triple_value(piece);
      place->second = value;
    }
    if (piece.size() > most_moved_) return;
    Moved& moved = sets.emplace_back();
    std::ranges::copy(piece, moved.parts.begin());
    moved.size = piece.size();
    moved.worth = expander.greatest_gain_of_moving(piece) + value;
    few = sets.size() < kMostSets;
  });
  if (!few) {
    small_.clear();
    return;
  }

  const auto worth_left = [](const Moved& moved, const std::vector<double>& prices) {
    double left = moved.worth;
    for (std::size_t i = 0; i < moved.size; ++i) left -= prices[moved.parts[i]];
    return left;
  };
  std::vector<std::vector<std::uint32_t>> with(prices_.size());
  for (std::uint32_t s = 0; s < sets.size(); ++s) {
    for (std::size_t i = 0; i < sets[s].size; ++i) with[sets[s].parts[i]].push_back(s);
  }
  const auto total = [](const std::vector<double>& prices) {
    double sum = 0;
    double least = 0;
    for (const double price : prices) {
      sum += price;
      least = std::min(least, price);
    }
    return sum - least;
  };
  // Makes prices valid, then as low as each can be on its own.
  const auto repaired = [&](std::vector<double> prices) {
    for (const Moved& moved : sets) {
      const double left = worth_left(moved, prices);
      if (left <= 0) continue;
      for (std::size_t i = 0; i < moved.size; ++i)
        prices[moved.parts[i]] += left / static_cast<double>(moved.size);
    }
    for (PartIndex part = 0; part < prices.size(); ++part) {
      double slack = kInfinity;
      for (const std::uint32_t s : with[part])
        slack = std::min(slack, 0.0 - worth_left(sets[s], prices));
      if (slack > 0 && std::isfinite(slack)) prices[part] -= slack;
    }
    return prices;
  };
  std::vector<double> best(prices_.size(), -kInfinity);
  for (const Moved& moved : sets) {
    for (std::size_t i = 0; i < moved.size; ++i) {
      double& price = best[moved.parts[i]];
      price = std::max(price, moved.worth / static_cast<double>(moved.size));
    }
  }
  std::vector<double> prices = best;
  best = repaired(best);
  double scale = 0;
  for (const double price : prices) scale += std::abs(price) / static_cast<double>(prices.size());
  std::vector<double> slope(prices.size());
  // 2,000 iterations are as good as 20,000 on a grid of 100 parts; with many sets fewer, for half a
  // second at most.
  const int iterations = static_cast<int>(
      std::clamp<std::size_t>(20'000'000 / std::max<std::size_t>(sets.size(), 1), 200, 2000));
  for (int iteration = 0; iteration < iterations; ++iteration) {
    std::ranges::fill(slope, 1.0);
    for (const Moved& moved : sets) {
      if (worth_left(moved, prices) <= 0) continue;
      for (std::size_t i = 0; i < moved.size; ++i) slope[moved.parts[i]] -= 1;
    }
    const double step = 0.02 * scale / (1 + 0.02 * iteration);
    for (std::size_t p = 0; p < prices.size(); ++p) prices[p] -= step * slope[p];
    if (iteration % 50 != 49) continue;
    std::vector<double> valid = repaired(prices);
    if (total(valid) < total(best)) best = std::move(valid);
  }
  prices_ = std::move(best);
}

double PieceGains::by_parts(std::span<const PartIndex> piece) const {
  if (piece.size() == 1) return 0;
  if (!small_.empty() && piece.size() <= 3) {
    const auto found = small_.find(small_key(piece));
    return found == small_.end() ? -kInfinity : found->second;
  }
  double sum = 0;
  double least = kInfinity;
  for (const PartIndex part : piece) {
    if (has_units() && merged_[part] != 0) continue;
    sum += prices_[part];
    least = std::min(least, prices_[part]);
  }
  return sum - least;
}

// -------------------------------------------------------------------------------------------------

struct PieceBound::Scratch {
  Scratch(const TransitionSystem& system, bool lists)
      : graph(system.problem()),
        connectivity(graph, lists),
        kept(system.kept()),
        keeps(!kept.empty()),
        words(system.words()) {}
  detail::AssemblyGraph graph;
  detail::Connectivity connectivity;
  std::vector<PartIndex> piece;
  ConnectionSet kept;
  bool keeps;
  std::vector<std::uint64_t> words;
  // Of the pieces of a state, with units.
  std::vector<double> gains;
  std::vector<double> surpluses;  ///< what the last step of all adds, were it the piece's last cut
  std::vector<std::size_t> piece_of;  ///< by part

  /// In disassembly.
  [[nodiscard]] SetView present(SetView open) {
    if (!keeps) return open;
    std::ranges::transform(open, kept.view(), words.begin(), std::bit_or());
    return words;
  }
};

PieceBound::PieceBound(const TransitionSystem& system, Kind kind) : gains_(system) {
  sizes_ = kind != Kind::Parts && gains_.known() && gains_.sizes_known();
  parts_ = kind != Kind::Sizes && gains_.known() && gains_.parts_known();
  known_ = sizes_ || parts_;
  if (known_) scratch_ = std::make_unique<Scratch>(system, parts_ || gains_.has_units());
}

PieceBound::~PieceBound() = default;

double PieceBound::of_piece(std::span<const PartIndex> piece) const {
  double bound = kInfinity;
  if (sizes_) bound = gains_.by_size(piece.size(), gains_.excess(piece));
  if (parts_) bound = std::min(bound, gains_.by_parts(piece));
  return bound;
}

// The same for the piece whose last cut completes.
double PieceBound::of_last_piece(std::span<const PartIndex> piece) const {
  const std::size_t excess = gains_.excess(piece);
  if (excess + 1 == piece.size()) return -kInfinity;
  double bound = kInfinity;
  if (sizes_) bound = gains_.last_by_size(piece.size(), excess);
  if (parts_) bound = std::min(bound, gains_.by_parts(piece) + gains_.surplus_of_cut());
  return bound;
}

// Looks at each piece of a state: what its cuts gain, and how much more if the last step of all is
// its last cut. Returns the sum of the former.
double PieceBound::measure_units(SetView open) {
  Scratch& s = *scratch_;
  double sum = 0;
  s.gains.clear();
  s.surpluses.clear();
  s.piece_of.resize(s.graph.num_parts());
  s.graph.for_each_piece(s.present(open), [&](std::span<const PartIndex> piece) {
    for (const PartIndex part : piece) s.piece_of[part] = s.gains.size();
    s.gains.push_back(of_piece(piece));
    s.surpluses.push_back(of_last_piece(piece) - s.gains.back());
    sum += s.gains.back();
  });
  return sum;
}

void PieceBound::of_successors_with_units(SetView open, double here,
                                          std::span<const Action> actions,
                                          std::span<double> bounds) {
  Scratch& s = *scratch_;
  measure_units(open);
  s.connectivity.analyse(s.present(open), false);
  // The greatest surplus of all pieces, and of all but one.
  const auto greatest_but = [&](std::size_t piece) {
    double greatest = gains_.surplus_without_cut();
    for (std::size_t p = 0; p < s.surpluses.size(); ++p) {
      if (p != piece) greatest = std::max(greatest, s.surpluses[p]);
    }
    return greatest;
  };
  const auto best =
      static_cast<std::size_t>(std::ranges::max_element(s.surpluses) - s.surpluses.begin());
  const double others = greatest_but(best);
  const double greatest = std::max(others, s.surpluses[best]);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    bounds[i] = here - gains_.own(c);
    const std::uint32_t a = s.connectivity.below(c);
    if (a == 0) continue;
    s.piece.clear();
    s.connectivity.lower_side(c).for_each([&](PartIndex part) { s.piece.push_back(part); });
    s.connectivity.upper_side(c).for_each([&](PartIndex part) { s.piece.push_back(part); });
    const std::span<const PartIndex> all(s.piece);
    const std::size_t whole = s.piece_of[all.front()];
    const double first = of_piece(all.first(a));
    const double second = of_piece(all.subspan(a));
    const double now =
        std::max({whole == best ? others : greatest, of_last_piece(all.first(a)) - first,
                  of_last_piece(all.subspan(a)) - second});
    bounds[i] += first + second - s.gains[whole] + now - greatest;
  }
}

double PieceBound::operator()(SetView open) {
  if (!known_) return kInfinity;
  double sum = 0;
  bool goal = true;
  for_each_connection(open, [&](ConnectionIndex c) {
    sum += gains_.own(c);
    goal = false;
  });
  if (goal) return 0;
  if (gains_.has_units()) {
    sum += measure_units(open);
    return sum +
           std::max(gains_.surplus_without_cut(), *std::ranges::max_element(scratch_->surpluses));
  }
  scratch_->graph.for_each_piece(open,
                                 [&](std::span<const PartIndex> piece) { sum += of_piece(piece); });
  return sum + gains_.last_surplus();
}

void PieceBound::of_successors(SetView open, double here, std::span<const Action> actions,
                               std::span<double> bounds) {
  if (count(open) == 1) {
    std::ranges::fill(bounds, 0.0);
    return;
  }
  if (gains_.has_units()) {
    of_successors_with_units(open, here, actions, bounds);
    return;
  }
  detail::Connectivity& connectivity = scratch_->connectivity;
  connectivity.analyse(open, false);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    bounds[i] = here - gains_.own(c);
    const std::uint32_t a = connectivity.below(c);
    if (a == 0) continue;
    const std::uint32_t n = connectivity.piece(c);
    if (!parts_) {
      bounds[i] += gains_.by_size(a) + gains_.by_size(n - a) - gains_.by_size(n);
      continue;
    }
    std::vector<PartIndex>& piece = scratch_->piece;
    piece.clear();
    connectivity.lower_side(c).for_each([&](PartIndex part) { piece.push_back(part); });
    connectivity.upper_side(c).for_each([&](PartIndex part) { piece.push_back(part); });
    const std::span<const PartIndex> all(piece);
    bounds[i] += of_piece(all.first(a)) + of_piece(all.subspan(a)) - of_piece(all);
  }
}

void PieceBound::add_change(SetView open, std::span<Action> actions) {
  if (actions.empty()) return;
  if (count(open) == 1) {
    actions.front().reward -= (*this)(open);
    return;
  }
  changes_.resize(actions.size());
  of_successors(open, 0, actions, changes_);
  for (std::size_t i = 0; i < actions.size(); ++i) actions[i].reward += changes_[i];
}

// -------------------------------------------------------------------------------------------------

namespace {

/// The paper's: no step earns more than 0. Here the last one may.
class ZeroBound final : public Bound {
 public:
  explicit ZeroBound(const TransitionSystem& system) {
    const std::size_t connections = system.num_connections();
    for (ConnectionIndex c = 0; c < connections; ++c) {
      known_ = known_ && system.reward_range(c, connections, false).greatest <= 0;
      last_ = std::max(last_, system.reward_range(c, connections, true).greatest);
    }
    known_ = known_ && std::isfinite(last_);
  }
  [[nodiscard]] bool known() const override { return known_; }
  [[nodiscard]] double operator()(SetView open) override {
    if (!known_) return kInfinity;
    return count(open) == 0 ? 0 : last_;
  }
  void of_successors(SetView open, double here, std::span<const Action>,
                     std::span<double> bounds) override {
    std::ranges::fill(bounds, count(open) == 1 ? 0 : here);
  }

 private:
  bool known_ = true;
  double last_ = 0;
};

}  // namespace

BoundKind bound_called(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kBoundNames.size(); ++i) {
    if (kBoundNames[i] == name) return static_cast<BoundKind>(i);
    known += (known.empty() ? "" : ", ") + std::string(kBoundNames[i]);
  }
  throw InputError("unknown bound '" + std::string(name) + "'; known: " + known);
}

std::unique_ptr<Bound> make_bound(const TransitionSystem& system, BoundKind kind) {
  switch (kind) {
    case BoundKind::None: return std::make_unique<ZeroBound>(system);
    case BoundKind::Connections: return std::make_unique<ConnectionBound>(system);
    case BoundKind::Sizes: return std::make_unique<PieceBound>(system, PieceBound::Kind::Sizes);
    case BoundKind::Parts: return std::make_unique<PieceBound>(system, PieceBound::Kind::Parts);
    case BoundKind::Best: break;
  }
  auto pieces = std::make_unique<PieceBound>(system, PieceBound::Kind::Both);
  if (pieces->known()) return pieces;
  return std::make_unique<ConnectionBound>(system);
}

}  // namespace orasp
