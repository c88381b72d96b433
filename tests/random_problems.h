#pragma once

#include <cstdint>

#include "orasp/model/problem.h"

namespace orasp {

/// A small random problem: 0 to 8 connections, 0 to 7 parts, and over a few hundred seeds every
/// constraint, every objective, both directions, several start pieces, single parts, parallel
/// connections, connections of a part to itself, precedence cycles, dead ends and problems without
/// a plan (agreement_test.cpp counts them). The same seed gives the same problem on every machine.
[[nodiscard]] ProblemSpec random_problem(std::uint64_t seed);

/// A larger one, too large for brute force but not for H: 7 to 12 connections, 8 to 11 parts, in
/// disassembly; else as above, with less blocking.
[[nodiscard]] ProblemSpec larger_random_problem(std::uint64_t seed);

/// The same problem with attempts that may fail: random `success`, and every kind of `on_failure`
/// (no `breaks` in assembly).
[[nodiscard]] ProblemSpec make_uncertain(ProblemSpec spec, std::uint64_t seed);

/// The same problem with the last pair of axes of its blocking replaced by `copies` pairs of named
/// directions, all blocked as it was.
[[nodiscard]] ProblemSpec with_named_directions(ProblemSpec spec, std::size_t copies);

/// A random objective of the given type, a name of kPlainObjectiveTypes or "callable".
[[nodiscard]] Objective random_objective(std::string_view type, std::uint64_t seed);

}  // namespace orasp
