#pragma once

#include <cstdint>
#include <functional>

#include "orasp/model/detail/listing.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// For the time that it lives, a list of the legal steps of `system` is left by ListingStopped
/// where `budget` is spent: the clock, a request to stop, or the memory that the list itself takes.
class ListingWatch {
 public:
  /// Both must outlive it.
  ListingWatch(const TransitionSystem& system, const Budget& budget);
  ListingWatch(const ListingWatch&) = delete;
  ListingWatch& operator=(const ListingWatch&) = delete;
  ~ListingWatch();

  /// Why a list was left.
  [[nodiscard]] Stop reason(const ListingStopped& stopped) const;

 private:
  [[nodiscard]] Stop expired(std::uint64_t bytes) const;

  const TransitionSystem& system_;
  const Budget& budget_;
  std::uint64_t allowed_;
  std::function<bool(std::uint64_t)> before_;
};

}  // namespace orasp::detail
