#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct CompareOptions {
  std::vector<std::string> problems;
  std::string
      methods;  ///< names joined by commas; empty: every exact method that accepts the problem
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> steps;  ///< of methods for fleets
  bool markdown = false;
  bool csv = false;
  bool json = false;
  std::string output;  ///< file for the table, as JSON unless markdown or csv; empty: none
  ProblemChanges changes;
  LimitOptions limits;  ///< of each run
};

/// `orasp compare PROBLEM...`: runs several methods on several problems and prints one table.
/// @returns the exit code.
/// @throws InputError.
[[nodiscard]] int run(const CompareOptions& options, const Context& context);

/// Declares the arguments and options of `orasp compare`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork compare_command(CommandLine& line);

}  // namespace orasp::cli
