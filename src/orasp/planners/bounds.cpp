#include "orasp/planners/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
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
  last_surplus_ = problem.num_connections() == 0 ? 0 : -kInfinity;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    own_.push_back(expander.own_reward(c));
    last_surplus_ = std::max(last_surplus_, expander.completion_surplus(c));
  }
  most_moved_ = problem.limits().max_moved_parts.value_or(problem.num_parts());
  measure_sizes(expander, problem);
  measure_parts(expander, problem);
}

double PieceGains::gain(std::size_t moved, std::size_t kept) const {
  const std::size_t parts = moved + kept;
  return moved > most_moved_ ? -kInfinity : gains_[(parts - 1) * (parts - 1) / 4 + moved - 1];
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
}

void PieceGains::measure_parts(Expander& expander, const Problem& problem) {
  // Only where what a cut gains is told from what it moves; bigger moved pieces are tried as long as there are few.
  constexpr std::size_t kMostMoved = 3;
  const std::size_t parts = problem.num_parts();
  part_gain_.assign(parts, -kInfinity);
  const detail::AssemblyGraph graph(problem);
  std::vector<PartIndex> moved;
  const auto note = [&] {
    const double gain = expander.greatest_gain_of_moving(moved);
    for (const PartIndex part : moved) part_gain_[part] = std::max(part_gain_[part], gain);
  };
  const std::size_t most = expander.moving_more_costs_more() ? 1 : std::min(most_moved_, parts / 2);
  const std::size_t largest = std::min(most, kMostMoved);
  for (PartIndex u = 0; u < parts; ++u) {
    moved = {u};
    note();
    if (!std::isfinite(part_gain_[u])) return;
    if (largest < 2) continue;
    for (const auto& first : graph.around(u)) {
      moved = {u, first.other};
      note();
      if (largest < 3) continue;
      for (const PartIndex from : {u, first.other}) {
        for (const auto& second : graph.around(from)) {
          if (second.other == u || second.other == first.other) continue;
          moved = {u, first.other, second.other};
          note();
        }
      }
    }
  }
  // What larger moved pieces gain at most, whatever they are.
  if (most > kMostMoved) {
    double larger = -kInfinity;
    for (std::size_t a = kMostMoved + 1; a <= most; ++a) {
      for (std::size_t b = a; a + b <= parts; ++b) larger = std::max(larger, gain(a, b));
    }
    for (double& gain : part_gain_) gain = std::max(gain, larger);
  }
  parts_known_ = std::ranges::all_of(part_gain_, [](double gain) { return std::isfinite(gain); });
}

// ---------------------------------------------------------------------------------------------------------------------

struct PieceBound::Scratch {
  Scratch(const Problem& problem, bool lists) : graph(problem), connectivity(graph, lists) {}
  detail::AssemblyGraph graph;
  detail::Connectivity connectivity;
};

PieceBound::PieceBound(const TransitionSystem& system, Kind kind) : gains_(system) {
  sizes_ = kind != Kind::Parts && gains_.known() && gains_.sizes_known();
  parts_ = kind != Kind::Sizes && gains_.known() && gains_.parts_known();
  known_ = sizes_ || parts_;
  if (known_) scratch_ = std::make_unique<Scratch>(system.problem(), parts_);
}

PieceBound::~PieceBound() = default;

// `sum` and `least` of the part gains.
double PieceBound::of_piece(std::size_t parts, double sum, double least) const {
  double bound = kInfinity;
  if (sizes_) bound = gains_.by_size(parts);
  if (parts_) bound = std::min(bound, sum - least);
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
  scratch_->graph.for_each_piece(open, [&](std::span<const PartIndex> piece) {
    double all = 0;
    double least = 0;
    if (parts_) {
      least = kInfinity;
      for (const PartIndex part : piece) {
        all += gains_.part_gain(part);
        least = std::min(least, gains_.part_gain(part));
      }
    }
    sum += of_piece(piece.size(), all, least);
  });
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
    double sum_a = 0;
    double sum_b = 0;
    double least_a = kInfinity;
    double least_b = kInfinity;
    if (parts_) {
      connectivity.lower_side(c).for_each([&](PartIndex part) {
        sum_a += gains_.part_gain(part);
        least_a = std::min(least_a, gains_.part_gain(part));
      });
      connectivity.upper_side(c).for_each([&](PartIndex part) {
        sum_b += gains_.part_gain(part);
        least_b = std::min(least_b, gains_.part_gain(part));
      });
    }
    bounds[i] += of_piece(a, sum_a, least_a) + of_piece(n - a, sum_b, least_b) -
                 of_piece(n, sum_a + sum_b, std::min(least_a, least_b));
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
