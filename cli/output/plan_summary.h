#pragma once

#include <string>

#include "cli/context.h"
#include "orasp/task/result.h"
#include "orasp/task/task.h"

namespace orasp::cli {

/// "optimal (proved)", "feasible (stopped by the time limit; not proved best)".
[[nodiscard]] std::string status_text(Status status, Stop stop, bool colour);

/// A result for people, of one robot or of several: method, status, reward (or makespan and
/// travel), bound, gap, effort, and where there is a plan its steps; of one robot also the opposite
/// order. `typed` is what the user called the problem.
[[nodiscard]] std::string plan_summary(const Task& task, const std::string& typed,
                                       const Result& result, const Context& context);

/// What a result took: "12,096 states, 67,824 actions, 12,096 expanded, 0.00412 s, 1.2 MiB"; what
/// is 0 is left out.
[[nodiscard]] std::string statistics_text(const Result& result);

}  // namespace orasp::cli
