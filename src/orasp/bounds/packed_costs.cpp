#include "orasp/bounds/packed_costs.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

double added(std::span<const PartIndex> parts, const std::vector<double>& costs) {
  double total = 0;
  for (const PartIndex part : parts) total += costs[part];
  return total;
}
double left(const PriceRow& row, const std::vector<double>& costs) {
  return row.room - added(row.all(), costs);
}
double sum(const std::vector<double>& costs) {
  double total = 0;
  for (const double cost : costs) total += cost;
  return total;
}

}  // namespace

PackedCosts::PackedCosts(std::vector<PriceRow> rows, std::size_t parts)
    : rows_(std::move(rows)), rows_with_(parts) {
  for (std::uint32_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t i = 0; i < rows_[r].size; ++i) rows_with_[rows_[r].parts[i]].push_back(r);
  }
}

PackedCosts::Answer PackedCosts::find(const std::function<bool()>& is_over) {
  Costs costs(rows_with_.size(), kInfinity);
  double scale = 0;
  for (const PriceRow& row : rows_) {
    for (std::size_t i = 0; i < row.size; ++i) {
      double& cost = costs[row.parts[i]];
      cost = std::min(cost, row.room / static_cast<double>(row.size));
    }
  }
  // Where no row holds a part, it is in none of the pieces that are moved or stay.
  for (double& cost : costs) cost = std::isfinite(cost) ? cost : 0;
  Costs best = repaired(costs);
  for (const double cost : best) scale += cost / static_cast<double>(best.size());
  if (scale <= 0) return {best, sum(best)};
  Costs slope(costs.size(), 1.0);
  const auto work = std::max<std::size_t>(rows_.size(), 1);
  const auto iterations = std::clamp<std::size_t>(600'000'000 / work, 200, 2000);
  constexpr std::size_t kBetweenRepairs = 50;
  for (std::size_t i = 0; i < iterations; ++i) {
    if (i % kBetweenRepairs == 0) choose_rows(costs);
    step_up(costs, slope, 0.05 * scale / (1 + 0.02 * static_cast<double>(i)));
    if (i % kBetweenRepairs != kBetweenRepairs - 1) continue;
    Costs valid = repaired(costs);
    if (sum(valid) > sum(best)) best = std::move(valid);
    if (is_over()) break;
  }
  return {best, sum(best)};
}

PackedCosts::Answer PackedCosts::made_valid(const Costs& costs) const {
  Costs valid = repaired(costs);
  const double all = sum(valid);
  return {std::move(valid), all};
}

void PackedCosts::climb(Costs& costs, Costs& reserves, std::size_t steps, double step) {
  choose_rows(costs);
  constexpr double kStepOfReserves = 0.05;
  const Costs made_with = reserves;
  Costs up(costs.size());
  Costs reserve_up(costs.size());
  for (; steps > 0; --steps) {
    std::ranges::fill(up, 1.0);
    std::ranges::fill(reserve_up, 0.0);
    for (const std::uint32_t r : near_) {
      const PriceRow& row = rows_[r];
      double room = left(row, costs);
      if (row.reserves) room -= added(row.all(), reserves) - added(row.all(), made_with);
      if (row.num_lenders > 0)
        room += added(row.all_lenders(), reserves) - added(row.all_lenders(), made_with);
      if (room >= 0) continue;
      for (const PartIndex part : row.all()) {
        up[part] -= 1;
        if (row.reserves) reserve_up[part] -= 1;
      }
      for (const PartIndex part : row.all_lenders()) reserve_up[part] += 1;
    }
    for (std::size_t p = 0; p < costs.size(); ++p) {
      costs[p] += step * up[p];
      reserves[p] = std::max(0.0, reserves[p] + kStepOfReserves * step * reserve_up[p]);
    }
  }
}

void PackedCosts::choose_rows(const Costs& costs) {
  const std::size_t near = std::max(kLeastNear, rows_.size() / 32);
  near_.resize(rows_.size());
  std::iota(near_.begin(), near_.end(), 0U);
  if (rows_.size() <= near) return;
  std::vector<double> room;
  room.reserve(rows_.size());
  for (const PriceRow& row : rows_)
    room.push_back(left(row, costs) / static_cast<double>(row.size));
  std::ranges::nth_element(near_, near_.begin() + static_cast<std::ptrdiff_t>(near), {},
                           [&](std::uint32_t r) { return room[r]; });
  near_.resize(near);
}

void PackedCosts::step_up(Costs& costs, Costs& slope, double step) const {
  std::ranges::fill(slope, 1.0);
  for (const std::uint32_t r : near_) {
    const PriceRow& row = rows_[r];
    if (left(row, costs) >= 0) continue;
    for (std::size_t i = 0; i < row.size; ++i) slope[row.parts[i]] -= 1;
  }
  std::ranges::transform(costs, slope, costs.begin(),
                         [&](double cost, double up) { return cost + step * up; });
}
// The costs made valid, and then each, one after the other, as great as the others let it be.
PackedCosts::Costs PackedCosts::repaired(Costs costs) const {
  for (const PriceRow& row : rows_) {
    const double room = left(row, costs);
    if (room >= 0) continue;
    for (std::size_t i = 0; i < row.size; ++i)
      costs[row.parts[i]] += room / static_cast<double>(row.size);
  }
  for (std::size_t p = 0; p < costs.size(); ++p) {
    double room = kInfinity;
    for (const std::uint32_t r : rows_with_[p]) room = std::min(room, left(rows_[r], costs));
    if (std::isfinite(room)) costs[p] += room;
  }
  return costs;
}

}  // namespace orasp
