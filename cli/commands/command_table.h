#pragma once

#include <span>

#include "cli/options/command_line.h"

namespace orasp::cli {

/// One command of the program.
struct Command {
  const char* name;
  /// One line, for the help of the program.
  const char* summary;
  /// Declares its arguments and options. @returns what runs it once they are read.
  CommandWork (*declare)(CommandLine& line);
  /// Whether several processes share its work where mpirun starts them.
  bool shares = false;
};

/// All commands, in the order of the help. The one table: the program, its help and the completion
/// of the shell walk it.
[[nodiscard]] std::span<const Command> commands();

}  // namespace orasp::cli
