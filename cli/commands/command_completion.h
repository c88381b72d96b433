#pragma once

#include <string>

#include "cli/context.h"
#include "cli/options/command_line.h"

namespace orasp::cli {

struct CompletionOptions {
  std::string shell;
};

/// `orasp completion bash`: prints the script cli/orasp.bash. @returns the exit code. @throws
/// InputError.
[[nodiscard]] int run(const CompletionOptions& options, const Context& context);

/// Reads the words that stand behind `orasp completion`, prints the help where they ask for it, and
/// runs it. @returns the exit code. @throws InputError.
[[nodiscard]] int completion_command(const Arguments& arguments);

}  // namespace orasp::cli
