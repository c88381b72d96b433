#pragma once

#include <cstdint>

#include "orasp/model/problem.h"

namespace orasp {

/// A small random problem with symmetries planted in it, at most 9 connections: equal parts on a
/// hub, copies of subtrees, rings, grids, pieces apart, equal connections side by side; with
/// constraints, bases and objectives of every kind that keep them, in any order of the file, and
/// now and then with something that breaks some of them. Over a few hundred seeds every kind occurs
/// with every other.
[[nodiscard]] ProblemSpec symmetric_problem(std::uint64_t seed);

}  // namespace orasp
