#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace orasp::detail {

/// A set of parts as bits, kWords words of them. All operations are short loops over the words.
template <std::size_t kWords>
struct PartSet {
  std::array<std::uint64_t, kWords> words{};

  void insert(std::size_t part) { words[part / 64] |= std::uint64_t{1} << (part % 64); }
  [[nodiscard]] bool contains(std::size_t part) const {
    return (words[part / 64] >> (part % 64) & 1U) != 0;
  }
  [[nodiscard]] std::size_t size() const {
    std::size_t sum = 0;
    for (const std::uint64_t word : words) sum += static_cast<std::size_t>(std::popcount(word));
    return sum;
  }
  [[nodiscard]] bool empty() const {
    return std::ranges::all_of(words, [](std::uint64_t word) { return word == 0; });
  }
  /// The lowest part of a set that is not empty.
  [[nodiscard]] std::size_t first() const {
    std::size_t w = 0;
    while (words[w] == 0) ++w;
    return w * 64 + static_cast<std::size_t>(std::countr_zero(words[w]));
  }
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t w = 0; w < kWords; ++w) {
      for (std::uint64_t word = words[w]; word != 0; word &= word - 1)
        visit(w * 64 + static_cast<std::size_t>(std::countr_zero(word)));
    }
  }
  friend PartSet operator&(PartSet a, const PartSet& b) {
    for (std::size_t w = 0; w < kWords; ++w) a.words[w] &= b.words[w];
    return a;
  }
  friend PartSet operator|(PartSet a, const PartSet& b) {
    for (std::size_t w = 0; w < kWords; ++w) a.words[w] |= b.words[w];
    return a;
  }
  friend PartSet operator-(PartSet a, const PartSet& b) {
    for (std::size_t w = 0; w < kWords; ++w) a.words[w] &= ~b.words[w];
    return a;
  }
  friend bool operator==(const PartSet&, const PartSet&) = default;
};

}  // namespace orasp::detail
