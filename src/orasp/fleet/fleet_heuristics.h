#pragma once

#include <optional>
#include <string>

#include "orasp/fleet/fleet.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Why the heuristics below do not take the product: its connections have a cycle. Empty where they
/// take it.
[[nodiscard]] std::optional<std::string> fleet_heuristics_obstacle(const FleetProblem& fleet);

/// The two heuristics that were published beside the integer program, for products whose pieces are
/// trees.
///
/// Problem.    FleetProblem, with an eye on the number of steps alone. Precedence, blocking and
///             limits are not looked at.
/// Idea.       Each piece is labelled from its leaves inwards: the part that is peeled last is the
///             root, a weight is the number of parts below and with a part (of the root without the
///             heaviest branch), a layer is the depth. Leaves near the root come off first, one
///             robot each. fleet_greedy does that to the first piece alone and never makes a second
///             subassembly. fleet_fast does it to all pieces, small ones first, and then lets
///             leaves grow to their parents: everything below the parent is carried off as one
///             subassembly, as long as robots and sites suffice and it is no larger than its share,
///             size / (single leaves + subassemblies + 1).
/// Reference.  Culbertson, Bandyopadhyay and Schwager, IROS 2019.
/// Adapted.    Where only the root of a piece would be left, a neighbour stays with it: a single
///             part may not wait at a site. What the published text leaves open: in a layer the
///             first child of each parent goes before any second. A subassembly goes to the free
///             site with the least distance from here plus to the depot.
/// Guarantee.  None on the number of steps. Feasible where the plan keeps every rule, which
///             evaluate() of fleet/fleet_validate.h says; else Unknown, with the first rule that it
///             breaks. Unknown too where it needs more than FleetOptions::steps. No bound.
/// Cost.       O(steps * parts * robots). Any size.
/// Repeatable. Ties by position in the file; no randomness.
/// @throws Refusal where the connections of the product have a cycle.
[[nodiscard]] Result fleet_fast(const FleetProblem& fleet, const FleetOptions& options,
                                const Budget& budget);
[[nodiscard]] Result fleet_greedy(const FleetProblem& fleet, const FleetOptions& options,
                                  const Budget& budget);

}  // namespace orasp
