#pragma once

#include <string>

#include "cli/context.h"

namespace orasp::cli {

struct CompletionOptions {
  std::string shell;
};

/// `orasp completion bash`: prints the script cli/orasp.bash. @returns the exit code. @throws
/// InputError.
[[nodiscard]] int run(const CompletionOptions& options, const Context& context);

}  // namespace orasp::cli
