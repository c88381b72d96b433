#include "cli/options/problem_source.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/output/text.h"
#include "cli/signals.h"
#include "orasp/io/fleet_plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/problem_source.h"
#include "orasp/task/memory_limit.h"

namespace orasp::cli {
namespace {

constexpr std::size_t kLargestFile = std::size_t{256} << 20;
constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20;

struct CloseFile {
  void operator()(std::FILE* file) const {
    if (file != stdin) std::fclose(file);
  }
};

std::string spoken(const std::string& file) {
  return file == "-" ? "standard input" : in_quotes(file);
}

Problem problem_called(const std::string& name) {
  if (name == "-") {
    const std::string text = read_text(name);
    try {
      return parse_problem(text);
    } catch (const InputError& error) {
      throw InputError(fmt::format("standard input: {}", error.what()));
    }
  }
  return find_problem(name);
}

ProblemEdits edits_of(const ProblemChanges& changes) {
  ProblemEdits edits;
  if (changes.objective) edits.objective = find_objective(*changes.objective);
  if (changes.direction) edits.direction = find_direction(*changes.direction);
  edits.max_subassemblies = changes.max_subassemblies;
  edits.max_moved_parts = changes.max_moved_parts;
  edits.max_moved_mass = changes.max_moved_mass;
  edits.robots = changes.robots;
  edits.sites = changes.sites;
  return edits;
}

}  // namespace

std::string read_text(const std::string& file) {
  const auto fail = [&](int error) {
    throw InputError(
        fmt::format("cannot read {}: {}", spoken(file), std::generic_category().message(error)));
  };
  const std::unique_ptr<std::FILE, CloseFile> stream(file == "-" ? stdin
                                                                 : std::fopen(file.c_str(), "rb"));
  if (!stream) fail(errno);
  std::string text;
  std::size_t length = 0;
  while (true) {
    constexpr std::size_t kPiece = std::size_t{64} << 10;
    text.resize(length + std::max(kPiece, length));
    const std::size_t read =
        std::fread(text.data() + length, 1, text.size() - length, stream.get());
    length += read;
    if (read == 0) break;
    if (length > kLargestFile)
      throw InputError(fmt::format("{} holds more than 256 MiB", spoken(file)));
  }
  if (std::ferror(stream.get()) != 0) fail(errno);
  text.resize(length);
  return text;
}

GraphPolicyFile read_graph_policy(const std::string& file) {
  const std::string bytes = read_text(file);
  try {
    return parse_graph_policy(bytes);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
}

Problem changed(const Problem& problem, const ProblemChanges& changes) {
  return edited(problem, edits_of(changes), "--");
}

Problem load_problem(const std::string& name, const ProblemChanges& changes,
                     const Context& context) {
  Problem problem = problem_called(name);
  if (const ProblemEdits edits = edits_of(changes); edits.any()) {
    Problem other = edited(problem, edits, "--");
    if (const auto& fleet = problem.spec().fleet; fleet && !other.spec().fleet)
      context.warn(fmt::format("fleet: its {} are not used: {} is an objective of one robot",
                               counted(fleet->robots, "robot"), other.objective().type));
    problem = std::move(other);
  }
  for (const std::string& warning : problem.warnings()) context.warn(printable(warning));
  return problem;
}

Problem load_one_robot_problem(const std::string& name, const ProblemChanges& changes,
                               const Context& context, const char* command) {
  Problem problem = load_problem(name, changes, context);
  if (problem.objective().of_fleet())
    throw InputError(fmt::format(
        "{} answers for one robot, and the objective of this problem is {}, one of several; "
        "--objective TYPE asks about one",
        command, problem.objective().type));
  return problem;
}

PlanFile read_plan(const std::string& file, Direction direction) {
  return parse_plan_text(read_text(file), file, direction);
}

PlanFile parse_plan_text(const std::string& text, const std::string& file, Direction direction) {
  try {
    return parse_plan(text, direction);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file == "-" ? "standard input" : file, error.what()));
  }
}

void require_plan_for(const Problem& problem, const std::string& text, const std::string& file) {
  const bool of_fleet = problem.objective().of_fleet();
  if (is_fleet_plan(text) == of_fleet) return;
  throw InputError(fmt::format("{}: it is a plan of {}, and {} is an objective of {}",
                               file == "-" ? "standard input" : file,
                               of_fleet ? "one robot" : "several robots", problem.objective().type,
                               of_fleet ? "several robots" : "one"));
}

void warn_of_another_problem(const Context& context, const std::string& digest,
                             const Problem& problem) {
  if (!digest.empty() && digest != problem_digest(problem))
    context.warn("the plan was made for another problem: its problem_digest differs");
}

PolicyFile read_policy(const std::string& file, const Problem& problem) {
  const std::string bytes = read_text(file);
  PolicyFile policy;
  try {
    policy = parse_policy(bytes);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", spoken(file), error.what()));
  }
  require_trained_on(problem, policy, spoken(file));
  return policy;
}

std::string title(const Problem& problem, const std::string& typed) {
  if (!problem.name().empty()) return printable(problem.name());
  return typed == "-" ? "standard input" : printable(typed);
}

Budget make_budget(const LimitOptions& limits) {
  static const std::stop_token stop = stop_on_signals();
  Budget budget;
  budget.stop = stop;
  budget.threads = limits.threads ? static_cast<unsigned>(*limits.threads)
                                  : std::max(1U, std::thread::hardware_concurrency());
  budget.max_bytes =
      limits.memory_limit ? *limits.memory_limit * kMebibyte : default_memory_limit();
  if (limits.time_limit) budget.set_time_limit(*limits.time_limit);
  return budget;
}

void note_changes(const ProblemChanges& changes, Settings& settings) {
  if (changes.objective) settings["objective"] = json_string(*changes.objective);
  if (changes.direction) settings["direction"] = json_string(*changes.direction);
  if (changes.max_subassemblies)
    settings["max-subassemblies"] = fmt::to_string(*changes.max_subassemblies);
  if (changes.max_moved_parts)
    settings["max-moved-parts"] = fmt::to_string(*changes.max_moved_parts);
  if (changes.max_moved_mass) settings["max-moved-mass"] = fmt::to_string(*changes.max_moved_mass);
  if (changes.robots) settings["robots"] = fmt::to_string(*changes.robots);
  if (changes.sites) settings["sites"] = fmt::to_string(*changes.sites);
}

void note_limits(const LimitOptions& limits, Settings& settings) {
  if (limits.time_limit) settings["time-limit"] = fmt::to_string(*limits.time_limit);
  if (limits.memory_limit) settings["memory-limit"] = fmt::to_string(*limits.memory_limit);
}

std::string json_string(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string stop_text(Stop stop) {
  if (stop == Stop::None) return {};
  return stop == Stop::Cancelled ? "interrupted"
                                 : fmt::format("stopped by the {}", stop_name(stop));
}

int exit_code(const Result& result) {
  if (result.status == Status::Infeasible) return kNoPlan;
  return result.stop != Stop::None || result.status == Status::Unknown ? kStopped : kSolved;
}

}  // namespace orasp::cli
