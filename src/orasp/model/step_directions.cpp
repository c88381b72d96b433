#include "orasp/model/step_directions.h"

#include <algorithm>
#include <cassert>

namespace orasp {

void choose_directions(std::span<Step> steps,
                       std::span<const std::optional<DirectionIndex>> stated) {
  assert(stated.empty() || stated.size() == steps.size());
  std::optional<DirectionIndex> last;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto& free = steps[i].free_directions;
    const auto is_free = [&](const std::optional<DirectionIndex>& direction) {
      return direction && std::ranges::find(free, *direction) != free.end();
    };
    const std::optional<DirectionIndex> known = steps[i].direction;
    steps[i].direction.reset();
    if (free.empty()) continue;
    if (is_free(known)) {
      last = known;
    } else if (!stated.empty() && is_free(stated[i])) {
      last = stated[i];
    } else if (!is_free(last)) {
      last = free.front();
    }
    steps[i].direction = last;
  }
}

}  // namespace orasp
