#include "orasp/planners/random_rewards.h"

#include <utility>

#include "orasp/model/random.h"
#include "orasp/planners/random_sequence.h"

namespace orasp {

RandomRewards draw_rewards(const TransitionSystem& system, std::uint64_t count, std::uint64_t seed,
                           bool with_sequences, const Budget& budget) {
  RandomRewards drawn;
  SplitMix64 seeds(seed);
  for (std::uint64_t i = 0; i < count; ++i) {
    Result result = random_sequence(system, {.seed = seeds.next()}, budget);
    // The quick plan of a stopped run was not drawn.
    if (!result.has_plan() || result.stop != Stop::None) {
      drawn.last = std::move(result);
      if (drawn.last.stop != Stop::None) drawn.last.notes.clear();
      break;
    }
    drawn.rewards.push_back(result.reward);
    if (with_sequences) drawn.sequences.push_back(std::move(result.sequence));
    if (i % 16 == 0) budget.report({.phase = "drawing", .done = i, .total = count});
  }
  return drawn;
}

}  // namespace orasp
