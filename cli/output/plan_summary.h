#pragma once

#include <string>

#include "cli/context.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/result.h"

namespace orasp::cli {

/// "optimal (proved)", "feasible (stopped by the time limit; not proved best)".
[[nodiscard]] std::string status_text(Status status, Stop stop, bool colour);

/// A result for people: method, status, reward, bound, gap, effort, and where there is a plan its
/// steps and the opposite order. `typed` is what the user called the problem.
[[nodiscard]] std::string plan_summary(const TransitionSystem& system, const std::string& typed,
                                       const Result& result, const Context& context);

/// What a result took: "12,096 states, 67,824 actions, 12,096 expanded, 0.00412 s, 1.2 MiB"; what
/// is 0 is left out.
[[nodiscard]] std::string statistics_text(const Result& result);

}  // namespace orasp::cli
