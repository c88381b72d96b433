#pragma once

#include <algorithm>
#include <cmath>

#include "orasp/certificate/detail/outward.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// How often a connection is tried on average until an attempt succeeds, which it does with
/// probability p: 1 / p times, a number between these two.
struct Attempts {
  double least = 1;
  double most = 1;
};

[[nodiscard]] inline Attempts attempts_at(const Problem& problem, ConnectionIndex connection) {
  const double success = problem.connections()[connection].success;
  if (success >= 1) return {};
  const double nearest = 1 / success;
  return {.least = std::max(1.0, std::nextafter(nearest, 0.0)), .most = up(nearest)};
}

/// Those of both.
[[nodiscard]] inline Attempts united(const Attempts& one, const Attempts& other) {
  return {.least = std::min(one.least, other.least), .most = std::max(one.most, other.most)};
}

/// The most that so many attempts earn together, of which each earns `reward` at most.
[[nodiscard]] inline double all_together(double reward, const Attempts& attempts) {
  if (attempts.most == 1) return reward;
  return std::max(multiply_up(reward, attempts.least), multiply_up(reward, attempts.most));
}

}  // namespace orasp::detail
