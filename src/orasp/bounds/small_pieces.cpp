#include "orasp/bounds/small_pieces.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "orasp/bounds/packed_costs.h"
#include "orasp/bounds/partings.h"
#include "orasp/containers/parallel.h"
#include "orasp/model/detail/connectivity.h"
#include "orasp/model/tolerance.h"

namespace orasp {

namespace {

/// For each set that may be listed, so many ways to part a set in two, over all sets.
constexpr std::size_t kCutsPerSet = 300;
/// Where larger sets are too many, prices with those up to an odd number of parts, this or more,
/// are worked out without the largest ones too.
constexpr std::size_t kLeastOddTriedTwice = 7;

}  // namespace

LargerMoves LargerMoves::of(const TransitionSystem& system, std::size_t most,
                            GainBySizes by_sizes) {
  const std::size_t parts = system.problem().num_parts();
  // What moves is the smaller side, unless that is fixed.
  const bool either_moves = !system.problem().base().empty();
  LargerMoves moves;
  moves.gain = [=, by_sizes = std::move(by_sizes)](std::size_t listed) {
    double greatest = -kInfinity;
    for (std::size_t moved = listed + 1; moved <= most; ++moved) {
      for (std::size_t kept = either_moves ? 1 : moved; moved + kept <= parts; ++kept)
        greatest = std::max(greatest, by_sizes(std::min(moved, kept), std::max(moved, kept)));
    }
    return greatest;
  };
  moves.gain_with = [&system, most](std::span<const PartIndex> moved, std::size_t listed,
                                    double low_enough) {
    return system.greatest_gain_of_moving_with(moved, listed + 1, most, low_enough);
  };
  return moves;
}

SmallPieces::Key SmallPieces::key_of(std::span<const PartIndex> sorted) {
  Key key{};
  for (std::size_t i = 0; i < sorted.size(); ++i)
    key[i / 4] = key[i / 4] << 16U | (static_cast<std::uint64_t>(sorted[i]) + 1);
  return key;
}

void SmallPieces::KeyIndex::fill(std::size_t slots) {
  slots_.assign(slots, 0);
  for (std::uint32_t number = 0; number < keys_.size(); ++number) {
    std::size_t i = hash(keys_[number]) & (slots - 1);
    while (slots_[i] != 0) i = (i + 1) & (slots - 1);
    slots_[i] = number + 1;
  }
}

auto SmallPieces::KeyIndex::insert(const Key& key) -> Inserted {
  if (2 * keys_.size() >= slots_.size()) fill(std::max<std::size_t>(64, 2 * slots_.size()));
  std::size_t i = hash(key) & (slots_.size() - 1);
  for (; slots_[i] != 0; i = (i + 1) & (slots_.size() - 1)) {
    if (same(keys_[slots_[i] - 1], key)) return {slots_[i] - 1, false};
  }
  keys_.push_back(key);
  slots_[i] = static_cast<std::uint32_t>(keys_.size());
  return {slots_[i] - 1, true};
}

std::uint32_t SmallPieces::KeyIndex::find(const Key& key) const {
  if (slots_.empty()) return kAbsent;
  for (std::size_t i = hash(key) & (slots_.size() - 1); slots_[i] != 0;
       i = (i + 1) & (slots_.size() - 1)) {
    if (same(keys_[slots_[i] - 1], key)) return slots_[i] - 1;
  }
  return kAbsent;
}

void SmallPieces::KeyIndex::shrink(std::size_t size) {
  keys_.resize(size);
  fill(slots_.size());
}

/// Lists the connected sets, smaller ones first, and works out the value of each.
class SmallPieces::Lister {
 public:
  /// A connected set of parts, in rising order.
  struct ListedSet {
    std::array<PartIndex, SmallPieces::kMostListed> parts;
    std::size_t size;
    /// V, the most that the cuts of the set gain.
    double value;
    /// The most that moving it gains.
    double moving;
    /// What its parts may cost together, minus their prices, is at most this.
    double room;
    /// What it may owe where it stays of a larger piece.
    double owed = 0;
    /// What its parts reserve together.
    double reserved;
    /// The two sets that make it up whose rooms are the least together, without reserves.
    /// The same number twice where neither matters.
    std::array<std::uint32_t, 2> made_of;
    bool fixed;
    /// Whether it may come off a piece that is not listed, for all that is known; and whether that
    /// was asked.
    bool may_leave = true;
    bool asked = false;

    [[nodiscard]] std::span<const PartIndex> all() const { return {parts.data(), size}; }
  };

  Lister(const TransitionSystem& system, Expander& expander, const ListingEffort& effort)
      : partings_(Partings::of(system)),
        expander_(expander),
        problem_(system.problem()),
        effort_(effort),
        by_connection_(system.gain_by_connection()),
        graph_(problem_),
        costs_(expander.least_extra_costs()) {}
  /// What `other` has listed, of at most `largest` parts. Only before measure().
  Lister(const Lister& other, Expander& expander, std::size_t largest)
      : partings_(other.partings_),
        expander_(expander),
        problem_(other.problem_),
        effort_(other.effort_),
        by_connection_(other.by_connection_),
        graph_(other.graph_),
        costs_(other.costs_),
        sets_(other.sets_.begin(),
              std::ranges::upper_bound(other.sets_, largest, {}, &ListedSet::size)),
        cut_short_(true),
        place_(other.place_) {
    place_.shrink(sets_.size());
  }

  /// The greatest size of which all sets are listed.
  std::size_t list(std::size_t most) {
    for (PartIndex part = 0; part < graph_.num_parts(); ++part) {
      const std::array<PartIndex, 1> alone = {part};
      place_.insert(key_of(alone));
      add(alone);
    }
    std::size_t begin = 0;
    std::size_t cuts = 0;
    std::size_t size = 1;
    while (size < most && size < graph_.num_parts()) {
      const std::size_t end = sets_.size();
      for (std::size_t s = begin; s < end; ++s) {
        if (!grow(s) || cuts + ((sets_.size() - end) << size) > effort_.most_sets * kCutsPerSet ||
            is_over(s)) {
          cut_short_ = true;
          sets_.resize(end);
          place_.shrink(end);
          return size;
        }
      }
      if (sets_.size() == end) break;
      cuts += (sets_.size() - end) << size;
      ++size;
      begin = end;
    }
    return size;
  }

  /// Works out value, moving, owed and room of each set; `largest` is what list() returned. Keeps
  /// the rows that the others do not imply.
  /// Nothing: there was no time for all.
  template <class Owed>
  std::optional<std::vector<PriceRow>> measure(std::size_t largest, Owed&& owed) {
    std::vector<PriceRow> rows;
    for (std::size_t s = 0; s < sets_.size(); ++s) {
      if (is_over(s)) return std::nullopt;
      ListedSet& set = sets_[s];
      set.moving = expander_.greatest_gain_of_moving(set.all());
      set.fixed = std::ranges::any_of(set.all(), [&](PartIndex p) { return problem_.in_base(p); });
      // What it would cost to move it is enough.
      if (may_stay(set, largest)) set.owed = owed(set.all(), std::max(0.0, 0.0 - set.moving));
      double implied = kInfinity;
      set.value = set.size == 1 ? 0 : value_of(set, implied);
      set.room = set.fixed ? 0.0 - set.value : 0.0 - set.value - set.moving;
      if (!set.fixed && set.room < implied && !may_leave(set, largest)) set.room = kInfinity;
      if (may_stay(set, largest)) set.room = std::min(set.room, set.owed - set.value);
      if (set.room < implied)
        rows.push_back({.parts = set.parts, .size = set.size, .room = set.room});
    }
    return rows;
  }

  /// The rows where each part reserves so much. Only after measure().
  std::vector<PriceRow> rows_with(const std::vector<double>& reserves, std::size_t largest) {
    const std::vector<std::uint32_t> least = least_lenders(reserves, largest);
    std::vector<PriceRow> rows;
    for (ListedSet& set : sets_) {
      PriceRow row = row_of(set, least, largest);
      if (!is_implied(set, row.room) && row.reserves && !may_leave(set, largest))
        row = row_of(set, least, largest);
      set.room = row.room;
      if (!is_implied(set, row.room)) rows.push_back(row);
    }
    return rows;
  }

  /// What parts cost, the most that any set has to owe then, and what is left of the room of each
  /// set where none may owe more.
  struct Costs {
    std::vector<double> of_parts;
    double most_owed;
    std::vector<PriceRow> left;
  };

  /// The greatest costs of parts that could be found; `rows` are those of measure().
  Costs costs(std::vector<PriceRow> rows, std::size_t largest) {
    const std::size_t parts = graph_.num_parts();
    constexpr std::size_t kMostIdleRounds = 4;
    constexpr std::size_t kMostRounds = 40;
    constexpr std::size_t kStepsInRound = 300;
    constexpr double kWorthARound = 1.001;
    PackedCosts::Answer best =
        PackedCosts(std::move(rows), parts).find([&] { return effort_.is_over(); });
    const double scale = best.sum / static_cast<double>(parts);
    std::vector<double> best_reserves(parts, 0.0);
    if (scale <= 0) return with_room_left(std::move(best.costs), best_reserves, largest);
    std::vector<double> costs = best.costs;
    // Where all cuts cost the same, parts reserve this share of that; where some cost more, a tenth
    // of it is the better beginning.
    const double share = 1 / static_cast<double>(largest + 1);
    std::vector<double> reserves;
    double most = -kInfinity;
    for (const double factor : {share, share / 10}) {
      std::vector<double> some = costs;
      for (double& reserve : some) reserve = factor * std::max(0.0, reserve);
      const double sum = PackedCosts(rows_with(some, largest), parts).made_valid(costs).sum;
      if (sum > most) reserves = std::move(some);
      most = std::max(most, sum);
    }
    std::size_t idle = 0;
    double last = -kInfinity;
    for (std::size_t round = 0; round < kMostRounds && !effort_.is_over(); ++round) {
      PackedCosts packed(rows_with(reserves, largest), parts);
      PackedCosts::Answer valid = packed.made_valid(costs);
      const double reached = valid.sum;
      if (valid.sum > best.sum) {
        best = std::move(valid);
        best_reserves = reserves;
      }
      // At first reserves are out of balance, and what is reached falls before it rises.
      idle = round > 0 && reached < last * kWorthARound ? idle + 1 : 0;
      last = reached;
      if (idle == kMostIdleRounds) break;
      packed.climb(costs, reserves, kStepsInRound,
                   0.002 * scale / (1 + 0.4 * static_cast<double>(round)));
    }
    return with_room_left(std::move(best.costs), best_reserves, largest);
  }

  [[nodiscard]] const std::vector<ListedSet>& sets() const { return sets_; }
  [[nodiscard]] bool cut_short() const { return cut_short_; }
  [[nodiscard]] KeyIndex take_places() && { return std::move(place_); }

 private:
  /// Whether what is told of the time is true, asked for one of many sets.
  [[nodiscard]] bool is_over(std::size_t set) const {
    constexpr std::size_t kPollEvery = 256;
    return set % kPollEvery == kPollEvery - 1 && effort_.is_over();
  }
  void add(std::span<const PartIndex> parts) {
    ListedSet& set = sets_.emplace_back();
    set.made_of = {0, 0};
    std::ranges::copy(parts, set.parts.begin());
    set.size = parts.size();
  }

  /// Whether a set may come off a piece of more than `largest` parts. Asked of those alone for
  /// which it matters.
  [[nodiscard]] bool may_leave(ListedSet& set, std::size_t largest) {
    if (!set.asked && partings_) set.may_leave = partings_->may_leave(set.all(), largest);
    set.asked = true;
    return set.may_leave;
  }
  /// The row of a set, by what sets of parts reserve at least.
  [[nodiscard]] PriceRow row_of(const ListedSet& set, const std::vector<std::uint32_t>& least,
                                std::size_t largest) const {
    PriceRow row{.parts = set.parts, .size = set.size, .room = 0.0 - set.value};
    if (!set.fixed) {
      row.reserves = set.may_leave;
      row.room = set.may_leave ? row.room - set.moving - set.reserved : kInfinity;
    }
    if (!may_stay(set, largest)) return row;
    const ListedSet* const lender = lender_of(set, least, largest);
    const double room = lender == nullptr ? kInfinity : lender->reserved + set.owed - set.value;
    if (room >= row.room) return row;
    row.room = room;
    row.reserves = false;
    row.lenders = lender->parts;
    row.num_lenders = lender->size;
    return row;
  }
  /// Whether the rows of two sets that make it up say as much.
  [[nodiscard]] bool is_implied(const ListedSet& set, double room) const {
    if (room == kInfinity) return true;
    if (set.size == 1 || set.made_of[0] == set.made_of[1]) return false;
    return room >= sets_[set.made_of[0]].room + sets_[set.made_of[1]].room;
  }
  /// Whether a set may be what stays of a piece of more than `largest` parts, for nothing.
  [[nodiscard]] static bool may_stay(const ListedSet& set, std::size_t largest) {
    return !set.fixed && 2 * set.size > largest;
  }

  /// The most that any set has to owe with these costs.
  [[nodiscard]] double most_owed_with(const std::vector<double>& costs,
                                      const std::vector<double>& reserves, std::size_t largest) {
    const std::vector<std::uint32_t> least = least_lenders(reserves, largest);
    double most = 0;
    for (const ListedSet& set : sets_) {
      if (!may_stay(set, largest)) continue;
      const ListedSet* const lender = lender_of(set, least, largest);
      if (lender == nullptr) continue;
      double sum = set.value - lender->reserved;
      for (const PartIndex part : set.all()) sum += costs[part];
      most = std::max(most, sum);
    }
    return most;
  }

  /// The costs with what else is asked for. After it no set owes more.
  Costs with_room_left(std::vector<double> costs, const std::vector<double>& reserves,
                       std::size_t largest) {
    const double most_owed = most_owed_with(costs, reserves, largest);
    for (ListedSet& set : sets_) set.owed = std::min(set.owed, most_owed);
    std::vector<PriceRow> rows = rows_with(reserves, largest);
    for (PriceRow& row : rows) {
      for (const PartIndex part : row.all()) row.room -= costs[part];
    }
    return {std::move(costs), most_owed, std::move(rows)};
  }

  /// By size, less 1, and part: the set of that size that holds the part and reserves least; the
  /// number of sets where there is none.
  std::vector<std::uint32_t> least_lenders(const std::vector<double>& reserves,
                                           std::size_t largest) {
    const auto none = static_cast<std::uint32_t>(sets_.size());
    std::vector<std::uint32_t> least(largest * graph_.num_parts(), none);
    for (std::uint32_t s = 0; s < none; ++s) {
      ListedSet& set = sets_[s];
      set.reserved = 0;
      for (const PartIndex part : set.all()) set.reserved += reserves[part];
      for (const PartIndex part : set.all()) {
        std::uint32_t& known = least[(set.size - 1) * graph_.num_parts() + part];
        if (known == none || set.reserved < sets_[known].reserved) known = s;
      }
    }
    return least;
  }
  /// Of the sets that hold a part next to `kept`, and that make up more parts with it than are
  /// listed, the one that reserves least; null where there is none.
  [[nodiscard]] const ListedSet* lender_of(const ListedSet& kept,
                                           const std::vector<std::uint32_t>& least,
                                           std::size_t largest) const {
    const std::span<const std::uint32_t> of_size =
        std::span(least).subspan((largest - kept.size) * graph_.num_parts(), graph_.num_parts());
    const ListedSet* found = nullptr;
    for (const PartIndex part : kept.all()) {
      for (const auto& half : graph_.around(part)) {
        if (of_size[half.other] == sets_.size()) continue;
        const ListedSet& lender = sets_[of_size[half.other]];
        const bool less = found == nullptr || lender.reserved < found->reserved;
        if (less && !std::ranges::binary_search(kept.all(), half.other)) found = &lender;
      }
    }
    return found;
  }

  /// Adds the sets that have one part more than set `s`. False if there are too many.
  bool grow(std::size_t s) {
    const ListedSet set = sets_[s];
    for (const PartIndex from : set.all()) {
      for (const auto& half : graph_.around(from)) {
        if (std::ranges::binary_search(set.all(), half.other)) continue;
        std::array<PartIndex, kMostListed> more{};
        const auto at = std::ranges::lower_bound(set.all(), half.other) - set.all().begin();
        std::copy_n(set.parts.begin(), at, more.begin());
        more[static_cast<std::size_t>(at)] = half.other;
        std::copy(set.parts.begin() + at, set.parts.begin() + static_cast<std::ptrdiff_t>(set.size),
                  more.begin() + at + 1);
        const std::span<const PartIndex> parts(more.data(), set.size + 1);
        if (!place_.insert(key_of(parts)).is_new) continue;
        if (sets_.size() >= effort_.most_sets) return false;
        add(parts);
      }
    }
    return true;
  }

  /// For each part of `set` those of it that are next to it, as bits by their places.
  [[nodiscard]] std::array<std::uint32_t, kMostListed> around_within(const ListedSet& set) const {
    std::array<std::uint32_t, kMostListed> around{};
    for (std::size_t i = 0; i < set.size; ++i) {
      for (const auto& half : graph_.around(set.parts[i])) {
        const auto found = std::ranges::lower_bound(set.all(), half.other);
        if (found == set.all().end() || *found != half.other) continue;
        around[i] |= 1U << static_cast<std::uint32_t>(found - set.all().begin());
      }
    }
    return around;
  }
  [[nodiscard]] static bool connected(std::uint32_t mask,
                                      const std::array<std::uint32_t, kMostListed>& around) {
    std::uint32_t reached = mask & (~mask + 1);
    for (std::uint32_t front = reached; front != 0;) {
      std::uint32_t next = 0;
      for (; front != 0; front &= front - 1)
        next |= around[static_cast<std::size_t>(std::countr_zero(front))];
      front = next & mask & ~reached;
      reached |= front;
    }
    return reached == mask;
  }

  /// The greatest over the cuts of `set`; and to `implied` the least room of two sets that make it
  /// up, which are then those that it is made of.
  [[nodiscard]] double value_of(ListedSet& set, double& implied) {
    double best = -kInfinity;
    double best_of_all = -kInfinity;
    std::array<PartIndex, kMostListed> a{};
    std::array<PartIndex, kMostListed> b{};
    const std::array<std::uint32_t, kMostListed> around = around_within(set);
    const std::uint32_t all = (1U << set.size) - 1;
    // The side of the last part is B, so that each cut comes once.
    for (std::uint32_t mask = 1; mask < (1U << (set.size - 1)); ++mask) {
      if (!connected(mask, around) || !connected(all & ~mask, around)) continue;
      std::size_t in_a = 0;
      std::size_t in_b = 0;
      for (std::size_t i = 0; i < set.size; ++i)
        (((mask >> i) & 1U) != 0 ? a[in_a++] : b[in_b++]) = set.parts[i];
      const std::span<const PartIndex> side_a(a.data(), in_a);
      const std::span<const PartIndex> side_b(b.data(), in_b);
      // All connected sets of these sizes are listed.
      const std::array<std::uint32_t, 2> sides = {place_.find(key_of(side_a)),
                                                  place_.find(key_of(side_b))};
      const ListedSet& first = sets_[sides[0]];
      const ListedSet& second = sets_[sides[1]];
      if (first.room + second.room < implied) {
        implied = first.room + second.room;
        set.made_of = sides;
      }
      const double apart = first.value + second.value;
      double most = -kInfinity;
      if (first.fixed && second.fixed) most = 0;
      if (!first.fixed) most = std::max(most, first.moving);
      if (!second.fixed) most = std::max(most, second.moving);
      best_of_all = std::max(best_of_all, most + apart);
      if (most + apart <= best) continue;
      best = std::max(best, most_of_cut(side_a, side_b) + apart);
    }
    return best == -kInfinity ? best_of_all : best;
  }
  /// The most that a cut gains, with what its connection costs; -infinity where it is not legal.
  [[nodiscard]] double most_of_cut(std::span<const PartIndex> side_a,
                                   std::span<const PartIndex> side_b) {
    double best = -kInfinity;
    for (const PartIndex part : side_a) {
      for (const auto& half : graph_.around(part)) {
        if (!std::ranges::binary_search(side_b, half.other)) continue;
        const bool part_is_a = problem_.ends(half.connection)[0] == part;
        const auto gain = part_is_a ? expander_.cut_gain(side_a, side_b, half.connection)
                                    : expander_.cut_gain(side_b, side_a, half.connection);
        if (gain) best = std::max(best, *gain + costs_[half.connection]);
        // Blocking and limits look at the sides alone.
        if (!by_connection_ || !gain) return best;
      }
    }
    return best;
  }

  std::optional<Partings> partings_;
  Expander& expander_;
  const Problem& problem_;
  const ListingEffort& effort_;
  bool by_connection_;  ///< whether what a cut gains depends on its connection
  detail::AssemblyGraph graph_;
  std::vector<double> costs_;  ///< what connections cost beside the bound (CutTrees)
  std::vector<ListedSet> sets_;
  bool cut_short_ = false;
  KeyIndex place_;  ///< of each set in sets_
};

SmallPieces::SmallPieces(const TransitionSystem& system, Expander& expander,
                         std::size_t most_listed, const LargerMoves& larger,
                         const ListingEffort& effort)
    : gain_of_larger_with_(larger.gain_with), in_base_(system.problem().base()) {
  static_assert(kMostListed <= PriceRow::kMostParts, "a key and a row hold twelve parts");
  const std::size_t parts = system.problem().num_parts();
  if (parts < 2) return;
  prices_.assign(parts, 0);
  Lister lister(system, expander, effort);
  const std::size_t largest = lister.list(std::min(most_listed, kMostListed));
  cut_short_ = lister.cut_short();
  if (!cut_short_ || largest % 2 == 0 || largest < kLeastOddTriedTwice) {
    price(lister, largest, larger, effort);
    return;
  }
  Expander other_expander(system);
  Lister fewer(lister, other_expander, largest - 1);
  SmallPieces other = *this;
  detail::run_parallel(2, [&](std::size_t thread) {
    if (thread == 0) {
      price(lister, largest, larger, effort);
    } else {
      other.price(fewer, largest - 1, larger, effort);
    }
  });
  if (!other.known()) return;
  std::vector<PartIndex> all(parts);
  std::iota(all.begin(), all.end(), PartIndex{0});
  if (!known() || other.bound(all) < bound(all)) *this = std::move(other);
}

/// Works out values and prices where the sets of at most `largest` parts are listed; nothing is
/// known where there is no time for that, or a set has no value.
void SmallPieces::price(Lister& lister, std::size_t largest, const LargerMoves& larger,
                        const ListingEffort& effort) {
  const std::size_t parts = prices_.size();
  if (larger.gain) gain_of_larger_ = larger.gain(largest);
  std::optional<std::vector<PriceRow>> rows = lister.measure(
      largest,
      [&](std::span<const PartIndex> set, double most) { return owed(set, largest, most); });
  if (!rows) return;
  for (const Lister::ListedSet& set : lister.sets()) {
    if (!std::isfinite(set.value) || std::isnan(set.room)) return;
    values_.push_back(set.value);
  }
  listed_ = std::move(lister).take_places();
  if (largest < parts) {
    Lister::Costs costs = lister.costs(*std::move(rows), largest);
    prices_ = std::move(costs.of_parts);
    for (double& price : prices_) price = 0.0 - price;
    most_owed_ = costs.most_owed;
    near_rows_ = std::move(costs.left);
    std::ranges::sort(near_rows_, {}, &PriceRow::room);
    const bool all = near_rows_.size() <= effort.most_near_rows;
    left_beyond_ = all ? kInfinity : near_rows_[effort.most_near_rows].room;
    if (!all) near_rows_.resize(effort.most_near_rows);
    near_rows_.shrink_to_fit();
  }
  largest_ = largest;
}

double SmallPieces::bound(std::span<const PartIndex> piece) const {
  if (piece.size() == 1) return 0;
  if (piece.size() <= largest_) {
    std::array<PartIndex, kMostListed> sorted{};
    std::size_t size = 0;
    for (const PartIndex part : piece) {
      std::size_t at = size++;
      for (; at > 0 && sorted[at - 1] > part; --at) sorted[at] = sorted[at - 1];
      sorted[at] = part;
    }
    const std::uint32_t found = listed_.find(key_of({sorted.data(), piece.size()}));
    return found == KeyIndex::kAbsent ? kInfinity : values_[found];
  }
  double sum = 0;
  for (const PartIndex part : piece) sum += prices_[part];
  return sum + owed(piece, largest_, most_owed_);
}

double SmallPieces::owed(std::span<const PartIndex> piece, std::size_t listed, double most) const {
  if (most <= 0) return 0;
  const auto is_fixed = [&](PartIndex part) { return in_base_[part]; };
  if (!in_base_.empty() && std::ranges::any_of(piece, is_fixed)) return 0;
  double owed = std::max(0.0, 0.0 - gain_of_larger_);
  if (owed < most && gain_of_larger_with_)
    owed = std::max(owed, 0.0 - gain_of_larger_with_(piece, listed, 0.0 - most));
  return std::min(owed, most);
}

}  // namespace orasp
