#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

struct ReportOptions {
  std::string problem;
  std::vector<std::string> plans;             ///< files; empty: solve
  std::string output;                         ///< file for the page; "-": standard output
  std::string svg;                            ///< folder for the figures as SVG files; empty: none
  std::string title;                          ///< empty: the problem's
  std::string log;                            ///< file of `orasp train --log`; empty: none
  std::string sample;                         ///< file of `orasp sample --json`; empty: none
  std::optional<std::uint64_t> sample_count;  ///< sequences to draw; empty: none
  std::uint64_t seed = 1;
  ProblemChanges changes;
  LimitOptions limits;
};

/// `orasp report PROBLEM [PLAN...] -o FILE --svg DIR`: one self-contained page about a problem and
/// its plans, its figures as files, or both; the figures show the first plan that breaks no rule.
/// @returns the exit code. @throws InputError.
[[nodiscard]] int run(const ReportOptions& options, const Context& context);

/// Declares the arguments and options of `orasp report`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork report_command(CommandLine& line);

}  // namespace orasp::cli
