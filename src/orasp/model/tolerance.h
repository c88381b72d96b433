#pragma once

#include <limits>

namespace orasp {

/// What an unknown bound and the reward of a missing plan are, with the sign that fits.
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Masses and lengths are sums of decimal numbers in binary. Two of them that differ by less than
/// this share of their size are the same number to a user: 0.1 + 0.2 and 0.3, for example.
inline constexpr double kRelativeTolerance = 1e-9;

/// The reward of a plan is a sum of up to thousands of binary numbers. A difference between two
/// plans that is smaller than this comes from rounding and is not taken for a preference.
inline constexpr double kRewardTolerance = 1e-10;

}  // namespace orasp
