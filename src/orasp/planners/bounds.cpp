#include "orasp/planners/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "orasp/model/detail/connectivity.h"

namespace orasp {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

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

// ---------------------------------------------------------------------------------------------------------------------

PieceGains::PieceGains(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  known_ = system.sees_piece_only() && problem.direction() == Direction::Disassembly &&
           problem.num_parts() <= kMostParts;
  if (!known_) return;
  Expander expander(system);
  try {
    last_surplus_ = problem.num_connections() == 0 ? 0 : -kInfinity;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      own_.push_back(expander.own_reward(c));
      last_surplus_ = std::max(last_surplus_, expander.completion_surplus(c));
    }
    most_moved_ = problem.limits().max_moved_parts.value_or(problem.num_parts());
    measure_sizes(expander, problem);
    measure_parts(expander, problem);
  } catch (const InputError&) {
    // A formula without a value for a step that no plan may ever take, such as 1 / moved_parts where nothing moves.
    known_ = sizes_known_ = parts_known_ = false;
  }
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

void PieceGains::measure_sizes(Expander& expander, const Problem& problem) {
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
  if (sizes_known_ && parts <= kMostPartsWithArms) measure_arms(problem);
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

/// Calls visit(std::span<const PartIndex>) for connected sets of one, two and three parts up to `largest`; some more than
/// once.
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
  // Only where what a cut gains is told from what it moves; moved pieces are listed as long as they are small.
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
  } else if (most > 1) {
    lower_prices(expander, problem, graph);
  }
  parts_known_ = std::ranges::all_of(prices_, [](double price) { return std::isfinite(price); });
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
  // The value of a piece of two or three parts by its own cuts; singles are worth nothing. A cut that blocking forbids is
  // counted all the same: the bound stays finite, and the searches find the dead end.
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
  // 2,000 iterations are as good as 20,000 on a grid of 100 parts; with many sets fewer, for half a second at most.
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
    sum += prices_[part];
    least = std::min(least, prices_[part]);
  }
  return sum - least;
}

// ---------------------------------------------------------------------------------------------------------------------

struct PieceBound::Scratch {
  Scratch(const Problem& problem, bool lists) : graph(problem), connectivity(graph, lists) {}
  detail::AssemblyGraph graph;
  detail::Connectivity connectivity;
  std::vector<PartIndex> piece;
};

PieceBound::PieceBound(const TransitionSystem& system, Kind kind) : gains_(system) {
  sizes_ = kind != Kind::Parts && gains_.known() && gains_.sizes_known();
  parts_ = kind != Kind::Sizes && gains_.known() && gains_.parts_known();
  known_ = sizes_ || parts_;
  if (known_) scratch_ = std::make_unique<Scratch>(system.problem(), parts_);
}

PieceBound::~PieceBound() = default;

double PieceBound::of_piece(std::span<const PartIndex> piece) const {
  double bound = kInfinity;
  if (sizes_) bound = gains_.by_size(piece.size());
  if (parts_) bound = std::min(bound, gains_.by_parts(piece));
  return bound;
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

// ---------------------------------------------------------------------------------------------------------------------

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
