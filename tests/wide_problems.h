#pragma once

#include <cstdint>

#include "orasp/model/problem.h"

namespace orasp {

/// A small random problem of the wider world: 0 to 7 connections, 1 to 7 parts, and over a few
/// hundred seeds every key that a problem for one robot may have, in all combinations that are
/// valid: base, grounded pieces, goals of every kind, numbers, attributes, places, costs between
/// consecutive steps, part steps, precedence stated either way, limits, blocking, both directions,
/// every objective type alone and in sums. About one in seven has no plan. All attempts succeed.
/// The same seed gives the same problem on every machine.
[[nodiscard]] ProblemSpec wide_random_problem(std::uint64_t seed);

}  // namespace orasp
