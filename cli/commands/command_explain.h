#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct ExplainOptions {
  std::string problem;
  std::optional<std::string> connection;  ///< explain this one; empty: the whole problem
  std::optional<std::string> plan;        ///< file of the plan in whose middle it stands
  std::optional<std::uint64_t> step;      ///< of the plan, from 1
  bool json = false;
  std::string output;  ///< file for the JSON; empty: none
  ProblemChanges changes;
  LimitOptions limits;
};

/// `orasp explain PROBLEM`: why there is no plan, or why a connection cannot be handled. @returns
/// the exit code. @throws InputError.
[[nodiscard]] int run(const ExplainOptions& options, const Context& context);

/// Declares the arguments and options of `orasp explain`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork explain_command(CommandLine& line);

}  // namespace orasp::cli
