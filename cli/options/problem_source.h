#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/context.h"
#include "orasp/catalogue.h"
#include "orasp/io/graph_policy_file.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/policy_file.h"
#include "orasp/model/problem.h"
#include "orasp/task/memory_limit.h"

namespace orasp::cli {

/// What the command line changes in a problem. Empty: as the file says.
struct ProblemChanges {
  std::optional<std::string> objective;  ///< a type, or a file that holds an objective
  std::optional<std::string> direction;
  std::optional<std::uint64_t> max_subassemblies;
  std::optional<std::uint64_t> max_moved_parts;
  std::optional<double> max_moved_mass;  ///< kg
  std::optional<std::uint64_t> robots;   ///< of the fleet
  std::optional<std::uint64_t> sites;    ///< of the fleet: the first so many
};

/// What a run may spend.
struct LimitOptions {
  std::optional<double> time_limit;           ///< s; empty: none
  std::optional<std::uint64_t> memory_limit;  ///< MiB; empty: default_memory_limit()
  std::optional<std::uint64_t> threads;       ///< empty: all of the machine's
};

/// The whole of a file, or of standard input for "-". @throws InputError.
[[nodiscard]] std::string read_text(const std::string& file);

/// A policy of `orasp train --problems`. @throws InputError that names the file.
[[nodiscard]] GraphPolicyFile read_graph_policy(const std::string& file);

/// Loads PROBLEM: "-" is standard input; a name with a '/' or that ends in ".json" is a file;
/// otherwise a built-in scenario if there is one, else a file. Warnings go to standard error; one
/// of them is that an objective of one robot, which was asked for, leaves the problem's fleet out.
/// @throws InputError.
[[nodiscard]] Problem load_problem(const std::string& name, const ProblemChanges& changes,
                                   const Context& context);

/// The same for a command that answers for one robot. @throws InputError, also where the objective
/// is one of several robots: the sentence names `command`.
[[nodiscard]] Problem load_one_robot_problem(const std::string& name, const ProblemChanges& changes,
                                             const Context& context, const char* command);

/// The same problem under `changes`. An objective of one robot leaves its fleet out.
/// @throws InputError.
[[nodiscard]] Problem changed(const Problem& problem, const ProblemChanges& changes);

/// Reads PLAN ("-" is standard input) for a problem of this direction. @throws InputError.
[[nodiscard]] PlanFile read_plan(const std::string& file, Direction direction);

/// The same from the text of `file`. @throws InputError.
[[nodiscard]] PlanFile parse_plan_text(const std::string& text, const std::string& file,
                                       Direction direction);

/// Refuses a plan of one robot for an objective of several, and the other way round. `text` is that
/// of `file`. @throws InputError.
void require_plan_for(const Problem& problem, const std::string& text, const std::string& file);

/// Warns where a plan names the digest of another problem than this one; an empty digest names
/// none.
void warn_of_another_problem(const Context& context, const std::string& digest,
                             const Problem& problem);

/// Reads a policy that was trained on this very problem. @throws InputError.
[[nodiscard]] PolicyFile read_policy(const std::string& file, const Problem& problem);

/// What to call a problem in a sentence: its name, else what the user typed.
[[nodiscard]] std::string title(const Problem& problem, const std::string& typed);

/// A budget from the limits, which Ctrl-C stops. The time limit begins now.
[[nodiscard]] Budget make_budget(const LimitOptions& limits);

/// The options that shaped a result, by name, as JSON texts: what plan_text writes under "options".
using Settings = std::map<std::string, std::string>;
void note_changes(const ProblemChanges& changes, Settings& settings);
void note_limits(const LimitOptions& limits, Settings& settings);

/// A JSON string, quotes and all.
[[nodiscard]] std::string json_string(std::string_view text);

/// "stopped by the time limit"; empty for Stop::None.
[[nodiscard]] std::string stop_text(Stop stop);

/// The exit code of a planner's result.
[[nodiscard]] int exit_code(const Result& result);

}  // namespace orasp::cli
