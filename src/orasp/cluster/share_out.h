#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "orasp/cluster/ranks.h"

namespace orasp {

/// Shares pieces of work out among ranks: each gets the next piece as soon as it is free, rank 0
/// too, which hands them out. On every rank a thread of its own works and the caller's looks after
/// the letters.
///
/// A piece whose work throws is given to another rank. Where it throws there as well, what `failed`
/// makes of the piece and of what the last said stands in its place. A stop on any rank stops all:
/// the pieces under way end as `work` ends them, and no other is begun.
/// @returns by piece what `work` returned, at rank 0; empty for a piece that was not begun. Nothing
/// elsewhere.
[[nodiscard]] std::vector<std::optional<std::string>> share_out(
    Ranks& ranks, std::size_t pieces,
    const std::function<std::string(std::size_t piece, const std::stop_token& stop)>& work,
    const std::function<std::string(std::size_t piece, const std::string& why)>& failed,
    const std::stop_token& stop);

}  // namespace orasp
