#pragma once

#include <span>
#include <string>

#include "cli/context.h"
#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"

namespace orasp::cli {

/// The ids of all that a step handles.
[[nodiscard]] std::string connections_text(const Problem& problem, const Step& step);

/// The steps of a plan, one a line: number, connection, the piece that moves where the step
/// separates (joins) two, the way in which it leaves (arrives) where the problem has blocking,
/// reward, running total. The moved piece's parts are capped to the
/// terminal's width.
[[nodiscard]] std::string step_table(const Problem& problem, std::span<const Step> steps,
                                     const Context& context);

}  // namespace orasp::cli
