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

/// Reads the words that stand behind `orasp scenarios`, prints the help where they ask for it, and
/// runs it. @returns the exit code. @throws InputError.
[[nodiscard]] int scenarios_command(const Arguments& arguments);

}  // namespace orasp::cli
