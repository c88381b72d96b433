#pragma once

#include <cstdint>

#include "orasp/model/detail/listing.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// For the time that it lives, the legal steps of `system` are listed as `listing` says.
class ListingScope {
 public:
  /// The system must outlive it.
  ListingScope(const TransitionSystem& system, Listing listing);
  ListingScope(const ListingScope&) = delete;
  ListingScope& operator=(const ListingScope&) = delete;
  ~ListingScope();

 private:
  const TransitionSystem& system_;
  Listing before_;
};

/// For the time that it lives, a list of the legal steps of `system` is left by ListingStopped
/// where `budget` is spent: the clock, a request to stop, or the memory that the list itself takes.
class ListingWatch {
 public:
  /// Both must outlive it.
  ListingWatch(const TransitionSystem& system, const Budget& budget);

  /// Why a list was left.
  [[nodiscard]] Stop reason(const ListingStopped& stopped) const;

 private:
  [[nodiscard]] Stop expired(std::uint64_t bytes) const;

  const Budget& budget_;
  std::uint64_t allowed_;
  ListingScope scope_;
};

}  // namespace orasp::detail
