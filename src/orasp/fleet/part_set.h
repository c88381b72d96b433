#pragma once

#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "orasp/model/connection_set.h"

namespace orasp {

/// A set of parts of a fixed number of 64-bit words, with the operators of an unsigned integer: bit
/// i stands for part i. For products of more parts than a machine word has bits.
template <std::size_t kWords>
struct PartSet {
  std::array<std::uint64_t, kWords> words{};

  constexpr PartSet() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): as an integer is
  constexpr PartSet(std::uint64_t low) { words[0] = low; }

  friend constexpr auto operator<=>(const PartSet&, const PartSet&) = default;
  friend constexpr bool operator==(const PartSet&, const PartSet&) = default;
  constexpr PartSet& operator&=(const PartSet& other) {
    for (std::size_t w = 0; w < kWords; ++w) words[w] &= other.words[w];
    return *this;
  }
  constexpr PartSet& operator|=(const PartSet& other) {
    for (std::size_t w = 0; w < kWords; ++w) words[w] |= other.words[w];
    return *this;
  }
  friend constexpr PartSet operator&(PartSet a, const PartSet& b) { return a &= b; }
  friend constexpr PartSet operator|(PartSet a, const PartSet& b) { return a |= b; }
  friend constexpr PartSet operator~(PartSet a) {
    for (std::uint64_t& word : a.words) word = ~word;
    return a;
  }
};

/// What the searches for fleets use as sets of at most 64 * kWords parts.
template <std::size_t kWords>
using PartsIn = std::conditional_t<kWords == 1, std::uint64_t, PartSet<kWords>>;

template <class Parts>
inline constexpr std::size_t kWordsOf = sizeof(Parts) / sizeof(std::uint64_t);
/// The most parts of a product whose sets of parts are `Parts`.
template <class Parts>
inline constexpr std::size_t kMostParts = 64 * kWordsOf<Parts>;

[[nodiscard]] constexpr const std::uint64_t* words_of(const std::uint64_t& parts) {
  return &parts;
}
template <std::size_t kWords>
[[nodiscard]] constexpr const std::uint64_t* words_of(const PartSet<kWords>& parts) {
  return parts.words.data();
}
template <class Parts>
[[nodiscard]] constexpr Parts from_words(const std::uint64_t* words) {
  if constexpr (kWordsOf<Parts> == 1) {
    return *words;
  } else {
    Parts parts;
    for (std::size_t w = 0; w < kWordsOf<Parts>; ++w) parts.words[w] = words[w];
    return parts;
  }
}

template <class Parts>
[[nodiscard]] constexpr std::size_t size_of(const Parts& parts) {
  std::size_t size = 0;
  for (std::size_t w = 0; w < kWordsOf<Parts>; ++w)
    size += static_cast<std::size_t>(std::popcount(words_of(parts)[w]));
  return size;
}

/// The set of one part.
template <class Parts>
[[nodiscard]] constexpr Parts only(std::size_t part) {
  if constexpr (kWordsOf<Parts> == 1) {
    return Parts{1} << part;
  } else {
    Parts parts;
    parts.words[part / 64] = std::uint64_t{1} << (part % 64);
    return parts;
  }
}

template <class Parts>
[[nodiscard]] constexpr bool holds(const Parts& parts, std::size_t part) {
  return (words_of(parts)[part / 64] >> (part % 64) & 1U) != 0;
}

/// The first part of a set that is not empty.
template <class Parts>
[[nodiscard]] constexpr std::size_t first_of(const Parts& parts) {
  std::size_t w = 0;
  while (w + 1 < kWordsOf<Parts> && words_of(parts)[w] == 0) ++w;
  return 64 * w + static_cast<std::size_t>(std::countr_zero(words_of(parts)[w]));
}

/// The set of that part alone, and the set without it; empty of an empty set.
template <class Parts>
[[nodiscard]] constexpr Parts lowest(const Parts& parts) {
  if constexpr (kWordsOf<Parts> == 1) {
    return parts & (~parts + 1);
  } else {
    return parts == 0 ? parts : only<Parts>(first_of(parts));
  }
}
template <class Parts>
[[nodiscard]] constexpr Parts without_first(const Parts& parts) {
  if constexpr (kWordsOf<Parts> == 1) {
    return parts & (parts - 1);
  } else {
    return parts & ~lowest(parts);
  }
}

/// The parts after `part`.
template <class Parts>
[[nodiscard]] constexpr Parts after(std::size_t part) {
  if constexpr (kWordsOf<Parts> == 1) {
    return ~(only<Parts>(part) | (only<Parts>(part) - 1));
  } else {
    Parts parts;
    for (std::size_t w = part / 64; w < kWordsOf<Parts>; ++w)
      parts.words[w] = w == part / 64 ? after<std::uint64_t>(part % 64) : ~std::uint64_t{0};
    return parts;
  }
}

template <class Parts>
[[nodiscard]] constexpr std::uint64_t hash_of(const Parts& parts) {
  std::uint64_t hash = words_of(parts)[0];
  for (std::size_t w = 1; w < kWordsOf<Parts>; ++w)
    hash = mixed(hash + 0x9e3779b97f4a7c15ULL) ^ words_of(parts)[w];
  return hash;
}

/// Calls `visit(part)` for each part of a set, ascending.
template <class Parts, class Visit>
void for_each_part(const Parts& parts, Visit&& visit) {
  for (std::size_t w = 0; w < kWordsOf<Parts>; ++w) {
    for (std::uint64_t word = words_of(parts)[w]; word != 0; word &= word - 1)
      visit(64 * w + static_cast<std::size_t>(std::countr_zero(word)));
  }
}

/// Instantiates a class template for every size of product.
#define ORASP_FOR_EVERY_PART_SET(Class) \
  template class Class<PartsIn<1>>;     \
  template class Class<PartsIn<2>>;     \
  template class Class<PartsIn<4>>;     \
  template class Class<PartsIn<16>>

/// The largest product whose steps are worked out by sets of parts.
inline constexpr std::size_t kFleetMaxParts = kMostParts<PartsIn<16>>;

}  // namespace orasp
