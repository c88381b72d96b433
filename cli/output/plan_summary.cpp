#include "cli/output/plan_summary.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/options/problem_source.h"
#include "cli/output/fleet_table.h"
#include "cli/output/step_table.h"
#include "cli/output/text.h"
#include "orasp/model/plan_moves.h"
#include "orasp/model/validate.h"

namespace orasp::cli {
namespace {

/// What a goal leaves, or the plan the other way round.
std::string opposite_order(const Problem& problem, const Evaluation& evaluation,
                           std::size_t width) {
  std::vector<std::string> ids;
  if (problem.spec().goal) {
    for (const ConnectionIndex c : evaluation.stays) ids.push_back(problem.connection_id(c));
    if (ids.empty()) ids.emplace_back("nothing");
    return fmt::format("\nstays\n{}", wrapped_list(ids, 2, width));
  }
  for (const Step& step : evaluation.steps) ids.push_back(connections_text(problem, step));
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

namespace {

using Lines = std::vector<std::pair<std::string_view, std::string>>;

/// "8 steps", or "81 m^2".
std::string amount(bool travels, double reward) {
  const double size = 0.0 - reward;
  return travels ? number_text(size) + " m^2"
                 : counted(static_cast<std::uint64_t>(std::llround(size)), "step");
}

void describe_one_robot(const Result& result, Lines& lines) {
  if (result.has_plan())
    lines.emplace_back(result.expectation ? "expected reward" : "reward",
                       number_text(result.reward));
  if (const std::optional<double> bound = result.shown_bound()) {
    lines.emplace_back("bound", number_text(*bound));
    if (result.has_plan()) lines.emplace_back("gap", number_text(*bound - result.reward));
  }
  if (!result.expectation) return;
  lines.emplace_back("error",
                     fmt::format("at most {} (residual {})", number_text(result.expectation->error),
                                 number_text(result.expectation->residual)));
  lines.emplace_back("attempts", number_text(result.expectation->attempts) + " expected");
  lines.emplace_back("policy", counted(result.expectation->policy.size(), "state"));
}

void describe_fleet(const Problem& problem, const Result& result, Lines& lines) {
  const bool travels = problem.objective().type == "fleet_travel";
  if (result.has_plan()) {
    lines.emplace_back("makespan", counted(result.fleet_plan.makespan(), "step"));
    lines.emplace_back("travel", number_text(result.fleet_plan.travel()) + " m^2");
  }
  const std::optional<double> bound = result.shown_bound();
  if (!bound) return;
  lines.emplace_back("bound", "at least " + amount(travels, *bound));
  if (result.has_plan())
    lines.emplace_back("gap", number_text(std::max(0.0, *bound - result.reward)));
}

std::string fleet_objective_text(const Problem& problem, const Result& result) {
  if (problem.objective().type == "makespan") return "makespan: the fewest steps";
  return result.steps_allowed ? fmt::format("fleet_travel: the least in at most {}",
                                            counted(*result.steps_allowed, "step"))
                              : "fleet_travel: the least in the fewest steps";
}

std::string steps_of_one_robot(const Task& task, const Result& result, const Context& context) {
  const TransitionSystem system(task.problem, task.situation);
  const Evaluation evaluation =
      result.steps.empty() ? evaluate_moves(system, result.sequence) : evaluate(system, result);
  if (evaluation.steps.empty() && !task.problem.spec().goal) return {};
  std::string text;
  if (result.expectation) text += course_text(task.problem, *result.expectation, context.width());
  if (!evaluation.steps.empty()) text += '\n' + step_table(task.problem, evaluation.steps, context);
  return text + opposite_order(task.problem, evaluation, context.width());
}

}  // namespace

std::string plan_summary(const Task& task, const std::string& typed, const Result& result,
                         const Context& context) {
  const Problem& problem = task.problem;
  const bool of_fleet = problem.objective().of_fleet();
  std::string text =
      fmt::format("{}: {}, {}", title(problem, typed), counted(problem.num_parts(), "part"),
                  counted(problem.num_connections(), "connection"));
  Lines lines = {{"method", result.method}};
  if (of_fleet) {
    const Fleet& fleet = *problem.spec().fleet;
    text += fmt::format(", {}, {}", counted(fleet.robots, "robot"),
                        counted(fleet.sites.size(), "site"));
    lines.emplace_back("objective", fleet_objective_text(problem, result));
  }
  lines.emplace_back("status", status_text(result.status, result.stop, context.colour()));
  of_fleet ? describe_fleet(problem, result, lines) : describe_one_robot(result, lines);
  lines.emplace_back("effort", statistics_text(result));
  text += '\n';
  const int width = of_fleet ? 9 : result.expectation ? 15 : 8;
  for (const auto& [name, value] : lines) text += fmt::format("{:<{}} {}\n", name, width, value);
  if (!result.has_plan()) return text;
  if (!of_fleet) return text + steps_of_one_robot(task, result, context);
  if (result.fleet_plan.steps.empty()) return text;
  return text + '\n' + fleet_table(problem, result.fleet_plan, context);
}

}  // namespace orasp::cli
