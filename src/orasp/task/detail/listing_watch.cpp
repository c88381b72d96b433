#include "orasp/task/detail/listing_watch.h"

#include <utility>

#include "orasp/model/detail/rules.h"
#include "orasp/task/memory_limit.h"

namespace orasp::detail {

ListingWatch::ListingWatch(const TransitionSystem& system, const Budget& budget)
    : system_(system), budget_(budget), allowed_(allowed_bytes(budget)) {
  std::function<bool(std::uint64_t)>& stop = system_.rules().listing.stop;
  before_ =
      std::exchange(stop, [this](std::uint64_t bytes) { return expired(bytes) != Stop::None; });
}

ListingWatch::~ListingWatch() {
  system_.rules().listing.stop = std::move(before_);
}

Stop ListingWatch::expired(std::uint64_t bytes) const {
  return bytes > allowed_ ? Stop::MemoryLimit : budget_.expired(bytes);
}

Stop ListingWatch::reason(const ListingStopped& stopped) const {
  const Stop stop = expired(stopped.bytes);
  return stop == Stop::None ? Stop::TimeLimit : stop;
}

}  // namespace orasp::detail
