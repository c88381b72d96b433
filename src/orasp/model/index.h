#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <type_traits>

namespace orasp {

/// A number that names a thing of one kind: its position in a list, from 0. `Kind` says of which
/// kind, and numbers of two kinds do not mix: they can be neither assigned nor compared. In all
/// else it is the integer: it comes from one, serves as one, and takes its room and its time.
///
///     PartIndex part = 3;                 // from an integer
///     problem.parts()[part];              // to an integer
///     for (part = 0; part < problem.num_parts(); ++part) ...
///     ConnectionIndex other = part;       // does not compile
///     if (other == part) ...              // does not compile
///     ConnectionIndex same_number = part.value();
template <class Kind, class Value = std::uint32_t>
class Index {
 public:
  constexpr Index() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): an integer is meant to become an index unasked.
  constexpr Index(Value value) : value_(value) {}
  /// From a wider integer by a cast alone: `static_cast<PartIndex>(parts.size())`.
  template <std::integral Wider>
  constexpr explicit Index(Wider value) : value_(static_cast<Value>(value)) {}
  template <class OtherKind, class OtherValue>
  Index(Index<OtherKind, OtherValue>) = delete;

  // NOLINTNEXTLINE(google-explicit-constructor): an index is meant to serve as an integer unasked.
  constexpr operator Value() const { return value_; }
  [[nodiscard]] constexpr Value value() const { return value_; }

  constexpr Index& operator++() {
    ++value_;
    return *this;
  }
  constexpr Index operator++(int) { return value_++; }
  constexpr Index& operator--() {
    --value_;
    return *this;
  }
  constexpr Index operator--(int) { return value_--; }
  constexpr Index& operator+=(Value step) {
    value_ += step;
    return *this;
  }
  constexpr Index& operator-=(Value step) {
    value_ -= step;
    return *this;
  }

 private:
  Value value_ = 0;
};

// Two indices of one kind compare as the integers that they turn into; of two kinds, not at all.
template <class A, class AValue, class B, class BValue>
requires(!std::is_same_v<A, B>) bool operator==(Index<A, AValue>, Index<B, BValue>) = delete;
template <class A, class AValue, class B, class BValue>
requires(!std::is_same_v<A, B>) bool operator!=(Index<A, AValue>, Index<B, BValue>) = delete;
template <class A, class AValue, class B, class BValue>
requires(!std::is_same_v<A, B>) bool operator<(Index<A, AValue>, Index<B, BValue>) = delete;
template <class A, class AValue, class B, class BValue>
requires(!std::is_same_v<A, B>) bool operator>(Index<A, AValue>, Index<B, BValue>) = delete;
template <class A, class AValue, class B, class BValue>
requires(!std::is_same_v<A, B>) bool operator<=(Index<A, AValue>, Index<B, BValue>) = delete;
template <class A, class AValue, class B, class BValue>
requires(!std::is_same_v<A, B>) bool operator>=(Index<A, AValue>, Index<B, BValue>) = delete;

/// A part's position in Problem::parts().
using PartIndex = Index<struct PartKind>;
/// A connection's position in Problem::connections().
using ConnectionIndex = Index<struct ConnectionKind>;

}  // namespace orasp

template <class Kind, class Value>
struct std::hash<orasp::Index<Kind, Value>> : std::hash<Value> {};

template <class Kind, class Value>
struct std::numeric_limits<orasp::Index<Kind, Value>> : std::numeric_limits<Value> {};
