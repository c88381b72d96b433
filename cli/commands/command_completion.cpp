#include "cli/commands/command_completion.h"

#include <string_view>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
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

int completion_command(const Arguments& arguments) {
  CompletionOptions options;
  CommandLine line("completion",
                   "Prints a script that completes commands, options, methods and scenarios.");
  line.positional("SHELL", options.shell, "bash");
  line.footer(
      "\nExamples:\n"
      "  source <(orasp completion bash)\n"
      "  orasp completion bash > /etc/bash_completion.d/orasp\n"
      "\n"
      "Exit codes: 0 printed, 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(false)) : kSolved;
}

}  // namespace orasp::cli
