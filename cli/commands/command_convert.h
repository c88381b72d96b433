#pragma once

#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct ConvertOptions {
  std::string input;   ///< file, "-" or the name of a built-in scenario
  std::string output;  ///< file; "-": standard output
  std::string from;    ///< name of a format; empty: by ending and content
  std::string to;      ///< name of a format; empty: by ending
  std::string plan;    ///< file; empty: found by the method auto where the format needs one
  LimitOptions limits;
  bool list = false;  ///< print the formats instead
};

/// `orasp convert INPUT -o OUTPUT`: reads a problem in one format and writes it, or a plan for it,
/// in another. @returns the exit code. @throws InputError.
[[nodiscard]] int run(const ConvertOptions& options, const Context& context);

/// Declares the arguments and options of `orasp convert`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork convert_command(CommandLine& line);

}  // namespace orasp::cli
