#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct SolveOptions {
  std::string problem;
  std::string method = "auto";
  std::uint64_t seed = 1;
  std::string output;  ///< file for the plan; empty: none
  bool json = false;
  ProblemChanges changes;
  LimitOptions limits;
  bool count = false;                  ///< of the optimal sequences
  std::uint64_t alternatives = 0;      ///< how many of the best plans to list
  std::optional<std::string> bound;    ///< of orasp-search, a-star, beam and q-learning
  std::optional<std::uint64_t> steps;  ///< of methods for fleets
  std::string policy;                  ///< file, of dqn; empty: train first
  std::string write_model;             ///< file, of mip; empty: solve it
  // of value-iteration alone
  std::optional<std::string> sweep_order;
  std::optional<double> epsilon;
  std::optional<std::uint64_t> max_sweeps;
  std::optional<double> initial_value;
};

/// `orasp solve PROBLEM`: finds a plan and prints it. @returns the exit code. @throws InputError.
[[nodiscard]] int run(const SolveOptions& options, const Context& context);

/// Reads the words that stand behind `orasp solve`, prints the help where they ask for it, and
/// runs it. @returns the exit code. @throws InputError.
[[nodiscard]] int solve_command(const Arguments& arguments);

}  // namespace orasp::cli
