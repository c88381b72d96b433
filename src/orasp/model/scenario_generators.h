#pragma once

#include <cstddef>
#include <cstdint>

#include "orasp/model/problem.h"

namespace orasp {

/// Families of problems for tests and measurements. Parts are named "1" to "N"; the objective is
/// `cubesat`. The same arguments give the same problem on every machine (model/random.h).

/// Parts 1 - 2 - ... - N in a row. @throws InputError unless 1 <= parts <= kMaxParts.
[[nodiscard]] ProblemSpec chain(std::size_t parts);
/// R rows of C parts, each joined to its right and lower neighbour; positions on a unit raster (x
/// right, y down).
[[nodiscard]] ProblemSpec grid(std::size_t rows, std::size_t columns);
/// A uniformly random labelled tree (Pruefer 1918: each code of N - 2 labels is one tree).
[[nodiscard]] ProblemSpec random_tree(std::size_t parts, std::uint64_t seed);
/// A connected graph without parallel connections: a uniformly random labelled tree and
/// `connections - parts + 1` further pairs, uniform among those left. @throws InputError unless
/// parts - 1 <= connections <= parts (parts-1)/2.
[[nodiscard]] ProblemSpec random_graph(std::size_t parts, std::size_t connections,
                                       std::uint64_t seed);

}  // namespace orasp
