#pragma once

#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct CheckOptions {
  std::string problem;
  std::string plan;  ///< "none": the certificate says that there is none
  std::string certificate;
  bool json = false;
  std::string output;  ///< file for the JSON; empty: none
  ProblemChanges changes;
};

/// `orasp check PROBLEM PLAN CERTIFICATE`: whether the certificate proves that no plan is better.
/// @returns the exit code. @throws InputError.
[[nodiscard]] int run(const CheckOptions& options, const Context& context);

/// Declares the arguments and options of `orasp check`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork check_command(CommandLine& line);

}  // namespace orasp::cli
