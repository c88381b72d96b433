#include "cli/commands/command_completion.h"

#include <string_view>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/output/text.h"
#include "orasp/model/error.h"

namespace orasp::cli {

extern const std::string_view
    kBashCompletion;  // completion_script.cpp, which CMake writes from orasp.bash

int run(const CompletionOptions& options, const Context& context) {
  if (options.shell != "bash")
    throw InputError(fmt::format("there is no completion for the shell {}, only for bash",
                                 in_quotes(options.shell)));
  context.print(kBashCompletion);
  return kSolved;
}

}  // namespace orasp::cli
