#include "orasp/model/detail/look_back.h"

#include <map>
#include <optional>
#include <utility>

#include "orasp/model/objectives/changeover.h"

namespace orasp::detail {

std::vector<CheckedReward::Value> rewards_looking_back(const Problem& problem,
                                                       const CheckedReward& reward,
                                                       const Situation& situation,
                                                       std::span<KeptStep> steps) {
  struct Course {
    double reward = 0;
    std::vector<CheckedReward::Value> values{};
    std::vector<std::optional<DirectionIndex>> directions{};
  };
  std::map<std::string, std::string> in_force = situation.in_force;
  std::optional<Vector3> last_place = situation.last_place;
  // By the direction in force; "": none yet.
  std::map<std::string, Course> courses{{in_force[kDirectionAttribute], {}}};
  in_force.erase(kDirectionAttribute);
  for (KeptStep& kept : steps) {
    kept.seen.in_force = in_force;
    kept.seen.last_place = last_place;
    kept.seen.step = &kept.step;
    std::map<std::string, Course> next;
    const auto follow = [&](const std::string& before, const Course& course,
                            std::optional<DirectionIndex> direction) {
      SeenStep seen = kept.seen;
      if (!before.empty()) seen.in_force[kDirectionAttribute] = before;
      if (direction) seen.attributes[kDirectionAttribute] = problem.direction_name(*direction);
      Course longer = course;
      longer.values.push_back(reward.of(seen));
      longer.reward += longer.values.back().reward;
      longer.directions.push_back(direction);
      const std::string now = direction ? problem.direction_name(*direction) : before;
      const auto found = next.find(now);
      if (found == next.end() || found->second.reward < longer.reward)
        next.insert_or_assign(now, std::move(longer));
    };
    for (const auto& [before, course] : courses) {
      if (kept.ways.empty()) follow(before, course, std::nullopt);
      for (const DirectionIndex way : kept.ways) follow(before, course, way);
    }
    courses = std::move(next);
    for (const auto& [name, value] : kept.seen.attributes) in_force[name] = value;
    last_place = kept.seen.place;
  }
  Course* best = nullptr;
  for (auto& [direction, course] : courses) {
    if (best == nullptr || course.reward > best->reward) best = &course;
  }
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i].step.direction = best->directions[i];
  return std::move(best->values);
}

}  // namespace orasp::detail
