#pragma once

#include <cstddef>
#include <functional>

#include "orasp/cluster/ranks.h"
#include "orasp/task/budget.h"

namespace orasp::cli {

/// Whether mpirun or srun started this process as one of several.
[[nodiscard]] bool among_ranks();
/// Whether this process is the one that reads, prints and writes: the only one, or rank 0.
[[nodiscard]] bool speaks();

/// Joins the other ranks, after checking that all run the same program with the same arguments,
/// runs `work` on each, and leaves them. @returns what `work` returns at rank 0; 0 elsewhere.
/// An InputError, which must be thrown on all ranks alike, is thrown on at rank 0; any other
/// exception ends all ranks with a sentence and the exit code of an internal error.
[[nodiscard]] int on_ranks(const std::function<int(Ranks&)>& work);

/// What rank 0 makes, on every rank; where it throws an InputError there, every rank throws it.
[[nodiscard]] std::string made_at_rank_0(Ranks& ranks, const std::function<std::string()>& make);

/// Where no memory limit was given: the share of what a machine has, of one of `near` ranks on it.
void share_memory(std::size_t near, bool limited, Budget& budget);

}  // namespace orasp::cli
