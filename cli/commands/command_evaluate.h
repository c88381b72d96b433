#pragma once

#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct EvaluateOptions {
  std::string problem;
  std::string plan;
  bool json = false;
  std::string output;  ///< file for the JSON; empty: none
  ProblemChanges changes;
};

/// `orasp evaluate PROBLEM PLAN`: replays a plan and reports what is wrong with it. @returns the
/// exit code.
/// @throws InputError.
[[nodiscard]] int run(const EvaluateOptions& options, const Context& context);

/// Reads the words that stand behind `orasp evaluate`, prints the help where they ask for it, and
/// runs it. @returns the exit code. @throws InputError.
[[nodiscard]] int evaluate_command(const Arguments& arguments);

}  // namespace orasp::cli
