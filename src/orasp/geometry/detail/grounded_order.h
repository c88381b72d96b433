#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "orasp/geometry/detail/take_apart.h"

namespace orasp::detail {

/// Whether the parts of `group`, which hang together, come off `base` one by one so that all that
/// is left always hangs together: built the other way round, each part is put onto what stands.
///
/// Guarantee. Yes is proved by an order; no only says that taking the first free part each time
///            does not end well.
/// Cost.      O(parts * joints) and O(facts).
[[nodiscard]] bool has_grounded_order(
    std::span<const std::uint32_t> group, std::uint32_t base, std::size_t directions,
    std::span<const BlockedAlong> blocked,
    std::span<const std::pair<std::uint32_t, std::uint32_t>> joined);

}  // namespace orasp::detail
