#pragma once

#include <string>

#include "cli/context.h"
#include "cli/options/command_line.h"

namespace orasp::cli {

struct CompletionOptions {
  std::string shell;
};

/// `orasp completion bash`: prints the script, which is put together from what the commands
/// declare. @returns the exit code. @throws InputError.
[[nodiscard]] int run(const CompletionOptions& options, const Context& context);

/// Declares the arguments and options of `orasp completion`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork completion_command(CommandLine& line);

}  // namespace orasp::cli
