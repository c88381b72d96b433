#include "orasp/task/detail/listing_watch.h"

#include <utility>

#include "orasp/model/detail/rules.h"
#include "orasp/task/memory_limit.h"

namespace orasp::detail {

ListingScope::ListingScope(const TransitionSystem& system, Listing listing)
    : system_(system), before_(std::exchange(system.rules().listing, std::move(listing))) {}

ListingScope::~ListingScope() {
  system_.rules().listing = std::move(before_);
}

ListingWatch::ListingWatch(const TransitionSystem& system, const Budget& budget)
    : budget_(budget),
      allowed_(allowed_bytes(budget)),
      scope_(system, {.most = system.rules().listing.most, .stop = [this](std::uint64_t bytes) {
                        return expired(bytes) != Stop::None;
                      }}) {}

Stop ListingWatch::expired(std::uint64_t bytes) const {
  return bytes > allowed_ ? Stop::MemoryLimit : budget_.expired(bytes);
}

Stop ListingWatch::reason(const ListingStopped& stopped) const {
  const Stop stop = expired(stopped.bytes);
  return stop == Stop::None ? Stop::TimeLimit : stop;
}

}  // namespace orasp::detail
