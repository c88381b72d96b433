#pragma once

#include <algorithm>
#include <bit>
#include <cassert>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "orasp/model/index.h"

namespace orasp {

/// The machine words of a set of connections: bit c % 64 of word c / 64 stands for connection c.
/// Unused high bits are 0. This is the form in which planners' tables hold states; it owns nothing.
using SetView = std::span<const std::uint64_t>;

/// Number of 64-bit words that hold a set over `universe` connections (at least 1).
[[nodiscard]] constexpr std::size_t words_for(std::size_t universe) {
  return universe == 0 ? 1 : (universe + 63) / 64;
}

[[nodiscard]] inline bool contains(SetView set, ConnectionIndex connection) {
  return (set[connection / 64] >> (connection % 64) & 1U) != 0;
}

[[nodiscard]] inline std::size_t count(SetView set) {
  std::size_t total = 0;
  for (const std::uint64_t word : set) total += static_cast<std::size_t>(std::popcount(word));
  return total;
}

/// Calls `visit(c)` for each connection c of the set, in ascending order.
template <class Visit>
void for_each_connection(SetView set, Visit&& visit) {
  for (std::size_t w = 0; w < set.size(); ++w) {
    for (std::uint64_t word = set[w]; word != 0; word &= word - 1) {
      visit(
          static_cast<ConnectionIndex>(w * 64 + static_cast<std::size_t>(std::countr_zero(word))));
    }
  }
}

/// A set of connections: the state of an assembly. A value type: `==`, `<=>` and std::hash; one
/// machine word and no allocation for up to 64 connections, an array of words beyond. Comparing
/// sets over different universes is a mistake of the caller.
///
///     ConnectionSet s(12);          // the empty set over connections 0 .. 11
///     s.insert(3);
///     s.contains(3);                // true
///     s.size();                     // 1
class ConnectionSet {
 public:
  ConnectionSet() = default;
  /// The empty set over connections 0 .. universe - 1.
  explicit ConnectionSet(std::size_t universe) : universe_(universe) {
    if (words() > 1) many_ = std::make_unique<std::uint64_t[]>(words());
  }
  /// The set whose words are `view`.
  ConnectionSet(std::size_t universe, SetView view) : ConnectionSet(universe) {
    assert(view.size() == words());
    std::copy(view.begin(), view.end(), data());
  }
  /// All of 0 .. universe - 1.
  [[nodiscard]] static ConnectionSet all(std::size_t universe) {
    ConnectionSet set(universe);
    for (std::size_t c = 0; c < universe; ++c) set.insert(static_cast<ConnectionIndex>(c));
    return set;
  }

  ConnectionSet(const ConnectionSet& other) : ConnectionSet(other.universe_) {
    std::copy_n(other.data(), words(), data());
  }
  ConnectionSet(ConnectionSet&& other) noexcept = default;
  ConnectionSet& operator=(const ConnectionSet& other) {
    if (this != &other) *this = ConnectionSet(other);
    return *this;
  }
  ConnectionSet& operator=(ConnectionSet&& other) noexcept = default;
  ~ConnectionSet() = default;

  void insert(ConnectionIndex connection) {
    assert(connection < universe_);
    data()[connection / 64] |= std::uint64_t{1} << (connection % 64);
  }
  void erase(ConnectionIndex connection) {
    assert(connection < universe_);
    data()[connection / 64] &= ~(std::uint64_t{1} << (connection % 64));
  }
  [[nodiscard]] bool contains(ConnectionIndex connection) const {
    return orasp::contains(view(), connection);
  }
  [[nodiscard]] std::size_t size() const { return orasp::count(view()); }
  [[nodiscard]] bool empty() const { return size() == 0; }
  [[nodiscard]] std::size_t universe() const { return universe_; }
  [[nodiscard]] SetView view() const { return {data(), words()}; }

  friend bool operator==(const ConnectionSet& a, const ConnectionSet& b) {
    return std::ranges::equal(a.view(), b.view());
  }
  friend std::strong_ordering operator<=>(const ConnectionSet& a, const ConnectionSet& b) {
    const SetView left = a.view();
    const SetView right = b.view();
    return std::lexicographical_compare_three_way(left.rbegin(), left.rend(), right.rbegin(),
                                                  right.rend());
  }

 private:
  [[nodiscard]] std::size_t words() const { return words_for(universe_); }
  [[nodiscard]] std::uint64_t* data() { return many_ ? many_.get() : &one_; }
  [[nodiscard]] const std::uint64_t* data() const { return many_ ? many_.get() : &one_; }

  std::size_t universe_ = 0;
  std::uint64_t one_ = 0;
  std::unique_ptr<std::uint64_t[]> many_;
};

/// Mixes one word so that all 64 bits of the result depend on all bits of `x` (a bijection).
/// Reference: the finaliser of MurmurHash3 (Appleby, public domain).
[[nodiscard]] constexpr std::uint64_t mixed(std::uint64_t x) {
  x ^= x >> 33;
  x *= 0xff51afd7ed558ccdULL;
  x ^= x >> 33;
  x *= 0xc4ceb9fe1a85ec53ULL;
  x ^= x >> 33;
  return x;
}

[[nodiscard]] inline std::uint64_t hash_value(SetView set) {
  std::uint64_t hash = 0;
  for (const std::uint64_t word : set) hash = mixed(hash ^ word) + 0x9e3779b97f4a7c15ULL;
  return hash;
}

}  // namespace orasp

template <>
struct std::hash<orasp::ConnectionSet> {
  std::size_t operator()(const orasp::ConnectionSet& set) const noexcept {
    return static_cast<std::size_t>(orasp::hash_value(set.view()));
  }
};
