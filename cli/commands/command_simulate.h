#pragma once

#include <cstdint>
#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct SimulateOptions {
  std::string problem;
  std::string plan;    ///< file; empty: none
  std::string policy;  ///< file; empty: none. Neither: an optimal policy is found first
  std::uint64_t count = 10'000;
  std::uint64_t seed = 1;
  bool json = false;
  std::string output;  ///< file for the JSON; empty: none
  ProblemChanges changes;
  LimitOptions limits;
};

/// `orasp simulate PROBLEM`: runs with random failures. @returns the exit code. @throws InputError.
[[nodiscard]] int run(const SimulateOptions& options, const Context& context);

/// Declares the arguments and options of `orasp simulate`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork simulate_command(CommandLine& line);

}  // namespace orasp::cli
