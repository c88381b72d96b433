#pragma once

#include <cstdint>

namespace orasp {

/// A small generator of random numbers. The same seed gives the same numbers on every machine and
/// with every standard library, which `<random>` does not promise for its distributions.
///
/// Reference: SplitMix64, Steele, Lea and Flood (2014), OOPSLA, 453-472.
///
///     SplitMix64 random(seed);
///     const std::uint64_t die = 1 + random.below(6);
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}
  /// All 64 bits are random.
  [[nodiscard]] std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  /// A number from 0 to bound - 1, each equally likely: draws that would favour small numbers are
  /// thrown away. `bound` is at least 1.
  [[nodiscard]] std::uint64_t below(std::uint64_t bound) {
    const std::uint64_t threshold = (0 - bound) % bound;
    while (true) {
      const std::uint64_t draw = next();
      if (draw >= threshold) return draw % bound;
    }
  }
  /// A number of the interval [0, 1).
  [[nodiscard]] double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  /// A generator that is made with this number as its seed goes on where this one stands.
  [[nodiscard]] std::uint64_t state() const { return state_; }

 private:
  std::uint64_t state_;
};

}  // namespace orasp
