#pragma once

#include <cstdint>
#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct SampleOptions {
  std::string problem;
  std::uint64_t count = 100;
  std::uint64_t seed = 1;
  bool json = false;
  bool sequences = false;  ///< the sequences too, in the JSON
  std::string policy;  ///< file: what it earns beside the sample, and the best plan; empty: neither
  std::string output;  ///< file for the JSON; empty: none
  ProblemChanges changes;
  LimitOptions limits;
};

/// `orasp sample PROBLEM`: rewards of uniformly random legal sequences. @returns the exit code.
/// @throws InputError.
[[nodiscard]] int run(const SampleOptions& options, const Context& context);

/// Declares the arguments and options of `orasp sample`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork sample_command(CommandLine& line);

}  // namespace orasp::cli
