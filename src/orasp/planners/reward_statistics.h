#pragma once

#include <array>
#include <vector>

namespace orasp {

/// What is reported of a list of rewards; all 0 where there are none.
struct RewardFigures {
  double mean = 0;
  double deviation = 0;  ///< of the sample: n - 1 in the denominator; 0 for a single reward
  double least = 0;
  std::array<double, 5> percentiles{};  ///< 5, 25, 50, 75, 95
  double greatest = 0;
};

/// O(n log n).
[[nodiscard]] RewardFigures figures_of(std::vector<double> rewards);

}  // namespace orasp
