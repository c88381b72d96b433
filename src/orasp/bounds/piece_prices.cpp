#include "orasp/bounds/piece_prices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/tolerance.h"

namespace orasp {

namespace {

/// Moved pieces are listed one by one up to this many parts.
constexpr std::size_t kMostListed = 3;

/// A number for a set of up to three parts, whatever their order. A part needs 14 bits (kMaxParts).
std::uint64_t small_key(std::span<const PartIndex> piece) {
  const auto [least, greatest] = std::ranges::minmax(piece);
  const std::uint64_t between =
      std::accumulate(piece.begin(), piece.end(), std::uint64_t{0}) - least - greatest;
  const std::uint64_t key = ((piece.size() << 20U | least) << 20U | greatest) << 20U | between;
  return key;
}

/// Calls visit(std::span<const PartIndex>) for the connected sets of one, two and three parts, of
/// at most `largest` parts. Some sets are visited more than once.
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

/// A connected set M of parts that a cut may move.
struct MovedSet {
  std::array<PartIndex, kMostListed> parts;
  std::size_t size;
  /// What moving the set gains, and what the set gains on its own from there on: w(M).
  double worth;
};

/// Works out what the cuts of pieces of two and three parts gain exactly, above what connections
/// cost (CutTrees). A cut that blocking forbids is counted all the same: so the bound stays finite,
/// and the searches find the dead end.
class SmallPieceValues {
 public:
  SmallPieceValues(Expander& expander, const Problem& problem, const detail::AssemblyGraph& graph)
      : expander_(expander),
        problem_(problem),
        graph_(graph),
        costs_(expander.least_extra_costs()) {}

  [[nodiscard]] double of(std::span<const PartIndex> piece) {
    return piece.size() == 2 ? of_pair(piece[0], piece[1]) : of_triple(piece);
  }

 private:
  [[nodiscard]] double gain_of_moving(PartIndex part) {
    return expander_.greatest_gain_of_moving({&part, 1});
  }

  /// -infinity where no connection joins the two parts.
  [[nodiscard]] double of_pair(PartIndex u, PartIndex v) {
    double best = -kInfinity;
    for (const auto& half : graph_.around(u)) {
      if (half.other != v) continue;
      const bool u_is_a = problem_.ends(half.connection)[0] == u;
      const auto gain = u_is_a ? expander_.cut_gain({&u, 1}, {&v, 1}, half.connection)
                               : expander_.cut_gain({&v, 1}, {&u, 1}, half.connection);
      best = std::max(best, gain ? *gain + costs_[half.connection]
                                 : std::max(gain_of_moving(u), gain_of_moving(v)));
    }
    return best;
  }

  /// One part is cut off first, then the other two come apart.
  [[nodiscard]] double of_triple(std::span<const PartIndex> piece) {
    double best = -kInfinity;
    for (std::size_t i = 0; i < 3; ++i) {
      const PartIndex alone = piece[i];
      const std::array<PartIndex, 2> others = {piece[(i + 1) % 3], piece[(i + 2) % 3]};
      const double rest = of_pair(others[0], others[1]);
      const bool others_are_connected = rest != -kInfinity;
      if (!others_are_connected) continue;
      for (const auto& half : graph_.around(alone)) {
        if (half.other != others[0] && half.other != others[1]) continue;
        const bool alone_is_a = problem_.ends(half.connection)[0] == alone;
        const auto gain = alone_is_a ? expander_.cut_gain({&alone, 1}, others, half.connection)
                                     : expander_.cut_gain(others, {&alone, 1}, half.connection);
        best =
            std::max(best, (gain ? *gain + costs_[half.connection] : gain_of_moving(alone)) + rest);
      }
    }
    return best;
  }

  Expander& expander_;
  const Problem& problem_;
  const detail::AssemblyGraph& graph_;
  std::vector<double> costs_;
};

/// Lists all sets of at most `most_moved` parts that a cut may move, and writes the exact values of
/// pieces of two and three parts to `values`. Returns nothing where there are too many sets.
std::optional<std::vector<MovedSet>> list_moved_sets(
    Expander& expander, const Problem& problem, const detail::AssemblyGraph& graph,
    std::size_t most_moved, std::unordered_map<std::uint64_t, double>& values) {
  constexpr std::size_t kMostSets = 100'000;
  SmallPieceValues value_of(expander, problem, graph);
  std::vector<MovedSet> sets;
  bool few = true;
  // Pieces of three parts need their value even where only two parts may move.
  for_each_small_set(graph, kMostListed, [&](std::span<const PartIndex> piece) {
    if (!few) return;
    double value = 0;
    if (piece.size() > 1) {
      const auto [place, is_new] = values.try_emplace(small_key(piece), 0);
      if (!is_new) return;
      value = value_of.of(piece);
      place->second = value;
    }
    if (piece.size() > most_moved) return;
    MovedSet& moved = sets.emplace_back();
    std::ranges::copy(piece, moved.parts.begin());
    moved.size = piece.size();
    moved.worth = expander.greatest_gain_of_moving(piece) + value;
    few = sets.size() < kMostSets;
  });
  if (!few) return std::nullopt;
  return sets;
}

/// Looks for the least prices of parts under which the prices of each set add up to its worth or
/// more.
class CoveringPrices {
 public:
  using Prices = std::vector<double>;

  CoveringPrices(std::vector<MovedSet> sets, std::size_t parts)
      : sets_(std::move(sets)), sets_with_(parts) {
    for (std::uint32_t s = 0; s < sets_.size(); ++s) {
      for (std::size_t i = 0; i < sets_[s].size; ++i) sets_with_[sets_[s].parts[i]].push_back(s);
    }
  }

  /// Valid prices that a subgradient method has made low.
  [[nodiscard]] Prices find() const {
    Prices prices = even_prices();
    Prices best = repaired(prices);
    double scale = 0;
    for (const double price : prices) scale += std::abs(price) / static_cast<double>(prices.size());
    // 2,000 iterations are as good as 20,000 on a grid of 100 parts; with many sets fewer, for half
    // a second at most.
    const int iterations = static_cast<int>(
        std::clamp<std::size_t>(20'000'000 / std::max<std::size_t>(sets_.size(), 1), 200, 2000));
    constexpr int kIterationsBetweenRepairs = 50;
    for (int iteration = 0; iteration < iterations; ++iteration) {
      step_down(prices, 0.02 * scale / (1 + 0.02 * iteration));
      if (iteration % kIterationsBetweenRepairs != kIterationsBetweenRepairs - 1) continue;
      Prices valid = repaired(prices);
      if (bound_of_all(valid) < bound_of_all(best)) best = std::move(valid);
    }
    return best;
  }

 private:
  /// Each set gives every one of its parts the same share of its worth; a part takes the greatest.
  [[nodiscard]] Prices even_prices() const {
    Prices prices(sets_with_.size(), -kInfinity);
    for (const MovedSet& moved : sets_) {
      for (std::size_t i = 0; i < moved.size; ++i) {
        double& price = prices[moved.parts[i]];
        price = std::max(price, moved.worth / static_cast<double>(moved.size));
      }
    }
    return prices;
  }

  /// What the worth of a set exceeds its prices by; the prices are valid where this is 0 or less.
  [[nodiscard]] static double uncovered(const MovedSet& moved, const Prices& prices) {
    double left = moved.worth;
    for (std::size_t i = 0; i < moved.size; ++i) left -= prices[moved.parts[i]];
    return left;
  }

  /// Moves all prices against the subgradient: down, but up for the parts of sets that are not
  /// covered.
  void step_down(Prices& prices, double step) const {
    std::vector<double> slope(prices.size(), 1.0);
    for (const MovedSet& moved : sets_) {
      if (uncovered(moved, prices) <= 0) continue;
      for (std::size_t i = 0; i < moved.size; ++i) slope[moved.parts[i]] -= 1;
    }
    for (std::size_t p = 0; p < prices.size(); ++p) prices[p] -= step * slope[p];
  }

  /// The prices made valid, and then each, one after the other, as low as the others let it be.
  [[nodiscard]] Prices repaired(Prices prices) const {
    for (const MovedSet& moved : sets_) {
      const double left = uncovered(moved, prices);
      if (left <= 0) continue;
      for (std::size_t i = 0; i < moved.size; ++i)
        prices[moved.parts[i]] += left / static_cast<double>(moved.size);
    }
    for (PartIndex part = 0; part < prices.size(); ++part) {
      double slack = kInfinity;
      for (const std::uint32_t s : sets_with_[part])
        slack = std::min(slack, 0.0 - uncovered(sets_[s], prices));
      if (slack > 0 && std::isfinite(slack)) prices[part] -= slack;
    }
    return prices;
  }

  /// The bound of the piece of all parts.
  [[nodiscard]] static double bound_of_all(const Prices& prices) {
    double sum = 0;
    double least = 0;
    for (const double price : prices) {
      sum += price;
      least = std::min(least, price);
    }
    return sum - least;
  }

  std::vector<MovedSet> sets_;
  /// The sets that hold each part.
  std::vector<std::vector<std::uint32_t>> sets_with_;
};

/// Whether no cut gains more than 0.
bool no_cut_gains(const PiecePrices::GainBySizes& gain, std::size_t parts) {
  for (std::size_t n = 2; n <= parts; ++n) {
    for (std::size_t a = 1; a <= n / 2; ++a) {
      if (!(gain(a, n - a) <= 0)) return false;
    }
  }
  return true;
}

}  // namespace

PiecePrices::PiecePrices(const TransitionSystem& system, Expander& expander, const PartUnits& units,
                         std::size_t most_moved, const GainBySizes& gain,
                         const ListingEffort& effort) {
  const Problem& problem = system.problem();
  const std::size_t parts = problem.num_parts();
  prices_.assign(parts, -kInfinity);
  if (parts == 0) return;
  const PartIndex first = 0;
  const bool gain_is_told_by_what_moves =
      std::isfinite(expander.greatest_gain_of_moving({&first, 1}));
  if (!gain_is_told_by_what_moves) return;
  const detail::AssemblyGraph graph(problem);
  // What moves is the smaller side, unless that is fixed.
  const std::size_t least_most = problem.base().empty() ? parts / 2 : parts - 1;
  const std::size_t most = expander.moving_more_costs_more() ? 1 : std::min(most_moved, least_most);
  for_each_small_set(graph, std::min(most, kMostListed), [&](std::span<const PartIndex> moved) {
    const double gained = expander.greatest_gain_of_moving(moved);
    for (const PartIndex part : moved) prices_[part] = std::max(prices_[part], gained);
  });
  if (most > kMostListed) {
    // Larger moved pieces are too many to list: what they gain at most is told from their sizes.
    const LargerMoves moves = LargerMoves::of(system, most, gain);
    const double larger = moves.gain(kMostListed);
    for (double& price : prices_) price = std::max(price, larger);
    if (!units.any() && no_cut_gains(gain, parts))
      pieces_ = SmallPieces(system, expander, SmallPieces::kMostListed, moves, effort);
  } else if (most > 1 && !units.any()) {
    if (auto sets = list_moved_sets(expander, problem, graph, most_moved, small_)) {
      prices_ = CoveringPrices(std::move(*sets), parts).find();
    } else {
      small_.clear();
    }
  }
  known_ = std::ranges::all_of(prices_, [](double price) { return std::isfinite(price); });
  if (const auto most_mass = problem.limits().max_moved_mass) {
    stays_.assign(parts, 0);
    for (PartIndex part = 0; part < parts; ++part) {
      const bool too_heavy = problem.parts()[part].mass > *most_mass * (1 + kRelativeTolerance);
      if (too_heavy) stays_[units.any() ? units.first_of(part) : part] = 1;
    }
  }
  if (!problem.base().empty()) {
    fixed_.assign(parts, 0);
    for (PartIndex part = 0; part < parts; ++part) {
      if (problem.in_base(part)) fixed_[units.any() ? units.first_of(part) : part] = 1;
    }
  }
  if (!units.any()) return;
  // A unit pays once, so it pays the least price of its parts.
  for (PartIndex part = 0; part < parts; ++part) {
    double& price = prices_[units.first_of(part)];
    price = std::min(price, prices_[part]);
  }
}

double PiecePrices::bound(std::span<const PartIndex> piece, const PartUnits& units) const {
  if (piece.size() == 1) return 0;
  // Both bounds satisfy the inequality that makes them consistent, and so does the smaller of them.
  double known = pieces_.known() ? pieces_.bound(piece) : kInfinity;
  if (!small_.empty() && piece.size() <= kMostListed) {
    const auto found = small_.find(small_key(piece));
    known = found == small_.end() ? -kInfinity : found->second;
    if (stays_.empty() && fixed_.empty()) return known;
  }
  double sum = 0;
  double least = kInfinity;
  std::optional<double> of_what_stays;
  bool is_fixed = false;
  for (const PartIndex part : piece) {
    if (units.merged(part)) continue;
    if (!fixed_.empty() && fixed_[part] != 0) {
      is_fixed = true;
      continue;
    }
    sum += prices_[part];
    least = std::min(least, prices_[part]);
    if (!stays_.empty() && stays_[part] != 0)
      of_what_stays = std::min(of_what_stays.value_or(kInfinity), prices_[part]);
  }
  if (is_fixed) return std::min(known, sum);
  if (of_what_stays) return std::min(known, sum - *of_what_stays);
  return std::min(known, sum - least);
}

}  // namespace orasp
