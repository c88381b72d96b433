#pragma once

#include "orasp/cluster/ranks.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/a_star.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Finds an optimal plan by A* whose states lie on several ranks.
///
/// Idea.       A hash of a state says which rank it belongs to: that one holds it, finds out
///             whether it is new or met by a better path, and expands it. Successors are sent to
///             their ranks in batches, and nobody waits for anybody: each rank expands what
///             promises most among its own states. So states are expanded that one process would
///             leave alone, and some again. The first plan is therefore not the best: it is told to
///             all, states that do not promise more are left alone, and the search ends when none
///             is left and nothing is under way. That is found out by rank 0, which asks all ranks
///             how much they sent and received: it is so where all are idle and the two sums are
///             equal, twice running.
/// Reference.  Kishimoto, Fukunaga and Botea (2009), Scalable, parallel best-first search for
///             optimal sequential planning, ICAPS; counting in waves: Mattern (1987), Distributed
///             Computing 2, 161-175.
/// Guarantee.  Of a_star(): the same optimum, status and bound on every rank, for any number of
///             ranks; of plans that are equally good it may be another one. Stopped early: the best
///             plan met or the quick plan, and the greatest promise of all ranks as a proved bound.
/// Cost.       Memory as a_star(), shared evenly. A successor is sent as its key and 24 bytes,
///             unless it belongs to the rank that found it: (K - 1) / K of them on K ranks.
/// Stop.       What stops one rank stops all; then what is under way is received, since it counts
///             for the bound.
/// @throws InputError on every rank where the bound knows nothing about the problem, where steps
/// are wide or attempts may fail, or where a reward is at fault.
[[nodiscard]] Result cluster_a_star(const TransitionSystem& system, const AStarOptions& options,
                                    const Budget& budget, Ranks& ranks);

}  // namespace orasp
