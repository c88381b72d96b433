#include "orasp/planners/and_or.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "orasp/bounds/piece_gains.h"
#include "orasp/containers/growing_array.h"
#include "orasp/containers/parallel.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/detail/connectivity.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// A set of parts.
template <std::size_t kWords>
struct PartSet {
  std::array<std::uint64_t, kWords> words{};

  void insert(std::size_t part) { words[part / 64] |= std::uint64_t{1} << (part % 64); }
  [[nodiscard]] bool contains(std::size_t part) const {
    return (words[part / 64] >> (part % 64) & 1U) != 0;
  }
  [[nodiscard]] std::size_t size() const {
    std::size_t sum = 0;
    for (const std::uint64_t word : words) sum += static_cast<std::size_t>(std::popcount(word));
    return sum;
  }
  [[nodiscard]] bool empty() const {
    return std::ranges::all_of(words, [](std::uint64_t word) { return word == 0; });
  }
  [[nodiscard]] std::size_t first() const {
    std::size_t w = 0;
    while (words[w] == 0) ++w;
    return w * 64 + static_cast<std::size_t>(std::countr_zero(words[w]));
  }
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t w = 0; w < kWords; ++w) {
      for (std::uint64_t word = words[w]; word != 0; word &= word - 1)
        visit(w * 64 + static_cast<std::size_t>(std::countr_zero(word)));
    }
  }
  friend PartSet operator&(PartSet a, const PartSet& b) {
    for (std::size_t w = 0; w < kWords; ++w) a.words[w] &= b.words[w];
    return a;
  }
  friend PartSet operator|(PartSet a, const PartSet& b) {
    for (std::size_t w = 0; w < kWords; ++w) a.words[w] |= b.words[w];
    return a;
  }
  friend PartSet operator-(PartSet a, const PartSet& b) {
    for (std::size_t w = 0; w < kWords; ++w) a.words[w] &= ~b.words[w];
    return a;
  }
  friend bool operator==(const PartSet&, const PartSet&) = default;
};

/// What all searches of one problem share.
struct World {
  explicit World(const TransitionSystem& the_system)
      : system(the_system), gains(the_system), graph(the_system.problem()) {}

  const TransitionSystem& system;
  PieceGains gains;
  detail::AssemblyGraph graph;
};

/// By part, the part above it in a spanning forest, or kNoPart. With a seed: depth first in a
/// random order, so that the trees are long paths with short branches, which can be cut into halves
/// nearly anywhere.
constexpr std::uint32_t kNoPart = std::numeric_limits<std::uint32_t>::max();
struct Rooted {
  std::vector<std::uint32_t> parent;
  std::vector<PartIndex> order;  ///< each part after the one above it
};
Rooted spanning_forest(const detail::AssemblyGraph& graph, std::uint64_t seed) {
  const std::size_t parts = graph.num_parts();
  Rooted forest{std::vector<std::uint32_t>(parts, kNoPart), {}};
  SplitMix64 random(seed);
  std::vector<PartIndex> roots(parts);
  std::iota(roots.begin(), roots.end(), PartIndex{0});
  std::vector<unsigned char> seen(parts, 0);
  struct Frame {
    PartIndex part;
    std::vector<PartIndex> next;
  };
  std::vector<Frame> path;
  const auto shuffle = [&](std::vector<PartIndex>& list) {
    for (std::size_t i = list.size(); i > 1; --i)
      std::swap(list[i - 1], list[static_cast<std::size_t>(random.below(i))]);
  };
  const auto enter = [&](PartIndex part) {
    seen[part] = 1;
    forest.order.push_back(part);
    Frame& frame = path.emplace_back(Frame{part, {}});
    for (const auto& half : graph.around(part)) frame.next.push_back(half.other);
    shuffle(frame.next);
  };
  shuffle(roots);
  for (const PartIndex root : roots) {
    if (seen[root] != 0) continue;
    enter(root);
    while (!path.empty()) {
      if (path.back().next.empty()) {
        path.pop_back();
        continue;
      }
      const PartIndex from = path.back().part;
      const PartIndex to = path.back().next.back();
      path.back().next.pop_back();
      if (seen[to] != 0) continue;
      forest.parent[to] = from;
      enter(to);
    }
  }
  return forest;
}

/// The search; kWords as many words as hold a set of all parts.
template <std::size_t kWords>
class Search {
 public:
  using Set = PartSet<kWords>;

  /// Looks at all cuts; with a seed only at those along a random spanning forest (in a forest these
  /// are all): few, so the best of them are found even where all are too many.
  Search(const World& world, std::uint64_t forest_seed, const Budget& budget, Result& result)
      : problem_(world.system.problem()),
        expander_(world.system),
        gains_(world.gains),
        graph_(world.graph),
        along_forest_(forest_seed != 0 || world.graph.is_forest()),
        budget_(budget),
        allowed_bytes_(allowed_bytes(budget)),
        result_(result),
        bounded_(world.gains.sizes_known() || world.gains.parts_known()),
        by_sizes_(world.system.gain_by_sizes() && world.gains.sizes_known() &&
                  !problem_.limits().max_moved_mass && problem_.directions() == 0),
        by_connection_(world.system.gain_by_connection()),
        limited_(problem_.limits().max_subassemblies.has_value()),
        memo_(kWords + 1) {
    const std::size_t parts = problem_.num_parts();
    neighbours_.resize(parts);
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      const auto [u, v] = problem_.ends(c);
      if (u == v) continue;
      neighbours_[u].insert(v);
      neighbours_[v].insert(u);
    }
    if (along_forest_) {
      Rooted forest = spanning_forest(graph_, forest_seed);
      parent_ = std::move(forest.parent);
      below_.resize(parts);
      for (std::size_t p = 0; p < parts; ++p) below_[p].insert(p);
      for (std::size_t i = parts; i-- > 0;) {
        const PartIndex part = forest.order[i];
        if (parent_[part] != kNoPart) below_[parent_[part]] = below_[parent_[part]] | below_[part];
      }
    }
    close_precedence();
  }

  /// @returns whether the search came to an end. What it has proved stays for the next run.
  bool run(std::uint64_t most_expansions, std::uint64_t most_looks) {
    gave_up_ = false;
    peeled_.clear();
    last_expansion_ = result_.statistics.expanded + most_expansions;
    last_look_ = looks_ + most_looks;
    std::vector<Set> pieces;
    graph_.for_each_piece(ConnectionSet::all(problem_.num_connections()).view(),
                          [&](std::span<const PartIndex> piece) {
                            if (piece.size() < 2) return;
                            Set set;
                            for (const PartIndex part : piece) set.insert(part);
                            pieces.push_back(set);
                          });
    // The pieces that wait take from what is allowed to the one at hand. Which order is best is
    // left open where it matters: then the bound takes for each the most that any order allows.
    std::size_t allowed = problem_.limits().max_subassemblies.value_or(kMostAllowed);
    allowed = std::min(allowed, kMostAllowed);
    double most = 0;
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) most += gains_.own(c);
    if (problem_.num_connections() > 0) most += gains_.last_surplus();
    for (const Set& piece : pieces) most += upper(piece, piece.size());
    result_.bound = most;
    for (const Set& piece : pieces) {
      const double before = most;
      const double loss =
          solve(piece, allowed, [&](double lower) { result_.bound = before - lower; });
      most -= loss;
      result_.bound = most;
      if (most == -kInfinity || result_.stop != Stop::None || gave_up_) break;
    }
    result_.statistics.states = std::max<std::uint64_t>(result_.statistics.states, memo_.size());
    result_.statistics.peak_bytes = std::max(result_.statistics.peak_bytes, bytes());
    allowed_ = allowed;
    pieces_ = std::move(pieces);
    return result_.stop == Stop::None && !gave_up_;
  }

  /// Carries the cut trees out as legal steps; empty where that leads nowhere. `dive`: where a
  /// piece is not solved take the cut that promises most.
  std::vector<ConnectionIndex> sequence(bool dive);

  /// Looks for a good plan that takes small sides off each piece, one after the other: of the rests
  /// of each size the `width` that have lost least are kept. What is cut off is solved exactly. The
  /// next sequence() follows what it finds.
  void peel(std::size_t width);

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::size_t kMostAllowed = 63;
  static constexpr std::size_t kMostPeeled = 3;

  /// A cut of a piece into `side` and the rest.
  struct Cut {
    Set side;
    double own_loss;      ///< g(S) - gain - g(A) - g(B)
    double estimate;      ///< own loss and the lower bounds of both sides
    std::uint64_t order;  ///< among equal ones
    bool side_waits;      ///< the rest is finished first
  };

  [[nodiscard]] std::optional<Cut> next_cut(const Set& piece, std::size_t parts,
                                            std::size_t allowed, bool dive);

  static void list_parts(const Set& set, std::vector<PartIndex>& list) {
    list.clear();
    set.for_each([&](std::size_t part) { list.push_back(static_cast<PartIndex>(part)); });
  }
  /// What `connection` gains as the last between `side` and the rest, which stand in side_list_ and
  /// rest_list_.
  [[nodiscard]] std::optional<double> listed_gain(const Set& side, ConnectionIndex connection) {
    return side.contains(problem_.ends(connection)[0])
               ? expander_.cut_gain(side_list_, rest_list_, connection)
               : expander_.cut_gain(rest_list_, side_list_, connection);
  }

  [[nodiscard]] double upper(const Set& set, std::size_t parts) {
    if (!bounded_) return 0;
    double bound = gains_.sizes_known() ? gains_.by_size(parts) : kInfinity;
    if (gains_.parts_known()) {
      list_parts(set, upper_list_);
      bound = std::min(bound, gains_.by_parts(upper_list_));
    }
    return bound;
  }

  [[nodiscard]] static std::size_t useful(std::size_t allowed, std::size_t parts) {
    // n parts never need more than floor(log2 n) subassemblies at a time.
    return std::min(allowed, static_cast<std::size_t>(std::bit_width(parts)) - 1);
  }
  [[nodiscard]] std::array<std::uint64_t, kWords + 1> key(const Set& set,
                                                          std::size_t allowed) const {
    std::array<std::uint64_t, kWords + 1> result{};
    std::ranges::copy(set.words, result.begin());
    result[kWords] = limited_ ? useful(allowed, set.size()) : 0;
    return result;
  }
  [[nodiscard]] double unknown_loss() const { return bounded_ ? 0 : -kInfinity; }
  /// What is known of the loss of a piece: at least this much.
  [[nodiscard]] double known_loss(const Set& set, std::size_t parts, std::size_t allowed) const {
    if (parts == 1) return 0;
    const std::uint32_t number = memo_.find(key(set, allowed).data());
    return number == detail::StateTable<kWords + 1>::kAbsent ? unknown_loss() : loss_[number];
  }

  [[nodiscard]] bool is_exact(const Set& set, std::size_t allowed) const {
    if (set.size() == 1) return true;
    const std::uint32_t number = memo_.find(key(set, allowed).data());
    return number != detail::StateTable<kWords + 1>::kAbsent && exact_[number] != 0;
  }

  // Losses grow by at least this much, so that sums of rounding errors are not taken for choices.
  [[nodiscard]] static double slack(double scale) {
    return kRewardTolerance * std::max(1.0, std::abs(scale));
  }

  template <class Report>
  double solve(const Set& piece, std::size_t allowed, Report&& report) {
    const std::size_t parts = piece.size();
    const double scale = upper(piece, parts);
    parts_scale_ = scale;
    double limit = bounded_ ? known_loss(piece, parts, allowed) + slack(scale) : kInfinity;
    double step = slack(scale);
    // A dive that goes wrong high up tries every way to fail further down: so each try ends after a
    // while, and the next takes equal cuts in another order. What was proved stays.
    std::uint64_t patience = 64 * parts;
    salt_ = 0;
    while (true) {
      interrupted_ = false;
      try_ends_ = result_.statistics.expanded + patience;
      const double loss = search(piece, parts, allowed, limit);
      if (interrupted_ && result_.stop == Stop::None && !gave_up_) {
        patience *= 2;
        ++salt_;
        continue;
      }
      if (result_.stop != Stop::None || gave_up_) {
        report(loss);
        return loss;
      }
      if (loss <= limit || loss == kInfinity) return loss;
      report(loss);
      step *= 2;
      limit = std::max(loss, limit + step) + slack(scale);
    }
  }

  /// A lower bound on the loss of a piece before any of its cuts is looked at: a hub costs more
  /// than sizes tell.
  double first_loss(const Set& piece, std::size_t parts) {
    if (!gains_.sizes_known() || parts < 3) return unknown_loss();
    const double most = gains_.by_arms(parts, arms(piece));
    return std::max(0.0, upper(piece, parts) - most - slack(parts_scale_));
  }

  /// The most components that a piece falls into without one of its parts. Reference: articulation
  /// points by depth-first search, Hopcroft and Tarjan (1973), Comm. ACM 16(6), 372-378.
  std::size_t arms(const Set& piece) {
    std::size_t most = 1;
    if (graph_.is_forest()) {
      piece.for_each(
          [&](std::size_t part) { most = std::max(most, (neighbours_[part] & piece).size()); });
      return most;
    }
    constexpr std::uint32_t kUnmet = 0;
    met_.assign(problem_.num_parts(), kUnmet);
    low_.resize(problem_.num_parts());
    struct Frame {
      PartIndex part;
      PartIndex from;
      std::uint32_t next;
      std::size_t arms;
    };
    std::vector<Frame> path;
    std::uint32_t time = 0;
    const auto root = static_cast<PartIndex>(piece.first());
    const auto enter = [&](PartIndex part, PartIndex from) {
      met_[part] = low_[part] = ++time;
      path.push_back({part, from, 0, from == kNoPart ? std::size_t{0} : std::size_t{1}});
    };
    enter(root, kNoPart);
    while (!path.empty()) {
      Frame& frame = path.back();
      const auto around = graph_.around(frame.part);
      if (frame.next < around.size()) {
        const PartIndex other = around[frame.next++].other;
        if (!piece.contains(other) || other == frame.from) continue;
        if (met_[other] == kUnmet) {
          enter(other, frame.part);
        } else {
          low_[frame.part] = std::min(low_[frame.part], met_[other]);
        }
        continue;
      }
      const Frame done = frame;
      most = std::max(most, done.arms);
      path.pop_back();
      if (path.empty()) break;
      Frame& above = path.back();
      low_[above.part] = std::min(low_[above.part], low_[done.part]);
      if (low_[done.part] >= met_[above.part]) ++above.arms;
    }
    return most;
  }

  /// The least loss of a piece where it is within `limit`; otherwise a lower bound on it, above
  /// `limit`.
  double search(const Set& piece, std::size_t parts, std::size_t allowed, double limit) {
    if (parts == 1) return 0;
    if (allowed == 0) return kInfinity;
    if (limited_) allowed = useful(allowed, parts);
    const auto [number, is_new] = memo_.insert(key(piece, allowed).data());
    if (is_new) {
      loss_.push_back(first_loss(piece, parts));
      exact_.push_back(0);
    }
    if (exact_[number] != 0 || loss_[number] > limit || stopped()) return loss_[number];
    ++result_.statistics.expanded;
    if (result_.statistics.expanded % 256 == 0) poll();
    if (result_.statistics.expanded >= last_expansion_) gave_up_ = true;
    if (result_.statistics.expanded >= try_ends_) {
      interrupted_ = true;
      return loss_[number];
    }

    const std::size_t begin = cuts_.size();
    double next = list_cuts(piece, parts, allowed, limit);
    std::sort(cuts_.begin() + static_cast<std::ptrdiff_t>(begin), cuts_.end(),
              [tie = slack(parts_scale_)](const Cut& a, const Cut& b) {
                // Sums of the same numbers in another order are equal, not a preference.
                const double left = std::floor(a.estimate / tie + 0.5);
                const double right = std::floor(b.estimate / tie + 0.5);
                return left != right ? left < right : a.order < b.order;
              });
    double best = kInfinity;
    const std::size_t end = cuts_.size();
    const double tie = slack(parts_scale_);
    for (std::size_t i = begin; i < end && !stopped(); ++i) {
      const Cut cut = cuts_[i];
      const double most = std::min(limit, best - tie);
      if (cut.estimate > most) {
        next = std::min(next, cut.estimate);
        continue;
      }
      const Set rest = piece - cut.side;
      const std::size_t side_parts = cut.side.size();
      const std::size_t rest_parts = parts - side_parts;
      const bool both = limited_ && side_parts >= 2 && rest_parts >= 2;
      const std::size_t side_allowed = both && !cut.side_waits ? allowed - 1 : allowed;
      const std::size_t rest_allowed = both && cut.side_waits ? allowed - 1 : allowed;
      // The smaller side first: it is solved sooner.
      const bool side_first = side_parts <= rest_parts;
      const Set& one = side_first ? cut.side : rest;
      const Set& other = side_first ? rest : cut.side;
      const std::size_t one_parts = side_first ? side_parts : rest_parts;
      const std::size_t one_allowed = side_first ? side_allowed : rest_allowed;
      const std::size_t other_allowed = side_first ? rest_allowed : side_allowed;
      double other_loss = known_loss(other, parts - one_parts, other_allowed);
      // A loss above the limit it was asked for is a lower bound only, however the sums are
      // rounded.
      const double one_limit = most - cut.own_loss - other_loss;
      const double one_loss = search(one, one_parts, one_allowed, one_limit);
      bool solved = one_loss <= one_limit;
      ++result_.statistics.generated;
      if (solved) {
        const double other_limit = most - cut.own_loss - one_loss;
        other_loss = search(other, parts - one_parts, other_allowed, other_limit);
        solved = other_loss <= other_limit;
      }
      const double total = cut.own_loss + one_loss + other_loss;
      if (stopped()) break;
      if (solved) {
        best = total;
      } else {
        next = std::min(next, total);
      }
    }
    cuts_.resize(begin);
    if (stopped()) return loss_[number];
    if (best < kInfinity) {
      loss_[number] = best;
      exact_[number] = 1;
    } else {
      // It is above the limit, also where the sums are rounded onto it.
      loss_[number] = std::max({loss_[number], next, std::nextafter(limit, kInfinity)});
      if (next == kInfinity) exact_[number] = 1;
    }
    return loss_[number];
  }

  /// Appends the legal cuts of `piece` whose estimate is within `limit`, and returns the least
  /// estimate of the others.
  double list_cuts(const Set& piece, std::size_t parts, std::size_t allowed, double limit) {
    const double here = upper(piece, parts);
    double skipped = kInfinity;
    // Sizes of the smaller side that may stay within the limit.
    wanted_.assign(parts / 2 + 1, 0);
    std::size_t largest = 0;
    const std::size_t most_moved = problem_.limits().max_moved_parts.value_or(parts);
    for (std::size_t a = 1; a <= std::min(parts / 2, most_moved); ++a) {
      double least = unknown_loss();
      if (gains_.sizes_known())
        least = here - gains_.gain(a, parts - a) - gains_.by_size(a) - gains_.by_size(parts - a);
      if (least > limit) {
        skipped = std::min(skipped, least);
      } else {
        wanted_[a] = 1;
        largest = a;
      }
    }
    if (peeling_ && !along_forest_) largest = std::min(largest, kMostPeeled);
    if (largest == 0) return skipped;
    const auto offer = [&](const Set& side, std::size_t side_parts) {
      const Set rest = piece - side;
      const std::optional<double> gain = gain_of(piece, side, rest, side_parts, parts - side_parts);
      if (!gain) return;
      const double own = here - *gain - upper(side, side_parts) - upper(rest, parts - side_parts);
      const auto add = [&](std::size_t side_allowed, std::size_t rest_allowed, bool side_waits) {
        if ((side_allowed == 0 && side_parts > 1) || (rest_allowed == 0 && side_parts < parts - 1))
          return;
        const double estimate = own + known_loss(side, side_parts, side_allowed) +
                                known_loss(rest, parts - side_parts, rest_allowed);
        if (estimate > limit) {
          skipped = std::min(skipped, estimate);
        } else {
          const std::uint64_t order =
              salt_ == 0 ? cuts_.size() : mixed(hash_value(side.words) + salt_);
          cuts_.push_back({side, own, estimate, order, side_waits});
          if (cuts_.size() * sizeof(Cut) > allowed_bytes_ / 2) gave_up_ = true;
        }
      };
      if (limited_ && side_parts >= 2 && parts - side_parts >= 2) {
        add(allowed - 1, allowed, false);
        add(allowed, allowed - 1, true);
      } else {
        add(allowed, allowed, false);
      }
    };
    if (along_forest_) {
      piece.for_each([&](std::size_t part) {
        if (parent_[part] == kNoPart || !piece.contains(parent_[part])) return;
        const Set side = below_[part] & piece;
        const std::size_t side_parts = side.size();
        if (wanted_[std::min(side_parts, parts - side_parts)] != 0) offer(side, side_parts);
      });
    } else {
      list_sides(piece, parts, largest, offer);
    }
    return skipped;
  }

  /// Calls offer(side, parts) for every connected side of a wanted size, of at most half of the
  /// piece, whose rest is connected. Reference for listing connected sets once each: Wernicke
  /// (2006), IEEE/ACM Trans. Computational Biology and Bioinformatics 3(4), 347-359.
  template <class Offer>
  void list_sides(const Set& piece, std::size_t parts, std::size_t largest, Offer&& offer) {
    Set excluded;
    const std::size_t lowest = piece.first();
    piece.for_each([&](std::size_t root) {
      Set side;
      side.insert(root);
      Set mine = excluded;
      grow(piece, parts, largest, side, 1, neighbours_[root] & (piece - mine), mine, lowest, offer);
      excluded.insert(root);
    });
  }

  template <class Offer>
  void grow(const Set& piece, std::size_t parts, std::size_t largest, const Set& side,
            std::size_t side_parts, Set frontier, Set excluded, std::size_t lowest, Offer&& offer) {
    if (stopped()) return;
    if (++looks_ % 4096 == 0) poll();
    if (looks_ >= last_look_) gave_up_ = true;
    // All but one component of the rest must still come in; those with an excluded part cannot.
    const Set rest = piece - side;
    const Set component = flood(rest, rest.first());
    if (component == rest) {
      if (wanted_[side_parts] != 0 && (2 * side_parts != parts || side.contains(lowest)))
        offer(side, side_parts);
    } else {
      std::size_t outside = 0;  // components that hold an excluded part
      std::size_t biggest = 0;
      Set left = rest;
      while (!left.empty()) {
        const Set one = flood(left, left.first());
        biggest = std::max(biggest, one.size());
        if (!(one & excluded).empty()) ++outside;
        left = left - one;
      }
      if (outside > 1) return;
      if (side_parts + (parts - side_parts - biggest) > largest) return;
    }
    if (side_parts == largest) return;
    Set mine = excluded;
    frontier.for_each([&](std::size_t part) {
      Set larger = side;
      larger.insert(part);
      const Set next = (frontier | (neighbours_[part] & piece)) - larger - mine;
      grow(piece, parts, largest, larger, side_parts + 1, next, mine, lowest, offer);
      mine.insert(part);
    });
  }

  [[nodiscard]] Set flood(const Set& within, std::size_t start) const {
    Set reached;
    reached.insert(start);
    Set front = reached;
    while (!front.empty()) {
      Set next;
      front.for_each([&](std::size_t part) { next = next | neighbours_[part]; });
      front = (next & within) - reached;
      reached = reached | front;
    }
    return reached;
  }

  /// What the cut gains at best, if it can be legal.
  std::optional<double> gain_of(const Set& piece, const Set& side, const Set& rest,
                                std::size_t side_parts, std::size_t rest_parts) {
    if (!precedence_.empty() && !may_precede(side, rest)) return std::nullopt;
    if (by_sizes_)
      return gains_.gain(std::min(side_parts, rest_parts), std::max(side_parts, rest_parts));
    list_parts(side, side_list_);
    list_parts(rest, rest_list_);
    std::optional<double> best;
    for (const PartIndex part : side_parts <= rest_parts ? side_list_ : rest_list_) {
      for (const auto& half : graph_.around(part)) {
        if (!piece.contains(half.other) || side.contains(half.other) == side.contains(part))
          continue;
        const auto gain = listed_gain(side, half.connection);
        if (!gain) return std::nullopt;
        if (!best || *gain > *best) best = *gain;
        if (!by_connection_) return best;
      }
    }
    return best;
  }

  // Before the last connection between the two sides goes, all that precedence asks for between
  // them is gone, and each side must hang together without it.
  bool may_precede(const Set& side, const Set& rest) {
    gone_.assign(problem_.num_connections(), 0);
    bool any = false;
    side.for_each([&](std::size_t part) {
      for (const auto& half : graph_.around(static_cast<PartIndex>(part))) {
        if (!rest.contains(half.other)) continue;
        for (const ConnectionIndex c : precedence_[half.connection]) {
          gone_[c] = 1;
          any = true;
        }
      }
    });
    if (!any) return true;
    const auto hangs_together = [&](const Set& set) {
      Set reached;
      reached.insert(set.first());
      std::vector<PartIndex>& queue = queue_;
      queue.assign(1, static_cast<PartIndex>(set.first()));
      for (std::size_t i = 0; i < queue.size(); ++i) {
        for (const auto& half : graph_.around(queue[i])) {
          if (gone_[half.connection] != 0 || !set.contains(half.other) ||
              reached.contains(half.other))
            continue;
          reached.insert(half.other);
          queue.push_back(half.other);
        }
      }
      return queue.size() == set.size();
    };
    return hangs_together(side) && hangs_together(rest);
  }

  /// By connection: all that must be gone before it, directly or through others.
  void close_precedence() {
    if (problem_.precedence().empty()) return;
    const std::size_t connections = problem_.num_connections();
    std::vector<std::vector<ConnectionIndex>> direct(connections);
    for (const PrecedenceClause& clause : problem_.precedence()) {
      direct[clause.connection].insert(direct[clause.connection].end(), clause.after.begin(),
                                       clause.after.end());
    }
    precedence_.resize(connections);
    std::vector<unsigned char> seen(connections);
    for (ConnectionIndex c = 0; c < connections; ++c) {
      std::ranges::fill(seen, 0);
      std::vector<ConnectionIndex>& all = precedence_[c];
      all = direct[c];
      for (const ConnectionIndex other : all) seen[other] = 1;
      for (std::size_t i = 0; i < all.size(); ++i) {
        for (const ConnectionIndex other : direct[all[i]]) {
          if (seen[other] == 0) all.push_back(other);
          seen[other] = 1;
        }
      }
    }
  }

  /// From here on nothing but the budget ends what is looked at.
  void no_limits() {
    interrupted_ = gave_up_ = false;
    try_ends_ = last_expansion_ = last_look_ = std::numeric_limits<std::uint64_t>::max();
  }
  [[nodiscard]] bool stopped() const {
    return interrupted_ || gave_up_ || result_.stop != Stop::None;
  }
  [[nodiscard]] std::uint64_t bytes() const {
    constexpr std::size_t kUntilNextLook = 512;  // the table may double before
    return memo_.bytes_with(kUntilNextLook) + loss_.bytes() + exact_.bytes() +
           cuts_.capacity() * sizeof(Cut);
  }
  void poll() {
    result_.stop = bytes() > allowed_bytes_ ? Stop::MemoryLimit
                                            : budget_.expired(bytes(), result_.statistics.expanded);
    budget_.report(
        {.phase = "search", .done = result_.statistics.expanded, .states = memo_.size()});
  }

  const Problem& problem_;
  Expander expander_;
  const PieceGains& gains_;
  const detail::AssemblyGraph& graph_;
  bool along_forest_;
  const Budget& budget_;
  std::uint64_t allowed_bytes_;
  Result& result_;
  bool
      /// Some bound on what a piece gains is known; else losses are counted from 0 and may be
      /// negative.
      bounded_;
  bool by_sizes_;
  bool by_connection_;
  bool limited_;

  std::vector<Set> neighbours_;
  std::vector<std::uint32_t> parent_;  ///< along a forest: of each part
  std::vector<Set> below_;             ///< along a forest: parts at and below each part
  std::vector<std::vector<ConnectionIndex>> precedence_;  ///< empty where none is stated

  detail::StateTable<kWords + 1> memo_;
  detail::GrowingArray<double> loss_;
  detail::GrowingArray<unsigned char> exact_;
  std::vector<Cut> cuts_;
  std::vector<unsigned char> wanted_;
  std::vector<unsigned char> gone_;
  std::vector<PartIndex> queue_;
  std::vector<std::uint32_t> met_;
  std::vector<std::uint32_t> low_;
  std::vector<PartIndex> upper_list_;
  std::vector<PartIndex> side_list_;
  std::vector<PartIndex> rest_list_;
  double parts_scale_ =
      0;  ///< size of the bound of the piece at hand: what rounding is measured by
  std::uint64_t looks_ = 0;
  std::uint64_t salt_ = 0;      ///< of the order of equal cuts; 0: as they are listed
  std::uint64_t try_ends_ = 0;  ///< at so many expansions
  std::uint64_t last_expansion_ = 0;
  std::uint64_t last_look_ = 0;
  bool interrupted_ = false;  ///< the try has ended
  bool gave_up_ = false;      ///< the scope has

  std::vector<Set> pieces_;
  std::size_t allowed_ = 0;
  bool peeling_ = false;
  std::vector<std::pair<Set, Set>> peeled_;  ///< pieces with the sides to cut off them
};

template <std::size_t kWords>
void Search<kWords>::peel(std::size_t width) {
  struct Rest {
    Set piece;
    double loss;
    std::uint32_t before;  ///< the piece it was cut from, in `all`
    Set side;              ///< what was cut off
  };
  peeled_.clear();
  peeling_ = true;
  no_limits();
  for (const Set& whole : pieces_) {
    const std::size_t parts = whole.size();
    std::vector<std::vector<Rest>> by_size(parts + 1);
    std::vector<Rest> all;  // those kept, largest first
    by_size[parts].push_back({whole, 0, kNone, {}});
    const auto keep_best = [width](std::vector<Rest>& rests) {
      // The best of each, then the best of all.
      std::ranges::sort(rests, [](const Rest& a, const Rest& b) {
        if (a.piece.words != b.piece.words) return a.piece.words < b.piece.words;
        return a.loss != b.loss ? a.loss < b.loss : a.before < b.before;
      });
      const auto same =
          std::ranges::unique(rests, {}, [](const Rest& rest) { return rest.piece.words; });
      rests.erase(same.begin(), same.end());
      std::ranges::stable_sort(rests, {}, &Rest::loss);
      if (rests.size() > width) rests.resize(width);
    };
    for (std::size_t size = parts; size >= 2 && result_.stop == Stop::None; --size) {
      std::vector<Rest>& here = by_size[size];
      keep_best(here);
      for (const Rest& rest : here) {
        const auto number = static_cast<std::uint32_t>(all.size());
        all.push_back(rest);
        cuts_.clear();
        static_cast<void>(list_cuts(rest.piece, size, allowed_, kInfinity));
        const std::vector<Cut> cuts = cuts_;
        cuts_.clear();
        for (const Cut& cut : cuts) {
          const std::size_t cut_parts = cut.side.size();
          const bool side_stays = 2 * cut_parts > size;
          const Set off = side_stays ? rest.piece - cut.side : cut.side;
          const std::size_t off_parts = side_stays ? size - cut_parts : cut_parts;
          // What is cut off is done at once, while the rest waits.
          const bool rest_waits = side_stays ? cut.side_waits : !cut.side_waits;
          const bool both = limited_ && off_parts >= 2 && size - off_parts >= 2;
          if (off_parts > kMostPeeled || (both && !rest_waits)) continue;
          const double off_loss = search(off, off_parts, both ? allowed_ - 1 : allowed_, kInfinity);
          if (off_loss == kInfinity || result_.stop != Stop::None) continue;
          std::vector<Rest>& there = by_size[size - off_parts];
          there.push_back({rest.piece - off, rest.loss + cut.own_loss + off_loss, number, off});
          if (there.size() > 1024 + 8 * width) keep_best(there);
        }
        poll();
      }
      here = {};
    }
    if (by_size[1].empty()) break;
    const Rest* at = &*std::ranges::min_element(by_size[1], {}, &Rest::loss);
    while (at->before != kNone) {
      peeled_.emplace_back(all[at->before].piece, at->side);
      at = &all[at->before];
    }
  }
  peeling_ = false;
}

/// The cut that a plan makes to a piece: the one that peel() found, or the best; nothing where none
/// is known.
template <std::size_t kWords>
auto Search<kWords>::next_cut(const Set& piece, std::size_t parts, std::size_t allowed, bool dive)
    -> std::optional<Cut> {
  const auto peeled = std::ranges::find(peeled_, piece, &std::pair<Set, Set>::first);
  if (peeled != peeled_.end())
    return Cut{
        .side = peeled->second, .own_loss = 0, .estimate = 0, .order = 0, .side_waits = false};
  const bool known = is_exact(piece, allowed);
  if (!known && !dive) return std::nullopt;
  const double loss = known_loss(piece, parts, allowed);
  cuts_.clear();
  static_cast<void>(
      list_cuts(piece, parts, allowed,
                known ? loss + slack(parts_scale_) * static_cast<double>(parts) : kInfinity));
  const auto promise = [&](const Cut& cut) {
    // Exact losses of both sides add up to this piece's; anything unsolved cannot be chosen.
    const Set rest = piece - cut.side;
    const std::size_t side_parts = cut.side.size();
    const bool both = limited_ && side_parts >= 2 && parts - side_parts >= 2;
    const bool solved = is_exact(cut.side, both && !cut.side_waits ? allowed - 1 : allowed) &&
                        is_exact(rest, both && cut.side_waits ? allowed - 1 : allowed);
    return solved || !known ? cut.estimate : kInfinity;
  };
  const auto chosen = std::ranges::min_element(cuts_, {}, promise);
  if (chosen == cuts_.end() || promise(*chosen) == kInfinity) return std::nullopt;
  return *chosen;
}

/// The steps of the cut trees, one piece after the other, a side that waits last. What a cut needs:
/// every connection between the sides, and what precedence asks for before them; all but the last
/// separate nothing.
template <std::size_t kWords>
std::vector<ConnectionIndex> Search<kWords>::sequence(bool dive) {
  struct Task {
    Set piece;
    std::size_t allowed;
  };
  const std::size_t connections = problem_.num_connections();
  no_limits();
  std::vector<ConnectionIndex> steps;
  ConnectionSet open = ConnectionSet::all(connections);
  std::vector<Task> tasks;  // the last is at hand
  for (const Set& piece : pieces_) tasks.push_back({piece, allowed_});
  const auto take = [&](ConnectionIndex c) {
    if (!open.contains(c)) return true;
    if (!expander_.legal(open.view(), c)) return false;
    open.erase(c);
    steps.push_back(c);
    return true;
  };
  // Which connection of all is best left to the end: one that joins two parts, or one of a part to
  // itself.
  double best_last = -kInfinity;
  for (ConnectionIndex c = 0; c < connections; ++c)
    best_last = std::max(best_last, expander_.completion_surplus(c));
  for (const ConnectionIndex c : graph_.loops()) {
    if (expander_.completion_surplus(c) < best_last) static_cast<void>(take(c));
  }
  std::vector<ConnectionIndex> needed;
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const std::size_t parts = task.piece.size();
    if (parts == 1) continue;
    const std::size_t allowed = limited_ ? useful(task.allowed, parts) : task.allowed;
    const std::optional<Cut> next = next_cut(task.piece, parts, allowed, dive);
    if (!next) return {};
    const Cut cut = *next;
    const Set rest = task.piece - cut.side;
    const bool both = limited_ && cut.side.size() >= 2 && rest.size() >= 2;
    // Connections between the sides with what they need first, by repeated passes; the best one to
    // separate last.
    needed.clear();
    gone_.assign(connections, 0);
    for (ConnectionIndex c = 0; c < connections; ++c) {
      const auto [u, v] = problem_.ends(c);
      if ((cut.side.contains(u) && rest.contains(v)) || (cut.side.contains(v) && rest.contains(u)))
        gone_[c] = 1;
    }
    ConnectionIndex last = kNone;
    double best = -kInfinity;
    list_parts(cut.side, side_list_);
    list_parts(rest, rest_list_);
    for (ConnectionIndex c = 0; c < connections; ++c) {
      if (gone_[c] != 1) continue;
      needed.push_back(c);
      if (!by_connection_ || !open.contains(c)) continue;
      const auto gain = listed_gain(cut.side, c);
      if (gain && *gain > best) {
        best = *gain;
        last = c;
      }
    }
    if (!precedence_.empty()) {
      const std::size_t crossing = needed.size();
      for (std::size_t i = 0; i < crossing; ++i) {
        for (const ConnectionIndex c : precedence_[needed[i]]) {
          if (gone_[c] == 0) needed.push_back(c);
          gone_[c] = 1;
        }
      }
    }
    std::size_t left = needed.size();
    bool moving = true;
    while (left > 0 && moving) {
      moving = false;
      for (ConnectionIndex& c : needed) {
        if (c == kNone || (c == last && left > 1)) continue;
        if (!take(c)) continue;
        c = kNone;
        --left;
        moving = true;
      }
    }
    if (left > 0) return {};
    const Task side{cut.side, both && !cut.side_waits ? allowed - 1 : allowed};
    const Task others{rest, both && cut.side_waits ? allowed - 1 : allowed};
    tasks.push_back(cut.side_waits ? side : others);
    tasks.push_back(cut.side_waits ? others : side);
  }
  // Connections of a part to itself, and what only precedence held back.
  bool moving = true;
  while (moving) {
    moving = false;
    for (ConnectionIndex c = 0; c < connections; ++c) {
      if (open.contains(c) && take(c)) moving = true;
    }
  }
  return steps.size() == connections ? steps : std::vector<ConnectionIndex>{};
}

/// The plan that the search has found, if it can be carried out.
template <std::size_t kWords>
void take_plan(const World& world, Search<kWords>& search, bool dive, Result& result) {
  std::vector<ConnectionIndex> sequence = search.sequence(dive);
  if (sequence.size() != world.system.num_connections()) return;
  result.reward = detail::reward_of(world.system, sequence);
  result.sequence = std::move(sequence);
  result.status = Status::Feasible;
}

void add_effort(Statistics& sum, const Statistics& part) {
  sum.states = std::max(sum.states, part.states);
  sum.expanded += part.expanded;
  sum.generated += part.generated;
  sum.peak_bytes = std::max(sum.peak_bytes, part.peak_bytes);
}

/// A look at all cuts, which often is enough; where they are too many, plans along random spanning
/// forests; and so on in turn, each time for longer.
template <std::size_t kWords>
Result planned(const TransitionSystem& system, const AndOrOptions& options, const Budget& budget) {
  // Of the first round: some tenths of a second at any size.
  const std::uint64_t size = std::max<std::uint64_t>(system.problem().num_parts(), 1);
  const std::uint64_t first_expansions = std::clamp<std::uint64_t>(2'500'000 / size, 2'000, 20'000);
  const std::uint64_t first_looks = std::max<std::uint64_t>(12'800'000 / (size * kWords), 500);
  constexpr std::uint64_t kForestsInRound = 8;  // the same for any number of threads
  constexpr std::uint64_t kForestExpansions = 2'000;
  constexpr std::size_t kFirstWidth = 4;
  const World world(system);
  if (!world.gains.known()) return {};
  Result whole;  // what looking at all cuts gives
  Search<kWords> search(world, 0, budget, whole);
  Result best;
  best.method = "and-or";
  bool peeling_pays = true;
  for (std::uint64_t round = options.first_round;; ++round) {
    const std::uint64_t longer = std::uint64_t{1} << std::min<std::uint64_t>(round, 40);
    const bool ended = search.run(first_expansions * longer, first_looks * longer);
    const double most = whole.bound.value_or(kInfinity);
    if (ended && most == -kInfinity) return detail::exhausted("and-or", whole.statistics);
    if (ended) take_plan(world, search, false, whole);
    if (whole.has_plan() && whole.reward > best.reward) {
      best.sequence = whole.sequence;
      best.reward = whole.reward;
    }
    const auto proved = [&] {
      return std::isfinite(best.reward) && detail::meets(best.reward, most);
    };
    if (!proved() && !ended && whole.stop == Stop::None && peeling_pays) {
      search.peel(kFirstWidth * longer);
      Result peeled;
      if (whole.stop == Stop::None) take_plan(world, search, false, peeled);
      peeling_pays = peeled.has_plan() && peeled.reward >= best.reward;
      if (peeling_pays) {
        best.sequence = std::move(peeled.sequence);
        best.reward = peeled.reward;
      }
    }
    Stop stop = whole.stop;
    if (!proved() && !ended && stop == Stop::None && !world.graph.is_forest()) {
      std::vector<Result> results(kForestsInRound);
      const std::size_t threads =
          std::min<std::size_t>(std::max(1U, budget.threads), kForestsInRound);
      detail::run_parallel(threads, [&](std::size_t t) {
        Budget quiet = budget;
        quiet.progress = nullptr;
        for (std::size_t i = t; i < kForestsInRound; i += threads) {
          Search<kWords> along(world, round * kForestsInRound + i + 1, quiet, results[i]);
          const std::uint64_t expansions = kForestExpansions * longer;
          static_cast<void>(along.run(expansions, expansions));
          if (results[i].stop == Stop::None) take_plan(world, along, true, results[i]);
        }
      });
      for (Result& result : results) {
        add_effort(best.statistics, result.statistics);
        if (stop == Stop::None) stop = result.stop;
        if (!result.has_plan() || result.reward <= best.reward) continue;
        peeling_pays = false;
        best.sequence = std::move(result.sequence);
        best.reward = result.reward;
      }
    }
    const bool last = round - options.first_round + 1 >= options.rounds;
    if (!ended && !proved() && stop == Stop::None) {
      if (!last) continue;
      stop = Stop::ExpansionLimit;
    }
    add_effort(best.statistics, whole.statistics);
    if (std::isfinite(most)) best.bound = most;
    if (!best.sequence.empty() || system.num_connections() == 0) best.status = Status::Feasible;
    if (proved()) {
      best.status = Status::Optimal;
      best.bound = best.reward;
    } else {
      best.stop = stop;
    }
    return best;
  }
}

}  // namespace

std::optional<std::string> and_or_obstacle(const TransitionSystem& system) {
  if (system.whole() && system.sees_piece_only() &&
      system.problem().direction() == Direction::Disassembly &&
      system.problem().num_parts() <= kAndOrMostParts)
    return std::nullopt;
  return "takes whole problems in disassembly, of at most " + std::to_string(kAndOrMostParts) +
         " parts, whose objective sees nothing but the piece that is cut";
}

Result and_or(const TransitionSystem& system, const AndOrOptions& options, const Budget& budget) {
  const Stopwatch watch;
  if (auto result = detail::settled(system, "and-or")) return *result;
  if (system.num_connections() == 0) {
    Result empty = greedy(system, budget);
    empty.method = "and-or";
    return empty;
  }
  if (const auto reason = and_or_obstacle(system)) throw Refusal("and-or", *reason);
  const std::size_t words = (system.problem().num_parts() + 63) / 64;
  Result result;
  try {
    result = words <= 1   ? planned<1>(system, options, budget)
             : words <= 2 ? planned<2>(system, options, budget)
             : words <= 4 ? planned<4>(system, options, budget)
             : words <= 8 ? planned<8>(system, options, budget)
                          : planned<16>(system, options, budget);
  } catch (const InputError&) {
    // A formula without a value for a cut that no plan may ever make: what follows meets it if one
    // does.
  }
  if (!result.has_plan() && result.status != Status::Infeasible) {
    // The cut tree could not be carried out, or there was no time for one.
    Result other = result.stop == Stop::None
                       ? greedy(system, budget)
                       : detail::stopped(system, "and-or", result.stop, result.statistics);
    other.method = "and-or";
    if (other.status == Status::Infeasible || !result.bound) return other;
    other.bound = result.bound;
    if (other.has_plan() && other.reward >= *other.bound - kRewardTolerance) {
      other.status = Status::Optimal;
      other.bound = other.reward;
      other.stop = Stop::None;
    }
    result = std::move(other);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
