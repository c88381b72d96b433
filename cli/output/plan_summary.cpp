#include "cli/output/plan_summary.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "cli/options/problem_source.h"
#include "cli/output/step_table.h"
#include "cli/output/text.h"
#include "orasp/model/validate.h"

namespace orasp::cli {
namespace {

/// The proved bound, if there is one. It is a sum of the same numbers as the reward in another
/// order: what rounding did to them is not a gap.
std::optional<double> known_bound(const Result& result) {
  if (result.status == Status::Optimal) return result.reward;
  if (!result.bound || !std::isfinite(*result.bound)) return std::nullopt;
  return result.has_plan() ? std::max(*result.bound, result.reward) : *result.bound;
}

std::string opposite_order(const Problem& problem, const Result& result, std::size_t width) {
  std::vector<std::string> ids;
  for (const ConnectionIndex c : result.sequence) ids.push_back(problem.connection_id(c));
  std::ranges::reverse(ids);
  const bool assembly = problem.direction() == Direction::Assembly;
  return fmt::format("\n{} order\n{}", assembly ? "disassembly" : "assembly",
                     wrapped_list(ids, 2, width));
}

/// How the job most likely goes, where attempts may fail. The table of steps that follows is the
/// sequence of successes.
std::string course_text(const Problem& problem, const Expectation& expectation, std::size_t width) {
  const std::string probability = number_text(expectation.probability);
  if (std::ranges::all_of(expectation.most_likely, &AttemptOutcome::succeeds))
    return fmt::format("\nmost likely sequence (probability {})\n", probability);
  std::vector<std::string> items;
  for (const auto& [connection, succeeds] : expectation.most_likely)
    items.push_back(problem.connection_id(connection) + (succeeds ? "" : " fails"));
  return fmt::format(
      "\nmost likely course (probability {})\n{}\nsequence where no failure changes the state\n",
      probability, wrapped_list(items, 2, width));
}

}  // namespace

std::string statistics_text(const Result& result) {
  const Statistics& statistics = result.statistics;
  const bool learns = result.method == "q-learning" || result.method == "dqn";
  std::string text;
  const auto add = [&text](std::uint64_t number, std::string_view noun) {
    if (number > 0) text += fmt::format("{} {}, ", grouped(number), noun);
  };
  add(statistics.states, statistics.states == 1 ? "state" : "states");
  add(statistics.actions, statistics.actions == 1 ? "action" : "actions");
  add(statistics.expanded, "expanded");
  add(statistics.generated, "generated");
  add(statistics.reopened, "reopened");
  add(statistics.pruned, "pruned");
  if (statistics.sweeps > 0)
    text += counted(statistics.sweeps, learns ? "episode" : "sweep") + ", ";
  text += seconds_text(statistics.seconds);
  if (statistics.peak_bytes > 0) text += ", " + bytes_text(statistics.peak_bytes);
  return text;
}

std::string status_text(Status status, Stop stop, bool colour) {
  std::string meaning;
  const char* shade = "\x1b[33m";
  switch (status) {
    case Status::Optimal:
      meaning = "proved";
      shade = "\x1b[32m";
      break;
    case Status::Feasible: meaning = "not proved best"; break;
    case Status::Infeasible:
      meaning = "proved: no plan exists";
      shade = "\x1b[31m";
      break;
    case Status::Unknown: meaning = "neither a plan nor a proof that there is none"; break;
  }
  if (stop != Stop::None) meaning = stop_text(stop) + "; " + meaning;
  const std::string_view name = status_name(status);
  return colour ? fmt::format("{}{}\x1b[0m ({})", shade, name, meaning)
                : fmt::format("{} ({})", name, meaning);
}

std::string plan_summary(const TransitionSystem& system, const std::string& typed,
                         const Result& result, const Context& context) {
  const Problem& problem = system.problem();
  std::string text;
  const auto line = [&text, &result](std::string_view name, const std::string& value) {
    text += fmt::format("{:<{}} {}\n", name, result.expectation ? 15 : 8, value);
  };
  text += fmt::format("{}: {}, {}\n", title(problem, typed), counted(problem.num_parts(), "part"),
                      counted(problem.num_connections(), "connection"));
  line("method", result.method);
  line("status", status_text(result.status, result.stop, context.colour()));
  if (result.has_plan())
    line(result.expectation ? "expected reward" : "reward", number_text(result.reward));
  if (const std::optional<double> bound = known_bound(result)) {
    line("bound", number_text(*bound));
    if (result.has_plan()) line("gap", number_text(*bound - result.reward));
  }
  if (result.expectation) {
    line("error", fmt::format("at most {} (residual {})", number_text(result.expectation->error),
                              number_text(result.expectation->residual)));
    line("attempts", number_text(result.expectation->attempts) + " expected");
    line("policy", counted(result.expectation->policy.size(), "state"));
  }
  line("effort", statistics_text(result));

  if (result.has_plan()) {
    const Evaluation evaluation =
        evaluate(system, std::span<const ConnectionIndex>(result.sequence));
    if (!evaluation.valid)
      throw std::logic_error(fmt::format("{} returned a plan that breaks a rule: {}", result.method,
                                         evaluation.violations.front().violation.message));
    if (!evaluation.steps.empty()) {
      if (result.expectation) text += course_text(problem, *result.expectation, context.width());
      text += '\n' + step_table(problem, evaluation.steps, context);
      text += opposite_order(problem, result, context.width());
    }
  }
  return text;
}

}  // namespace orasp::cli
