#include "cli/output/fleet_summary.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/output/plan_summary.h"
#include "cli/output/text.h"

namespace orasp::cli {
namespace {

constexpr std::size_t kLeastListWidth = 16;

/// "8 steps", or "81 m^2".
std::string amount(FleetObjective objective, double reward) {
  const double size = 0.0 - reward;
  return objective == FleetObjective::Makespan
             ? counted(static_cast<std::uint64_t>(std::llround(size)), "step")
             : number_text(size) + " m^2";
}

std::string effort_text(const Statistics& statistics) {
  std::string text;
  const auto add = [&text](std::uint64_t number, std::string_view noun) {
    if (number > 0) text += fmt::format("{} {}, ", grouped(number), noun);
  };
  add(statistics.states, "states");
  add(statistics.expanded, "expanded");
  add(statistics.generated, "generated");
  add(statistics.pruned, "pruned");
  text += seconds_text(statistics.seconds);
  if (statistics.peak_bytes > 0) text += ", " + bytes_text(statistics.peak_bytes);
  return text;
}

}  // namespace

std::optional<FleetObjective> fleet_objective_called(const std::string& name) {
  for (const FleetObjective objective : {FleetObjective::Makespan, FleetObjective::Travel}) {
    if (name == objective_name(objective)) return objective;
  }
  return std::nullopt;
}

bool plans_for_fleet(const Planner& planner, const Problem& problem,
                     const std::optional<std::string>& objective) {
  const bool asks_for_fleet = objective && fleet_objective_called(*objective).has_value();
  if (planner.run == nullptr) {
    if (objective && !asks_for_fleet)
      throw InputError(
          fmt::format("--objective: {} plans for several robots, whose objectives are makespan and "
                      "travel, not {}",
                      planner.name, in_quotes(*objective)));
    return true;
  }
  if (planner.run_fleet != nullptr && problem.spec().fleet && (!objective || asks_for_fleet))
    return true;
  if (objective == "makespan")
    throw InputError(
        planner.run_fleet == nullptr
            ? fmt::format("--objective: {} plans for one robot, and makespan is an objective of "
                          "several; fleet-search plans for them",
                          planner.name)
            : "--objective: makespan is an objective of several robots, and the problem has no "
              "\"fleet\"");
  return false;
}

void warn_of_unused_fleet(const Problem& problem, const Context& context) {
  if (problem.spec().fleet)
    context.warn(fmt::format("fleet: its {} are not used; fleet-search plans for them",
                             counted(problem.spec().fleet->robots, "robot")));
}

void require_valid(const FleetProblem& fleet, const FleetResult& result) {
  if (!result.has_plan()) return;
  const FleetEvaluation evaluation = evaluate(fleet, result.plan);
  if (!evaluation.valid)
    throw std::logic_error(fmt::format("{} returned a plan that breaks a rule: step {}: {}",
                                       result.method, evaluation.violations.front().step,
                                       evaluation.violations.front().message));
}

int exit_code(const FleetResult& result) {
  if (result.status == Status::Infeasible) return kNoPlan;
  return result.stop != Stop::None || result.status == Status::Unknown ? kStopped : kSolved;
}

std::string fleet_table(const FleetProblem& fleet, const FleetPlan& plan, const Context& context) {
  const Problem& problem = fleet.problem();
  constexpr std::size_t kOtherColumns = 52;
  const std::size_t width =
      std::max(kLeastListWidth, (context.width() - std::min(context.width(), kOtherColumns)) / 2);
  TextTable table;
  table.add_column("step", TextTable::Align::Right);
  table.add_column("robots", TextTable::Align::Left);
  table.add_column("parts", TextTable::Align::Left);
  table.add_column("from", TextTable::Align::Left);
  table.add_column("to", TextTable::Align::Left);
  table.add_column("motion", TextTable::Align::Left);
  table.add_column("distance", TextTable::Align::Right);
  table.add_column("cuts", TextTable::Align::Left);
  std::vector<double> distances;
  for (const FleetStep& step : plan.steps) {
    for (const FleetMove& move : step.moves) distances.push_back(move.distance);
  }
  const std::vector<std::string> distance_texts = aligned_numbers(distances);
  std::size_t next_distance = 0;
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    const FleetStep& step = plan.steps[i];
    std::vector<std::string> cut;
    for (const ConnectionIndex c : step.cut) cut.push_back(problem.connection_id(c));
    bool first = true;
    for (const FleetMove& move : step.moves) {
      std::vector<std::string> robots;
      std::vector<std::string> parts;
      for (const std::size_t robot : move.robots) robots.push_back(fmt::to_string(robot));
      for (const PartIndex part : move.parts) parts.push_back(problem.part_id(part));
      table.add_row({first ? fmt::to_string(i + 1) : "", capped_list(robots, width),
                     capped_list(parts, width), FleetProblem::place_name(move.from),
                     FleetProblem::place_name(move.to), std::string(motion_name(move.motion)),
                     distance_texts[next_distance++], first ? capped_list(cut, width) : ""});
      first = false;
    }
  }
  return table.text(context.colour());
}

std::string fleet_summary(const FleetProblem& fleet, const std::string& typed,
                          const FleetResult& result, const Context& context) {
  const Problem& problem = fleet.problem();
  std::string text = fmt::format(
      "{}: {}, {}, {}, {}\n", title(problem, typed), counted(problem.num_parts(), "part"),
      counted(problem.num_connections(), "connection"), counted(fleet.robots(), "robot"),
      counted(fleet.num_sites(), "site"));
  const auto line = [&text](std::string_view name, const std::string& value) {
    text += fmt::format("{:<9} {}\n", name, value);
  };
  line("method", result.method);
  line("objective", result.objective == FleetObjective::Makespan ? "makespan: the fewest steps"
                    : result.steps_allowed ? fmt::format("travel: the least in at most {}",
                                                         counted(*result.steps_allowed, "step"))
                                           : std::string("travel: the least in the fewest steps"));
  line("status", status_text(result.status, result.stop, context.colour()));
  if (result.has_plan()) {
    line("makespan", counted(result.plan.makespan(), "step"));
    line("travel", number_text(result.plan.travel()) + " m^2");
  }
  if (result.bound && std::isfinite(*result.bound)) {
    line("bound", "at least " + amount(result.objective, *result.bound));
    if (result.has_plan()) line("gap", number_text(std::max(0.0, *result.bound - result.reward)));
  }
  line("effort", effort_text(result.statistics));
  if (!result.plan.steps.empty()) text += '\n' + fleet_table(fleet, result.plan, context);
  if (!result.notes.empty()) text += '\n';
  for (const std::string& note : result.notes) text += printable(note) + '\n';
  return text;
}

}  // namespace orasp::cli
