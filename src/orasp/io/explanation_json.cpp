#include "orasp/io/explanation_json.h"

#include <cstdint>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_text.h"

namespace orasp {

using nlohmann::ordered_json;

std::string changes_text(const Problem& problem, const ConnectionExplanation& found) {
  ordered_json changes = ordered_json::array();
  const auto connections = [&](const std::vector<ConnectionIndex>& indices) {
    ordered_json ids = ordered_json::array();
    for (const ConnectionIndex c : indices) ids.push_back(problem.connection_id(c));
    return ids;
  };
  const auto parts = [&](const std::vector<PartIndex>& indices) {
    ordered_json ids = ordered_json::array();
    for (const PartIndex part : indices) ids.push_back(problem.part_id(part));
    return ids;
  };
  for (const Remedy& remedy : found.remedies) {
    ordered_json change = {{"constraint", constraint_name(remedy.constraint)},
                           {"where", remedy.where},
                           {"message", remedy.message}};
    if (!remedy.first.empty()) change["first"] = connections(remedy.first);
    if (remedy.least) {
      const bool is_mass = remedy.constraint == Constraint::MaxMovedMass;
      change["least"] = is_mass ? ordered_json(*remedy.least)
                                : ordered_json(static_cast<std::uint64_t>(*remedy.least));
    }
    for (const BlockedDirection& direction : remedy.directions) {
      ordered_json entries = ordered_json::array();
      for (const std::size_t entry : direction.entries)
        entries.push_back("blocking.blocked[" + std::to_string(entry) + "]");
      ordered_json along = {{"direction", direction.direction},
                            {"parts", parts(direction.moved)},
                            {"in_the_way", parts(direction.in_the_way)},
                            {"entries", std::move(entries)}};
      if (direction.width) along["width"] = *direction.width;
      change["directions"].push_back(std::move(along));
    }
    changes.push_back(std::move(change));
  }
  return detail::inline_text(changes);
}

}  // namespace orasp
