#include "orasp/planners/reward_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace orasp {
namespace {

/// The value below which the share `share` of the sorted numbers lies, linear between neighbours.
/// Reference. Definition 7 of Hyndman and Fan (1996), The American Statistician 50(4), 361-365.
double quantile(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

RewardFigures figures_of(std::vector<double> rewards) {
  RewardFigures figures;
  if (rewards.empty()) return figures;
  std::ranges::sort(rewards);
  const auto n = static_cast<double>(rewards.size());
  double above_least = 0;  // so that equal rewards have exactly their own mean
  for (const double reward : rewards) above_least += reward - rewards.front();
  figures.mean = rewards.front() + above_least / n;
  double squares = 0;
  for (const double reward : rewards) squares += (reward - figures.mean) * (reward - figures.mean);
  figures.deviation = rewards.size() > 1 ? std::sqrt(squares / (n - 1)) : 0;
  figures.least = rewards.front();
  constexpr std::array kShares = {0.05, 0.25, 0.5, 0.75, 0.95};
  for (std::size_t i = 0; i < kShares.size(); ++i)
    figures.percentiles[i] = quantile(rewards, kShares[i]);
  figures.greatest = rewards.back();
  return figures;
}

}  // namespace orasp
