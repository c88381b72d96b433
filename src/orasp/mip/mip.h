#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "orasp/mip/mip_model.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// The largest problem that is written as an integer program.
inline constexpr std::size_t kMipMaxConnections = 32;

/// Why a problem cannot be written as this integer program, a sentence; empty where it can.
[[nodiscard]] std::optional<std::string> mip_obstacle(const TransitionSystem& system);

/// The integer program of a problem for one robot, in the order of disassembly. Its objective is
/// minus the reward.
///
/// Idea.       Time-indexed. cut_c_t and keep_c_t: connection c goes in step t, and does or does
///             not separate its parts. The pieces after each step are labelled by their first part:
///             in_l_i_t says that part i is in the piece whose first part is l. A connection that
///             is there ties the labels of its parts; a cut separates them; and there is one label
///             more for every cut. Where c only keeps, a path of one unit must lead from one of its
///             parts to the other over what is there (flow_*). So labels are pieces, neither finer
///             nor coarser. size_l_k_t: that piece has k parts. split_a_b_t: step t takes a piece
///             of a + b parts into a and b; they balance the numbers of pieces by size, and rewards
///             and limits stand on them. For blocking and masses that differ, first_i_t and
///             second_i_t say which parts are on the two sides, moved_i_t which of them move.
/// Reference.  Time-indexed assignment: Dyer and Wolsey (1990), Discrete Applied Mathematics 26,
///             255-270. No integer program was published for this problem; this one is ours. The
///             balance of sizes alone, as a linear program, gives the bound `sizes`
///             (bounds/piece_bound.h).
/// Cost.       With n connections, N parts: about n (2n + N^2 + N^2/4 + 2n) columns and n (2 n N +
///             N^2) rows; for lattice (12, 9) see docs/algorithms.md.
/// Limit.      kMipMaxConnections; objectives whose reward is a connection's own, a function of the
///             sizes of A and B, or `indexed`, and sums of such.
/// @throws Refusal with mip_obstacle().
[[nodiscard]] MipModel mip_model(const TransitionSystem& system);

/// Finds an optimal plan by solving that program with CBC (mip/mip_solver.h).
///
/// Guarantee.  Exact within CBC's tolerances, 1e-7 of the greatest term. The plan is replayed by
///             the rules: its legality and its reward are theirs.
/// Cost.       Branch and cut: fractions of a second up to 8 connections, minutes at 12.
/// Limit.      As above. The memory limit is that of the model; CBC's own tables are not counted.
/// Repeatable. Unless it is stopped. One thread.
/// @throws Refusal with mip_obstacle(), or where CBC is not there.
[[nodiscard]] Result mip(const TransitionSystem& system, const Budget& budget);

}  // namespace orasp
