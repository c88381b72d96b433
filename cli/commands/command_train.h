#pragma once

#include <string>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"
#include "orasp/learning/dqn.h"

namespace orasp::cli {

struct TrainOptions {
  std::string problem;
  std::string policy;            ///< file for the policy; empty: none
  std::string resume;            ///< policy file to go on from; empty: begin anew
  std::string log;               ///< file for a line of JSON after every round; empty: none
  double checkpoint_every = 30;  ///< s
  bool json = false;
  DqnOptions dqn;
  ProblemChanges changes;
  LimitOptions limits;
};

/// `orasp train PROBLEM`: learns a policy and writes it. @returns the exit code. @throws
/// InputError.
[[nodiscard]] int run(const TrainOptions& options, const Context& context);

/// Reads the words that stand behind `orasp train`, prints the help where they ask for it, and
/// runs it. @returns the exit code. @throws InputError.
[[nodiscard]] int train_command(const Arguments& arguments);

}  // namespace orasp::cli
