#pragma once

#include <string>
#include <string_view>

#include "orasp/model/problem.h"

namespace orasp::detail {

/// What a text in the format `orasp-problem/1` says: keys and types are checked, what they say
/// together is not (Problem's constructor does that). @throws InputError as parse_problem.
[[nodiscard]] ProblemSpec parse_problem_spec(std::string_view json);

/// As problem_text, of a problem that need not be checked.
[[nodiscard]] std::string problem_spec_text(const ProblemSpec& spec);

}  // namespace orasp::detail
