#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "bindings.h"
#include "orasp/explain/alternatives.h"
#include "orasp/io/plan_json.h"
#include "orasp/task/result.h"
#include "orasp/task/task.h"

namespace orasp::python {

/// A result with the task that it answers.
struct Outcome {
  ProblemPointer problem;
  Situation situation;
  std::optional<std::size_t> steps;
  Result result;
  Alternatives alternatives;

  [[nodiscard]] Task task() const {
    Task task(*problem, situation);
    task.steps = steps;
    return task;
  }
  /// As `orasp solve --json` prints it: see plan_text.
  [[nodiscard]] std::string text(const std::map<std::string, std::string>& settings,
                                 const std::map<std::string, std::string>& more) const {
    return plan_text(task(), result, settings, &alternatives, more);
  }
};

/// Refuses an objective of several robots: the sentence names `command`. @throws InputError.
void require_one_robot(const Problem& problem, const char* command);

}  // namespace orasp::python
