#pragma once

namespace orasp::cli {

/// What the program returns to its caller; the table stands in docs/cli.md too.
enum ExitCode : int {
  kSolved = 0,         ///< solved, or valid
  kNoPlan = 10,        ///< proved infeasible, or an invalid plan
  kStopped = 20,       ///< a limit or Ctrl-C stopped it; the best plan so far was printed
  kWrongInput = 30,    ///< wrong input or usage
  kInternalError = 40  ///< a mistake of ours, or no memory left
};

}  // namespace orasp::cli
