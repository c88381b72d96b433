#pragma once

#include <string>
#include <vector>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"
#include "orasp/catalogue.h"

namespace orasp::cli {

struct TrainOptions {
  /// One, unless `together`.
  std::vector<std::string> problems;
  /// One policy for all problems, by imitation (learning/imitation.h).
  bool together = false;
  std::string policy;            ///< file for the policy; empty: none
  std::string resume;            ///< policy file to go on from; empty: begin anew
  std::string log;               ///< file for a line of JSON after every round; empty: none
  double checkpoint_every = 30;  ///< s
  std::string of_q_learning;     ///< an option that was given and is deep Q-learning's alone
  bool json = false;
  /// Of which `dqn` alone matters.
  Options learning;
  ProblemChanges changes;
  LimitOptions limits;
};

/// `orasp train PROBLEM...`: learns a policy and writes it. @returns the exit code. @throws
/// InputError.
[[nodiscard]] int run(const TrainOptions& options, const Context& context);

/// Declares the arguments and options of `orasp train`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork train_command(CommandLine& line);

}  // namespace orasp::cli
