#pragma once

#include <cstdint>

namespace orasp::detail {

/// A state that best-first search has met and not yet expanded.
struct OpenState {
  std::int64_t promise;  ///< f, in units of a tick
  std::uint32_t state;
  std::uint32_t depth;

  /// The order of a heap with the best on top: the greatest promise, then the deepest state.
  [[nodiscard]] static bool later(const OpenState& a, const OpenState& b) {
    if (a.promise != b.promise) return a.promise < b.promise;
    if (a.depth != b.depth) return a.depth < b.depth;
    return a.state < b.state;
  }
};

}  // namespace orasp::detail
