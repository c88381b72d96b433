#include "orasp/model/situation.h"

#include <set>

#include "orasp/model/objectives/changeover.h"
#include "orasp/model/transition_system.h"

namespace orasp {

void note_done(const Problem& problem, const PlanStep& step, Situation& now) {
  std::map<std::string, std::string> values;
  std::set<std::string> differing;
  Vector3 sum{};
  bool placed = !step.connections.empty();
  for (const ConnectionIndex c : step.connections) {
    now.open.erase(c);
    for (const auto& [name, value] : problem.connections()[c].attributes) {
      const auto [entry, is_new] = values.emplace(name, value);
      if (!is_new && entry->second != value) differing.insert(name);
    }
    const std::optional<Vector3> place = problem.place(c);
    placed = placed && place.has_value();
    for (std::size_t axis = 0; axis < sum.size() && place; ++axis) sum[axis] += (*place)[axis];
  }
  for (const auto& [name, value] : values) {
    if (!differing.contains(name)) now.in_force[name] = value;
  }
  if (step.direction) now.in_force[kDirectionAttribute] = problem.direction_name(*step.direction);
  if (!placed) return;
  for (double& x : sum) x /= static_cast<double>(step.connections.size());
  now.last_place = sum;
}

}  // namespace orasp
