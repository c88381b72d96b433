#pragma once

#include <string>

#include "cli/context.h"
#include "cli/options/command_line.h"
#include "cli/paper/paper.h"

namespace orasp::cli {

struct PaperOptions {
  std::string folder = "orasp-paper";  ///< made if it is missing
  PaperEffort effort;
  bool json = false;
};

/// `orasp paper -o DIR`: the paper's numbers, computed again beside the printed ones:
/// DIR/paper.html, paper.md, paper.json and figures/*.svg. Nothing is written before everything is
/// computed and drawn, and the page comes last.
/// @returns the exit code. @throws InputError.
[[nodiscard]] int run(const PaperOptions& options, const Context& context);

/// Declares the arguments and options of `orasp paper`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork paper_command(CommandLine& line);

}  // namespace orasp::cli
