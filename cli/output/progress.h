#pragma once

#include <string>

#include "cli/context.h"
#include "orasp/task/budget.h"

namespace orasp::cli {

/// One line on standard error that tells how far a planner is: only on a terminal, only after the
/// first second, ten times a second at most. Clears itself at the end. Shown from one thread at a
/// time.
class ProgressLine {
 public:
  /// `title` stands at the head of the line: "hubble, dijkstra".
  ProgressLine(const Context& context, std::string title);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Lets `budget` report here. The line must outlive the planner's run.
  void attach_to(Budget& budget);
  void show(const Progress& progress);

 private:
  const bool enabled_;
  const std::string title_;
  const Budget::Clock::time_point start_ = Budget::Clock::now();
  Budget::Clock::time_point next_ = start_ + std::chrono::seconds(1);
  bool visible_ = false;
};

}  // namespace orasp::cli
