#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// The largest problem that `exhaustive` accepts: 12! = 479,001,600 sequences take a few minutes.
inline constexpr std::size_t kExhaustiveMaxConnections = 12;

/// Why exhaustive() does not take the problem; empty where it does.
[[nodiscard]] std::optional<std::string> exhaustive_obstacle(const TransitionSystem& system);

/// Tries every legal sequence: the tree H~, not the graph H. For checking other methods on small
/// problems.
///
/// Guarantee.  Exact, by having looked at everything: no bound, no table, nothing to get wrong.
/// Cost.       O(connections!) time, O(connections) memory.
/// Limit.      kExhaustiveMaxConnections.
/// Repeatable. Ties go to the lexicographically smallest sequence.
/// @throws Refusal above the limit: exhaustive_obstacle().
[[nodiscard]] Result exhaustive(const TransitionSystem& system, const Budget& budget);

}  // namespace orasp
