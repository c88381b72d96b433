#include "orasp/planners/greedy.h"

#include <algorithm>

#include "orasp/planners/detail/depth_first_plan.h"

namespace orasp {

Result greedy(const TransitionSystem& system, const Budget& budget) {
  return detail::depth_first_plan(system, budget, "greedy", [](std::span<Action> actions) {
    std::ranges::stable_sort(actions, std::ranges::greater{}, &Action::reward);
  });
}

}  // namespace orasp
