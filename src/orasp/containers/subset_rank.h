#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace orasp::detail {

/// Numbers the subsets of 0 .. 63 that have the same size, in ascending order of their masks.
///
/// Idea.       The combinatorial number system: the set b_0 < b_1 < ... has the rank sum of C(b_i,
///             i + 1). Taking b_j out leaves the terms below it and moves each one above it down a
///             place, so a prefix and a suffix sum give the ranks of all sets that are one smaller,
///             at two table look-ups each.
/// Reference.  Lehmer (1964), "The machine tools of combinatorics"; Knuth, TAOCP 4A, 7.2.1.3.
class SubsetRank {
 public:
  SubsetRank() {
    for (std::size_t n = 0; n < kBits; ++n) {
      choose_[n][0] = 1;
      for (std::size_t k = 1; k <= kBits; ++k) {
        choose_[n][k] = n == 0 ? 0 : choose_[n - 1][k - 1] + choose_[n - 1][k];
      }
    }
  }

  /// n over k, for n up to 63; 0 where k > n.
  [[nodiscard]] std::uint64_t choose(std::size_t n, std::size_t k) const { return choose_[n][k]; }

  /// Number of subsets of 0 .. n - 1 with k members, for n up to 64; at most 2^64 - 1 (no overflow:
  /// C(64, 32) < 2^61).
  [[nodiscard]] std::uint64_t subsets(std::size_t n, std::size_t k) const {
    if (k > n) return 0;
    if (n == 0) return 1;
    return choose_[n - 1][k] + (k == 0 ? 0 : choose_[n - 1][k - 1]);
  }

  /// Calls visit(member, rank of set without member) for each member, ascending.
  template <class Visit>
  void for_each_without(std::uint64_t set, Visit&& visit) const {
    std::array<std::uint64_t, kBits + 1> above;  // above[i]: sum of C(b_l, l) over l > i
    std::array<std::uint8_t, kBits> members;
    std::size_t size = 0;
    for (std::uint64_t rest = set; rest != 0; rest &= rest - 1) {
      members[size++] = static_cast<std::uint8_t>(std::countr_zero(rest));
    }
    std::uint64_t sum = 0;
    for (std::size_t i = size; i-- > 0;) {
      above[i] = sum;
      sum += choose_[members[i]][i];
    }
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < size; ++i) {
      visit(members[i], below + above[i]);
      below += choose_[members[i]][i + 1];
    }
  }

  /// The subset of rank 0 with `size` members, and the one after `set` (Gosper's hack; HAKMEM 1972,
  /// item 175).
  [[nodiscard]] static std::uint64_t first(std::size_t size) {
    return size == 0 ? 0 : ~std::uint64_t{0} >> (kBits - size);
  }
  [[nodiscard]] static std::uint64_t next(std::uint64_t set) {
    if (set == 0) return 0;
    const std::uint64_t lowest = set & (0 - set);
    const std::uint64_t ripple = set + lowest;
    return ripple | ((set ^ ripple) >> 2 >> std::countr_zero(lowest));
  }

 private:
  static constexpr std::size_t kBits = 64;
  std::array<std::array<std::uint64_t, kBits + 1>, kBits> choose_;
};

}  // namespace orasp::detail
