#pragma once

#include <cstdint>
#include <vector>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Uniformly random legal sequences and what they earn.
struct RandomRewards {
  std::vector<double> rewards;                          ///< in the order in which they were drawn
  std::vector<std::vector<ConnectionIndex>> sequences;  ///< only if asked for
  Result last;  ///< of the draw that ended the sample early, if one did
};

/// Sequence i is drawn with the i-th number of SplitMix64(seed) as its seed, so that a longer
/// sample begins with the shorter one.
[[nodiscard]] RandomRewards draw_rewards(const TransitionSystem& system, std::uint64_t count,
                                         std::uint64_t seed, bool with_sequences,
                                         const Budget& budget);

}  // namespace orasp
