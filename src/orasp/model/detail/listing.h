#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>

namespace orasp::detail {

/// How legal steps are listed; no part of what the rules say. Where steps take parts off, a state
/// may have exponentially many: any connected set of parts may be one. So a list can be left before
/// its end, and cut short.
struct Listing {
  /// Of the steps that take parts off, those of at most so many parts; of those that put parts on,
  /// those that join at most so many pieces to another. A state may seem a dead end that is none.
  std::size_t most = std::numeric_limits<std::size_t>::max();
  /// Asked now and then, with the bytes of the list so far: whether to leave it, by throwing
  /// ListingStopped. Empty: never.
  std::function<bool(std::uint64_t bytes)> stop{};
};

/// A list of legal steps was left. Whoever listed them makes another Expander to go on.
struct ListingStopped {
  std::uint64_t bytes = 0;  ///< of the list so far
};

}  // namespace orasp::detail
