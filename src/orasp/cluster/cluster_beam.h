#pragma once

#include "orasp/cluster/ranks.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/beam.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// The search of beam() with its work shared among ranks.
///
/// Idea.       Each state belongs to the rank that its hash names. A rank holds the states of a
///             layer that are its own, expands them, and sends each successor to the rank that it
///             belongs to. Of what arrives all ranks together keep the best `width`: they count how
///             many promise more than a number, and narrow that down (detail/crew_cut.h). A plan
///             is followed back from rank to rank.
/// Reference.  Kishimoto, Fukunaga, Botea (2013), Evaluation of a simple, scalable, parallel
///             best-first search strategy, Artificial Intelligence 195, 222-248, for states that
///             belong to ranks by a hash.
/// Guarantee.  Of beam(): any number of ranks gives its plan, reward, bound and status, on every
///             rank, unless a limit of time or memory ends it, which then may be at another place.
///             What is kept follows from promises, hashes and states alone, never from ranks or the
///             order in which messages come.
/// Cost.       Work and memory of beam(), divided by the ranks. A successor is sent in 40 bytes and
///             8 for each 64 connections, unless it belongs to the rank that found it.
/// Stop.       What stops one rank stops all of them in the same round.
/// @throws Refusal on every rank where steps are wide or attempts may fail.
[[nodiscard]] Result cluster_beam(const TransitionSystem& system, BeamOptions options,
                                  const Budget& budget, Ranks& ranks);

}  // namespace orasp
