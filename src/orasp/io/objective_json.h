#pragma once

#include <string>
#include <string_view>

#include "orasp/model/objective.h"

namespace orasp {

/// Reads one objective: a JSON object as in a problem file. `place` stands in front of error
/// messages.
[[nodiscard]] Objective parse_objective(std::string_view json, const std::string& place);

/// One objective as a JSON object on one line, as in a problem file, defaults left out. Of a
/// `callable` only its name.
[[nodiscard]] std::string objective_text(const Objective& objective);

}  // namespace orasp
