#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "orasp/model/tolerance.h"

/// The number systems in which dense_value_iteration() holds its values. Each has: rounded(), which
/// turns a reward into a value; value(), which turns it back; holds(), whether a reward is small
/// enough; error(), what rounding changes; plus(), the value of a step and of what is left after
/// it; and kNever, the value of a state from which the goal is not reached.
namespace orasp::detail {

/// A state: the set of its open connections, as bits.
using Mask = std::uint64_t;

inline Mask bit(std::size_t c) {
  return Mask{1} << c;
}

/// Values as doubles.
struct Doubles {
  using Value = double;
  static constexpr Value kNever = -kInfinity;

  static Value rounded(double reward) { return reward; }
  static double value(Value value) { return value; }
  static bool holds(double, bool) { return true; }
  static double error(double) { return 0; }
  static Value plus(Value reward, Value left) { return reward + left; }
};

/// Values as whole numbers of a decimal unit, in four bytes each.
struct FixedPoint {
  using Value = std::int32_t;
  static constexpr Value kNever = std::numeric_limits<Value>::min();
  /// The sum of no plan is larger than this, in units: so a sum and one more reward still fit.
  static constexpr double kMostSum = (1 << 30) - 1024;
  static constexpr double kLargestSum = 1e290;

  /// How many units make 1: a power of ten.
  double per_unit = 1;
  /// The greatest size of a reward that can be held, and of the reward of the step that completes.
  double most_step = 0;
  double most_last = 0;

  /// Chooses the finest unit for rewards of these sizes.
  FixedPoint(std::size_t connections, double step, double last) {
    const double sum = static_cast<double>(connections) * step + last;
    if (sum > kLargestSum) {
      // A unit in which forty of the largest doubles fit.
      per_unit = 1e-302;
      most_step = most_last = std::numeric_limits<double>::max();
      return;
    }
    if (sum == 0) return;
    int power = static_cast<int>(std::max(std::ceil(std::log10(sum / kMostSum)), -300.0));
    while (sum > kMostSum * std::pow(10.0, power)) ++power;
    per_unit = power <= 0 ? std::pow(10.0, -power) : 1 / std::pow(10.0, power);
    const double room = kMostSum / (sum * per_unit);
    most_step = step * room;
    most_last = last * room;
  }

  [[nodiscard]] Value rounded(double reward) const {
    const double units = reward * per_unit;
    return static_cast<Value>(units + (units < 0 ? -0.5 : 0.5));
  }
  [[nodiscard]] double value(Value value) const { return value / per_unit; }
  [[nodiscard]] bool holds(double reward, bool completes) const {
    return std::abs(reward) <= (completes ? most_last : most_step);
  }
  [[nodiscard]] double error(double reward) const {
    return std::abs(reward - value(rounded(reward)));
  }
  static Value plus(Value reward, Value left) { return left == kNever ? kNever : reward + left; }
};

}  // namespace orasp::detail
