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

/// Declares the arguments and options of `orasp evaluate`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork evaluate_command(CommandLine& line);

}  // namespace orasp::cli
