#pragma once

#include <cstddef>
#include <cstdint>

#include "orasp/cluster/ranks.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/dense_value_iteration.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Finds an optimal plan by value iteration over all subsets of the connections, on a table that
/// lies in the memory of several ranks.
///
/// Problem.    As dense_value_iteration().
/// Idea.       The high bits of a mask say in which slab its value stands, and each rank holds a
///             run of slabs: where their number is a power of two, one each. The ranks are then the
///             corners of a hypercube: to take a connection of the low bits out of a state leads to
///             a state of the same rank; one of the high bits, to the same place in the slab of a
///             neighbour. A slab is worked out in blocks, ascending. A block is sent to the
///             neighbours that need it as soon as it is done, out of the table itself, and each
///             rank has receipts open for the next few blocks: so the ranks work one behind the
///             other, some blocks apart, and what is under way hides behind the work.
/// Reference.  The table: Held, Karp (1962), J. SIAM 10(1), 196-210. Ranks as a hypercube: Saad,
///             Schultz (1988), IEEE Trans. Computers 37(7), 867-872.
/// Guarantee.  Of dense_value_iteration(); any number of ranks gives the same plan, reward, bound
///             and status, on every rank.
/// Cost.       Memory of a rank: its share of the 2^n values, and a few blocks. Sent by all of
///             2^k ranks together: k / 2 * 2^n values, each once (cluster_values_sent).
/// Limit.      The memory of a rank: n may be greater by one with twice as many ranks.
/// Stop.       What stops one rank stops all of them at the same block. Rank 0 alone then looks for
///             a quick plan.
/// @throws InputError on every rank where the table does not fit, where one of them cannot get its
/// memory, or where the rewards of the problem are at fault.
[[nodiscard]] Result cluster_value_iteration(const TransitionSystem& system,
                                             const DenseValueIterationOptions& options,
                                             const Budget& budget, Ranks& ranks);

/// How many values all ranks together send each other for so many connections: the model with which
/// the counted bytes are compared.
[[nodiscard]] std::uint64_t cluster_values_sent(std::size_t connections, std::size_t ranks);

/// Why the table does not take this problem, a clause that goes on from "value-iteration"; empty
/// where it takes it.
[[nodiscard]] std::optional<std::string> cluster_values_obstacle(const TransitionSystem& system);

}  // namespace orasp
