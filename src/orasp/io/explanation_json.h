#pragma once

#include <string>

#include "orasp/explain/explain_connection.h"
#include "orasp/model/problem.h"

namespace orasp {

/// The remedies of an explanation as a JSON array on one line: what would have to change,
/// as `changes` of `orasp explain --connection --json` has it (docs/cli.md).
[[nodiscard]] std::string changes_text(const Problem& problem, const ConnectionExplanation& found);

}  // namespace orasp
