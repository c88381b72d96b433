#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "orasp/containers/growing_array.h"
#include "orasp/model/connection_set.h"

namespace orasp::detail {

/// A set of keys of a fixed number of 64-bit words, each with a dense number from 0 in order of
/// insertion.
///
/// Layout.     Keys stand one after another; an open-addressed index of 8-byte slots (32 bits of
///             the hash, number + 1) points at them. Linear probing, at most 2/3 full. So per key:
///             its words and 12 to 24 bytes.
/// Limit.      2^32 - 2 keys. kWords is the number of words where it is known when compiling, or 0.
template <std::size_t kWords>
class StateTable {
 public:
  static constexpr std::uint32_t kAbsent = 0xffffffffU;
  /// Words of a key, known when compiling where kWords is.
  [[nodiscard]] static constexpr std::size_t words(std::size_t given) {
    return kWords == 0 ? given : kWords;
  }

  explicit StateTable(std::size_t words) : words_(kWords == 0 ? words : kWords) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const std::uint64_t* key(std::uint32_t number) const {
    return keys_.data() + static_cast<std::size_t>(number) * words();
  }
  [[nodiscard]] std::span<const std::uint64_t> keys() const { return keys_.span(); }
  [[nodiscard]] std::uint64_t bytes() const { return keys_.bytes() + slots_.bytes(); }
  /// The most it holds once `more` keys have come in: its index doubles now and then.
  [[nodiscard]] std::uint64_t bytes_with(std::size_t more) const {
    std::uint64_t slots = std::max<std::uint64_t>(64, slots_.size());
    while ((size_ + more) * 3 >= slots * 2) slots *= 2;
    return ((size_ + more) * words() + slots) * sizeof(std::uint64_t);
  }
  [[nodiscard]] std::uint64_t hash(const std::uint64_t* key) const {
    if constexpr (kWords == 1) {
      return mixed(*key);
    } else {
      return hash_value({key, words()});
    }
  }

  struct Inserted {
    std::uint32_t number;
    bool is_new;
  };
  /// The number of `key`, which is added if it is not there. `hash` is hash(key).
  Inserted insert(const std::uint64_t* key, std::uint64_t hash) {
    if (size_ * 3 >= slots_.size() * 2) grow();
    const std::uint64_t tag = hash >> 32;
    std::size_t i = hash & mask_;
    while (slots_[i] != 0) {
      if (slots_[i] >> 32 == tag) {
        const auto number = static_cast<std::uint32_t>(slots_[i]) - 1;
        if (equal(number, key)) return {number, false};
      }
      i = (i + 1) & mask_;
    }
    const auto number = static_cast<std::uint32_t>(size_++);
    slots_[i] = tag << 32 | (number + 1U);
    for (std::size_t w = 0; w < words(); ++w) keys_.push_back(key[w]);
    return {number, true};
  }
  Inserted insert(const std::uint64_t* key) { return insert(key, hash(key)); }

  /// Fetches the place of a hash into the cache: for many keys that are asked for soon.
  void prefetch(std::uint64_t hash) const {
    if (size_ > 0) __builtin_prefetch(&slots_[hash & mask_]);
  }

  /// The number of `key`, or kAbsent.
  [[nodiscard]] std::uint32_t find(const std::uint64_t* key) const { return find(key, hash(key)); }
  /// The same where `hash` is hash(key).
  [[nodiscard]] std::uint32_t find(const std::uint64_t* key, std::uint64_t hash) const {
    if (size_ == 0) return kAbsent;
    for (std::size_t i = hash & mask_; slots_[i] != 0; i = (i + 1) & mask_) {
      if (slots_[i] >> 32 != hash >> 32) continue;
      const auto number = static_cast<std::uint32_t>(slots_[i]) - 1;
      if (equal(number, key)) return number;
    }
    return kAbsent;
  }
  /// Forgets all keys and keeps the memory.
  void clear() {
    keys_.clear();
    size_ = 0;
    std::ranges::fill(slots_.span(), std::uint64_t{0});
  }

 private:
  [[nodiscard]] std::size_t words() const { return words(words_); }
  [[nodiscard]] bool equal(std::uint32_t number, const std::uint64_t* key) const {
    // Word by word: comparing two ranges is a call of its own.
    const std::uint64_t* const mine = this->key(number);
    for (std::size_t w = 0; w < words(); ++w) {
      if (key[w] != mine[w]) return false;
    }
    return true;
  }
  void grow() {
    slots_.resize(std::max<std::size_t>(64, slots_.size() * 2));
    mask_ = slots_.size() - 1;
    std::ranges::fill(slots_.span(), std::uint64_t{0});
    for (std::uint32_t number = 0; number < size_; ++number) {
      const std::uint64_t h = hash(key(number));
      std::size_t i = h & mask_;
      while (slots_[i] != 0) i = (i + 1) & mask_;
      slots_[i] = h >> 32 << 32 | (number + 1U);
    }
  }

  std::size_t words_;
  std::size_t size_ = 0;
  std::size_t mask_ = 0;
  GrowingArray<std::uint64_t> keys_;
  GrowingArray<std::uint64_t> slots_;
};

}  // namespace orasp::detail
