#include "orasp/planners/random_sequence.h"

#include <utility>

#include "orasp/model/random.h"
#include "orasp/planners/depth_first_plan.h"
#include "orasp/planners/detail/wide_search.h"

namespace orasp {

Result random_sequence(const TransitionSystem& system, const RandomOptions& options,
                       const Budget& budget) {
  if (system.wide()) return detail::wide_random(system, options.seed, budget);
  // A uniform shuffle (Fisher and Yates 1938; Durstenfeld 1964): its first element is a uniform
  // draw, and after a failure the next is a uniform draw among the rest.
  SplitMix64 random(options.seed);
  Result result =
      detail::depth_first_plan(system, budget, "random", [&](SetView, std::span<Action> actions) {
        for (std::size_t left = actions.size(); left > 1; --left)
          std::swap(actions[left - 1], actions[random.below(left)]);
        return actions.size();
      });
  result.seed = options.seed;
  return result;
}

}  // namespace orasp
