#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct ReplanOptions {
  std::string problem;
  std::optional<std::string> plan;    ///< file: the old plan
  std::optional<std::uint64_t> done;  ///< steps of it that are done
  // Ids, separated by commas.
  std::string removed;
  std::string inaccessible;
  std::string not_next;
  std::string lost_parts;
  std::string late_parts;
  bool json = false;
  std::string output;  ///< file for the plan; empty: none
  ProblemChanges changes;
  LimitOptions limits;
};

/// `orasp replan PROBLEM`: the best plan from where the work stands. @returns the exit code.
/// @throws InputError.
[[nodiscard]] int run(const ReplanOptions& options, const Context& context);

/// Declares the arguments and options of `orasp replan`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork replan_command(CommandLine& line);

}  // namespace orasp::cli
