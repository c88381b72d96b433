#include "orasp/bounds/piece_gains.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "orasp/model/detail/rules.h"

namespace orasp {

PieceGains::PieceGains(const TransitionSystem& system, const ListingEffort& effort) {
  const Problem& problem = system.problem();
  known_ = system.sees_piece_only() && system.takes_apart();
  if (!known_) return;
  Expander expander(system);
  units_ = PartUnits(system);
  try {
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c)
      own_.push_back(expander.own_reward(c));
    // A cut between two base parts moves nothing, however large its sides are.
    most_moved_ = problem.spec().base.size() > 1
                      ? problem.num_parts()
                      : problem.limits().max_moved_parts.value_or(problem.num_parts());
    const bool in_table = problem.num_parts() <= kMostPartsInTable;
    if (in_table) {
      measure_sizes(system, expander);
    } else {
      measure_sizes_by_costs(system);
      if (has_units() && !system.completes_first()) measure_surpluses(system, expander);
      if (sizes_known_ && has_units()) measure_sizes_with_excess();
    }
    trees_ = CutTrees(system);
    if (in_table || expander.moving_more_costs_more()) {
      prices_ = PiecePrices(
          system, expander, units_, most_moved_,
          [this](std::size_t moved, std::size_t kept) { return gain(moved, kept); }, effort);
    }
    if (!system.completes_first() && system.num_steps() > 0) measure_last_step(system, expander);
  } catch (const InputError&) {
    // The objective is a formula that has no value for some step which no plan may ever take, such
    // as 1 / moved_parts where nothing moves.
    known_ = sizes_known_ = false;
    prices_ = {};
  }
}

void PieceGains::measure_last_step(const TransitionSystem& system, Expander& expander) {
  last_surplus_ = surplus_of_last_pair_ = -kInfinity;
  // Where sizes tell what a cut gains, the bound of two parts is what their cut gains.
  const bool bounded = !has_units() && !system.gain_by_sizes() && (sizes_known_ || parts_known());
  for_each_connection(system.start().view(), [&](ConnectionIndex c) {
    const auto& ends = system.problem().ends(c);
    const double surplus = expander.completion_surplus(c);
    double above = 0;
    if (bounded && ends[0] != ends[1]) {
      const std::optional<double> gain =
          expander.cut_gain(std::span(ends).first(1), std::span(ends).last(1), c);
      const double bound = by_sizes_and_parts(ends);
      if (gain && std::isfinite(bound)) above = bound - trees_.cost(c) - *gain;
    }
    last_surplus_ = std::max(last_surplus_, surplus);
    surplus_of_last_pair_ = std::max(surplus_of_last_pair_, surplus - above);
  });
}

double PieceGains::gain(std::size_t moved, std::size_t kept) const {
  const std::size_t parts = moved + kept;
  if (moved > most_moved_) return -kInfinity;
  if (gains_.empty()) return 0.0 - (cost_of_cut_ + cost_of_side_[moved] + cost_of_side_[kept]);
  return gains_[(parts - 1) * (parts - 1) / 4 + moved - 1];
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
    const std::vector<double>& with_fewer = arms == 2 ? by_size_ : by_arms_.back();
    for (std::size_t n = arms + 1; n <= parts; ++n) {
      const std::span<const double> row = std::span(gains_).subspan((n - 1) * (n - 1) / 4, n / 2);
      for (std::size_t a = 1; a + arms <= n; ++a) {
        const std::size_t moved = std::min(a, n - a);
        if (moved > most_moved_) continue;
        best[n] = std::max(best[n], row[moved - 1] + by_size_[a] + with_fewer[n - a]);
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
  sizes_known_ = std::ranges::all_of(by_size_, [](double best) { return std::isfinite(best); });
  if (has_units() && !system.completes_first()) measure_surpluses(system, expander);
  if (sizes_known_ && has_units()) measure_sizes_with_excess();
  if (sizes_known_ && parts <= kMostPartsWithArms) measure_arms(problem);
}

// With gain(a, b) = -(K + C(a) + C(b)) the recursion is
//
//     g(n) = -K + max over a + b = n of (g(a) - C(a)) + (g(b) - C(b)),
//
// which is quick enough without a table.
void PieceGains::measure_sizes_by_costs(const TransitionSystem& system) {
  const std::size_t parts = system.problem().num_parts();
  cost_of_side_.assign(parts + 1, 0.0);
  for (const auto& [weight, term] : system.rules().terms) {
    if (weight == 0) continue;
    const SizeCosts* const costs = term->size_costs();
    if (costs == nullptr) return;
    cost_of_cut_ += weight * (costs->base + costs->alone);
    for (std::size_t n = 1; n <= parts; ++n) cost_of_side_[n] += weight * costs->costs[n];
  }
  by_size_.assign(parts + 1, -kInfinity);
  by_size_[0] = by_size_[1] = 0;
  std::vector<double> rest(parts + 1, -kInfinity);  // g(n) - C(n)
  rest[1] = 0.0 - cost_of_side_[1];
  for (std::size_t n = 2; n <= parts; ++n) {
    const std::size_t most = std::min(n / 2, most_moved_);
    // Four at a time do not wait for each other.
    std::array<double, 4> best{-kInfinity, -kInfinity, -kInfinity, -kInfinity};
    std::size_t a = 1;
    for (; a + 3 <= most; a += 4) {
      for (std::size_t i = 0; i < 4; ++i)
        best[i] = std::max(best[i], rest[a + i] + rest[n - a - i]);
    }
    for (; a <= most; ++a) best[0] = std::max(best[0], rest[a] + rest[n - a]);
    by_size_[n] = std::max(std::max(best[0], best[1]), std::max(best[2], best[3])) - cost_of_cut_;
    rest[n] = by_size_[n] - cost_of_side_[n];
  }
  sizes_known_ = std::ranges::all_of(by_size_, [](double best) { return std::isfinite(best); });
}

void PieceGains::measure_surpluses(const TransitionSystem& system, Expander& expander) {
  const std::vector<std::size_t> size = units_.sizes();
  surplus_without_cut_ = surplus_of_cut_ = -kInfinity;
  for_each_connection(system.start().view(), [&](ConnectionIndex c) {
    const auto& ends = system.problem().ends(c);
    const std::array<PartIndex, 2> units = {units_.first_of(ends[0]), units_.first_of(ends[1])};
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

void PieceGains::measure_sizes_with_excess() {
  constexpr double kMostWork = 1e8;
  const std::size_t parts = by_size_.size() - 1;
  const std::size_t most = units_.excess();
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
        // The side of b parts holds an excess of b - 1 at most; the other side has what is left.
        const std::size_t first = d + 1 > b ? d + 1 - b : 0;
        for (std::size_t i = first; i < a && i <= d; ++i) {
          const double left = by_size(a, i);
          const double right = by_size(b, d - i);
          best[n] = std::max(best[n], cut + left + right);
          last[n] = std::max(
              last[n], cut + std::max(last_by_size(a, i) + right, left + last_by_size(b, d - i)));
        }
      }
    }
    for (std::size_t n = d + 1; n <= parts; ++n)
      sizes_known_ = sizes_known_ && std::isfinite(best[n]);
  }
}

}  // namespace orasp
