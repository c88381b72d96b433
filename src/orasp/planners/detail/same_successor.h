#pragma once

#include <cstddef>
#include <cstdint>

#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// Whether `one` without the connection `a` is `other` without `b`, by the sets themselves: what a
/// hash says is to be confirmed. O(words).
[[nodiscard]] inline bool same_successor(SetView one, ConnectionIndex a, SetView other,
                                         ConnectionIndex b) {
  for (std::size_t w = 0; w < one.size(); ++w) {
    std::uint64_t x = one[w];
    std::uint64_t y = other[w];
    if (w == a / 64) x &= ~(std::uint64_t{1} << (a % 64));
    if (w == b / 64) y &= ~(std::uint64_t{1} << (b % 64));
    if (x != y) return false;
  }
  return true;
}

}  // namespace orasp::detail
