#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"

namespace orasp::cli {

/// The help of the argument PROBLEM.
inline constexpr const char* kProblemHelp =
    "a file, - for standard input, or a built-in scenario (`orasp scenarios` lists them)";

/// The methods of the catalogue with their summaries, for the end of a help.
[[nodiscard]] std::string methods_help();

/// The names of all methods.
[[nodiscard]] std::vector<std::string> method_names();

/// The options that methods of the catalogue have, by their rows, each with the methods that it
/// belongs to; what is given goes into `given`.
void add_method_options(CommandLine& line, OptionTexts& given);

void add_problem_options(CommandLine& line, ProblemChanges& changes);

/// `of` says what is stopped: "" or " each run".
void add_limit_options(CommandLine& line, LimitOptions& limits, const std::string& of = "",
                       bool uses_threads = true);

/// `result` is what --json prints: "the plan".
void add_output_options(CommandLine& line, bool& json, std::string& output,
                        const std::string& result);

/// `of` says what the seed is of: "the sample".
void add_seed_option(CommandLine& line, std::uint64_t& seed, const std::string& of);

/// The horizon of methods for several robots.
void add_steps_option(CommandLine& line, std::optional<std::uint64_t>& steps);

}  // namespace orasp::cli
