#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"
#include "orasp/method_options.h"

namespace orasp::cli {

struct SolveOptions {
  std::string problem;
  std::string method = "auto";
  std::uint64_t seed = 1;
  std::string output;       ///< file for the plan; empty: none
  std::string certificate;  ///< file for the certificate; empty: none
  bool json = false;
  ProblemChanges changes;
  LimitOptions limits;
  bool count = false;                  ///< of the optimal sequences
  std::uint64_t alternatives = 0;      ///< how many of the best plans to list
  std::optional<std::uint64_t> steps;  ///< of methods for fleets
  std::string write_model;             ///< file, of mip; empty: solve it
  OptionTexts of_method;               ///< those of the method's rows that were given
};

/// `orasp solve PROBLEM`: finds a plan and prints it. @returns the exit code. @throws InputError.
[[nodiscard]] int run(const SolveOptions& options, const Context& context);

/// Declares the arguments and options of `orasp solve`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork solve_command(CommandLine& line);

}  // namespace orasp::cli
