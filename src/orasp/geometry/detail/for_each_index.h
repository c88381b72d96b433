#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "orasp/containers/parallel.h"
#include "orasp/geometry/contacts.h"

namespace orasp::detail {

/// Calls work(thread, index) for all indices below `count`, on as many threads as the settings say,
/// each of which takes the next index; throws Interrupted soon after the search is told to stop.
template <class Work>
void for_each_index(std::size_t count, const GeometrySettings& settings, Work&& work) {
  std::atomic<std::size_t> next = 0;
  const std::size_t threads =
      std::clamp<std::size_t>(settings.threads, 1, std::max<std::size_t>(1, count));
  run_parallel(threads, [&](std::size_t thread) {
    for (std::size_t index = next++; index < count; index = next++) {
      if (settings.stop.stop_requested()) throw Interrupted();
      work(thread, index);
    }
  });
}

}  // namespace orasp::detail
