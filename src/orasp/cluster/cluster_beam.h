#pragma once

#include "orasp/cluster/ranks.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/beam.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// The search of beam() with its work shared among ranks.
///
/// Idea.       Every rank holds the layers and goes through the same passes. Of each run of 1,024
///             states of a layer it expands a share; the successors that the ranks found are told
///             to all, and merged by each in the order of the layer, as those of threads are.
/// Guarantee.  Of beam(): any number of ranks gives its plan, reward, bound and status, on every
///             rank, unless a limit ends it, which then may be at another place.
/// Cost.       Expansions and bounds are shared, merging is not; memory as beam() on each rank. A
///             successor is told in 40 bytes to each other rank.
/// Stop.       What stops one rank stops all of them after the same states.
/// @throws Refusal on every rank where steps are wide or attempts may fail.
[[nodiscard]] Result cluster_beam(const TransitionSystem& system, BeamOptions options,
                                  const Budget& budget, Ranks& ranks);

}  // namespace orasp
