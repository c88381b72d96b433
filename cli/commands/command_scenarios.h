#pragma once

#include <string>

#include "cli/context.h"
#include "cli/options/command_line.h"

namespace orasp::cli {

struct ScenariosOptions {
  std::string name;  ///< empty: list them
  bool json = false;
  std::string output;  ///< file for the problem, or for the list as JSON; empty: none
};

/// `orasp scenarios [NAME]`: lists the built-in problems, or prints one. @returns the exit code.
/// @throws InputError.
[[nodiscard]] int run(const ScenariosOptions& options, const Context& context);

/// Declares the arguments and options of `orasp scenarios`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork scenarios_command(CommandLine& line);

}  // namespace orasp::cli
