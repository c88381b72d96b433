#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "orasp/certificate/detail/piece_cuts.h"
#include "orasp/certificate/detail/piece_values.h"
#include "orasp/certificate/detail/size_rewards.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// One way in which a plan may begin (looked at backwards in an assembly), and what it earns then
/// at most: the values of these pieces, what all steps earn by their connections, and what the step
/// that completes earns beside.
struct PieceGroup {
  std::vector<std::pair<PieceCuts::Side, std::size_t>> pieces;  ///< with what is allowed to each
  double bound;                                                 ///< rounded up
};

/// All ways, so that no plan earns more than the greatest bound of them; none where there is no
/// plan. In disassembly the step that completes is the last one, and there is one way; in assembly
/// it is the first removal, and there is a way for each, two where it leaves two subassemblies of
/// which one has to do with fewer.
[[nodiscard]] std::vector<PieceGroup> piece_groups(const Problem& problem,
                                                   const SizeRewards& rewards,
                                                   const PieceValues& values,
                                                   const PieceCuts& cuts);

}  // namespace orasp::detail
