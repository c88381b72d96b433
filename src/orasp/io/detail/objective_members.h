#pragma once

#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_members.h"
#include "orasp/model/objective.h"

namespace orasp::detail {

/// The objective that stands at `value`.
[[nodiscard]] Objective read_objective(JsonValue value, const Place& place);

/// Whether to leave out what a reader would fill in by itself.
enum class Defaults { LeftOut, Written };

[[nodiscard]] nlohmann::ordered_json objective_json(const Objective& objective, Defaults defaults);

/// Whether a file can state the objective; not so where it is or sums a function of C++.
[[nodiscard]] bool has_text(const Objective& objective);

template <class Point>
nlohmann::ordered_json numbers(const Point& point) {
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (const double x : point) array.push_back(x + 0.0);
  return array;
}

}  // namespace orasp::detail
