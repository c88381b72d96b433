#pragma once

#include <cstddef>
#include <cstdint>

#include "orasp/model/problem.h"

namespace orasp {

/// Families of problems for tests and measurements. Parts are named "1" to "N"; the objective is
/// `cubesat`. The same arguments give the same problem on every machine: the random ones use
/// SplitMix64 (Steele, Lea, Flood 2014) and unbiased rejection, nothing of <random>, whose
/// distributions differ between standard libraries.

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

/// SplitMix64: a small generator with the same numbers everywhere.
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}
  [[nodiscard]] std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  /// Uniform in 0 .. bound - 1, without bias; bound >= 1.
  [[nodiscard]] std::uint64_t below(std::uint64_t bound) {
    const std::uint64_t threshold = (0 - bound) % bound;
    while (true) {
      const std::uint64_t draw = next();
      if (draw >= threshold) return draw % bound;
    }
  }
  /// Uniform in [0, 1).
  [[nodiscard]] double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  /// A generator made with it as its seed goes on from here.
  [[nodiscard]] std::uint64_t state() const { return state_; }

 private:
  std::uint64_t state_;
};

}  // namespace orasp
