#pragma once

#include <cstddef>
#include <cstdint>

#include "orasp/fleet/fleet.h"
#include "orasp/mip/mip_model.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// The largest program that is built: columns.
inline constexpr std::uint64_t kFleetMipMaxColumns = 500'000;

/// The integer program of a fleet problem for `steps` steps.
///
/// Problem.    FleetProblem. Objective travel: the least travel in at most `steps` steps. Objective
///             makespan: the fewest steps, of at most `steps`.
/// Idea.       Binary columns. at_i_p_t: part i is at place p in state t (0: the depot). go_i_d_t:
///             its motion in step t (0 stays). there_c_t: connection c is there in state t; it is
///             so where both its parts are at the same site, since parts that are together move
///             alike and so keep all that joins them: both_c_p_t says it site by site. What goes is
///             pulled apart by motions (rule 5 of Culbertson et al.), what is kept has equal ones
///             (rule 4). held_i_t: a robot holds the part. used_p_t: there is a subassembly at the
///             site. What is at a site hangs together: it has as many connections as parts less
///             one, and where there are cycles a flow (flow_*) from one part (root_i_p_t) reaches
///             the others. The objective travel is the sum of move_i_p_q_t times the squared
///             distance, where these follow each part from place to place as a path does, so no
///             product of two columns is needed.
/// Reference.  Culbertson, Bandyopadhyay and Schwager (2019), IROS. Published are the columns for
///             places, connections, motions, cuttable pairs and robots, and the rules. Ours:
///             connectivity by counting and flows within sites in place of layers after Floyd and
///             Warshall (N^3 columns a state), robots counted and not named, places that follow
///             from connections, and the linear objective. 6,432 binary columns for the lattice
///             with T = 6 (5 steps) become 765; see docs/algorithms.md, section mip.
/// Beyond it.  Precedence, blocking and the problem's limits, as docs/format.md states them for
///             fleets.
/// @throws InputError where it would be larger than kFleetMipMaxColumns; it says how large.
[[nodiscard]] MipModel fleet_mip_model(const FleetProblem& fleet, std::size_t steps);

/// The steps within which a plan of the fewest steps lies, if there is a plan: each of them cuts
/// something.
[[nodiscard]] std::size_t fleet_mip_horizon(const FleetProblem& fleet);

/// Plans for several robots by that program, solved by CBC (mip/mip_solver.h). The baseline.
///
/// Idea.       Makespan: for 1, 2, 3, ... steps, from the number that takes all parts to the depot,
///             whether there is a plan at all, until there is. Travel: with the fewest steps, found
///             so, or with FleetOptions::steps.
/// Guarantee.  Exact within CBC's tolerances. Every plan is replayed by the checker
///             (fleet/fleet_validate.h).
/// Cost.       docs/performance.md, section "The integer program".
/// Limit.      kFleetMipMaxColumns.
/// Repeatable. Unless it is stopped. One thread.
/// @throws InputError above the limit, or where CBC is not there.
[[nodiscard]] Result fleet_mip(const FleetProblem& fleet, const FleetOptions& options,
                               const Budget& budget);

}  // namespace orasp
