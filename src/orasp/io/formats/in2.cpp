#include "orasp/io/formats/in2.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::in_quotes;

/// The lines that hold something, with their numbers from 1.
struct Line {
  std::size_t number;
  std::string_view text;
};

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = detail::trimmed(text.substr(0, end));
    if (line == "\x1A") line = {};  // ends files of DOS
    if (!line.empty()) lines.push_back({number, line});
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// A whole number of `least` or more.
std::size_t whole_number(const Line& line, std::string_view text, std::string_view what,
                         std::size_t least, std::size_t greatest) {
  const auto number = detail::number_in(text);
  if (!number || *number < static_cast<double>(least) || *number > static_cast<double>(greatest) ||
      *number != static_cast<double>(static_cast<std::size_t>(*number))) {
    throw InputError(fmt::format("line {}: {} is not {}, a whole number from {} to {}", line.number,
                                 in_quotes(text), what, least, greatest));
  }
  return static_cast<std::size_t>(*number);
}

std::string task_id(std::size_t task) {
  return fmt::format("t{}", task);
}

}  // namespace

Converted read_in2(std::string_view text) {
  const std::vector<Line> lines = lines_of(detail::checked_text(text));
  if (lines.empty()) throw InputError("the file is empty");
  const std::size_t tasks =
      whole_number(lines.front(), lines.front().text, "a number of tasks", 1, kMaxParts - 1);
  Converted converted;
  ProblemSpec& problem = converted.problem;
  problem.objective = Objective("time", TimeObjective{.depot = {}, .speed = 1, .transfer = 0});
  problem.parts.push_back({.id = "base", .mass = 0});
  if (lines.size() <= tasks) {
    throw InputError(fmt::format("line {}: the file ends after the times of {} of {} tasks",
                                 lines.back().number, lines.size() - 1, tasks));
  }
  for (std::size_t task = 1; task <= tasks; ++task) {
    const Line& line = lines[task];
    const auto time = detail::number_in(line.text);
    if (!time || *time < 0) {
      throw InputError(fmt::format("line {}: {} is not the time of task {}, a number of 0 or more",
                                   line.number, in_quotes(line.text), task));
    }
    problem.parts.push_back({.id = task_id(task)});
    problem.connections.push_back(
        {.id = task_id(task), .parts = {"base", task_id(task)}, .duration = *time});
  }
  std::map<std::size_t, std::vector<std::string>> after;
  std::set<std::pair<std::size_t, std::size_t>> seen;
  bool ended = false;
  for (std::size_t i = tasks + 1; i < lines.size() && !ended; ++i) {
    const Line& line = lines[i];
    const std::size_t comma = line.text.find(',');
    if (comma == std::string_view::npos) {
      throw InputError(fmt::format("line {}: {} is not a precedence relation, which is \"i,j\"",
                                   line.number, in_quotes(line.text)));
    }
    const std::string_view before = detail::trimmed(line.text.substr(0, comma));
    const std::string_view behind = detail::trimmed(line.text.substr(comma + 1));
    if (before == "-1" && behind == "-1") {
      ended = true;
      if (i + 1 < lines.size()) {
        converted.notes.push_back(fmt::format(
            "what stands behind the end mark is left out, from line {} on", lines[i + 1].number));
      }
      continue;
    }
    const std::size_t first = whole_number(line, before, "a task", 1, tasks);
    const std::size_t second = whole_number(line, behind, "a task", 1, tasks);
    if (first == second)
      throw InputError(
          fmt::format("line {}: task {} cannot come before itself", line.number, first));
    if (seen.emplace(first, second).second) after[second].push_back(task_id(first));
  }
  for (auto& [task, before] : after)
    problem.precedence.push_back({.connection = task_id(task), .after = std::move(before)});
  return converted;
}

}  // namespace orasp
