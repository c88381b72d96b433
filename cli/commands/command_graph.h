#pragma once

#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct GraphOptions {
  std::string problem;
  std::string dot;  ///< file for H in the DOT language, "-": standard output; empty: none
  std::string svg;  ///< file for the picture of H, "-": standard output; empty: none
  bool json = false;
  std::string output;  ///< file for the JSON; empty: none
  ProblemChanges changes;
  LimitOptions limits;
};

/// `orasp graph PROBLEM`: sizes of the state-action graph H and of the tree it consolidates, and
/// drawings of H.
/// @returns the exit code. @throws InputError.
[[nodiscard]] int run(const GraphOptions& options, const Context& context);

/// Declares the arguments and options of `orasp graph`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork graph_command(CommandLine& line);

}  // namespace orasp::cli
