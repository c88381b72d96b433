#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "orasp/model/problem.h"

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
    for (const std::uint64_t word : words) sum += count(word);
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
  /// The bits of a word that are set, by sums of ever longer fields: where the processor need not
  /// have an instruction for it, std::popcount is a call. Reference: Warren (2012), Hacker's
  /// Delight, 5-1.
  [[nodiscard]] static constexpr std::size_t count(std::uint64_t word) {
    word -= word >> 1U & 0x5555'5555'5555'5555U;
    word = (word & 0x3333'3333'3333'3333U) + (word >> 2U & 0x3333'3333'3333'3333U);
    word = (word + (word >> 4U)) & 0x0F0F'0F0F'0F0F'0F0FU;
    return word * 0x0101'0101'0101'0101U >> 56U;
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
  friend bool operator==(const PartSet& a, const PartSet& b) {
    // Word by word: comparing two arrays is a call of its own.
    std::uint64_t different = 0;
    for (std::size_t w = 0; w < kWords; ++w) different |= a.words[w] ^ b.words[w];
    return different == 0;
  }
};

/// Writes the parts of a set to `list`, ascending.
template <std::size_t kWords>
void list_parts(const PartSet<kWords>& set, std::vector<PartIndex>& list) {
  list.clear();
  set.for_each([&](std::size_t part) { list.push_back(static_cast<PartIndex>(part)); });
}

}  // namespace orasp::detail
