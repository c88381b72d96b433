#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "orasp/explain/explain_problem.h"

namespace orasp::cli {

/// Conflict items or violations as a JSON list: constraint, where, message.
template <class Item>
nlohmann::ordered_json conflict_json(const std::vector<Item>& items) {
  nlohmann::ordered_json conflict = nlohmann::ordered_json::array();
  for (const Item& item : items) {
    conflict.push_back({{"constraint", constraint_name(item.constraint)},
                        {"where", item.where},
                        {"message", item.message}});
  }
  return conflict;
}

/// Why no plan exists, for people.
[[nodiscard]] std::string conflict_text(const ProblemExplanation& found);

}  // namespace orasp::cli
