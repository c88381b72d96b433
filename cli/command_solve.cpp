#include "cli/command_solve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "cli/progress.h"
#include "cli/step_table.h"
#include "cli/text.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/plan_json.h"
#include "orasp/model/validate.h"

namespace orasp::cli {
namespace {

void refuse_foreign_options(const SolveOptions& options) {
  if (options.method == "value-iteration") return;
  const char* const foreign = options.sweep_order     ? "--sweep-order"
                              : options.epsilon       ? "--epsilon"
                              : options.max_sweeps    ? "--max-sweeps"
                              : options.initial_value ? "--initial-value"
                                                      : nullptr;
  if (foreign != nullptr)
    throw InputError(fmt::format("{} belongs to the method value-iteration, not to {}", foreign,
                                 options.method));
}

ValueIterationOptions::Order sweep_order_called(const std::string& name) {
  if (name == "layers") return ValueIterationOptions::Order::Layers;
  if (name == "textbook") return ValueIterationOptions::Order::Textbook;
  throw InputError(
      fmt::format("--sweep-order: {} is neither layers nor textbook", in_quotes(name)));
}

Options planner_options(const SolveOptions& options) {
  Options chosen;
  chosen.seed = options.seed;
  ValueIterationOptions& sweeps = chosen.value_iteration;
  if (options.sweep_order) sweeps.order = sweep_order_called(*options.sweep_order);
  sweeps.epsilon = options.epsilon.value_or(sweeps.epsilon);
  sweeps.max_sweeps = options.max_sweeps.value_or(sweeps.max_sweeps);
  sweeps.initial_value = options.initial_value.value_or(sweeps.initial_value);
  return chosen;
}

Settings settings_of(const SolveOptions& options) {
  Settings settings;
  settings["method"] = json_string(options.method);
  note_changes(options.changes, settings);
  note_limits(options.limits, settings);
  if (options.sweep_order) settings["sweep-order"] = json_string(*options.sweep_order);
  if (options.epsilon) settings["epsilon"] = fmt::to_string(*options.epsilon);
  if (options.max_sweeps) settings["max-sweeps"] = fmt::to_string(*options.max_sweeps);
  if (options.initial_value) settings["initial-value"] = fmt::to_string(*options.initial_value);
  return settings;
}

/// "optimal (proved)", "feasible (stopped by the time limit; not proved best)".
std::string status_text(const Result& result, bool colour) {
  std::string meaning;
  const char* shade = "\x1b[33m";
  switch (result.status) {
    case Status::Optimal:
      meaning = "proved";
      shade = "\x1b[32m";
      break;
    case Status::Feasible:
      meaning = "not proved best";
      break;
    case Status::Infeasible:
      meaning = "proved: no plan exists";
      shade = "\x1b[31m";
      break;
    case Status::Unknown:
      meaning = "neither a plan nor a proof that there is none";
      break;
  }
  if (result.stop != Stop::None) meaning = stop_text(result.stop) + "; " + meaning;
  const std::string_view name = status_name(result.status);
  return colour ? fmt::format("{}{}\x1b[0m ({})", shade, name, meaning)
                : fmt::format("{} ({})", name, meaning);
}

/// The proved bound, if there is one. It is a sum of the same numbers as the reward in another
/// order: what rounding did to them is not a gap.
std::optional<double> known_bound(const Result& result) {
  if (result.status == Status::Optimal) return result.reward;
  if (!result.bound || !std::isfinite(*result.bound)) return std::nullopt;
  return result.has_plan() ? std::max(*result.bound, result.reward) : *result.bound;
}

/// "12,096 states, 67,824 actions, 12,096 expanded, 0.00412 s, 1.2 MiB"; what is 0 is left out.
std::string statistics_text(const Statistics& statistics) {
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
  add(statistics.sweeps, statistics.sweeps == 1 ? "sweep" : "sweeps");
  text += seconds_text(statistics.seconds);
  if (statistics.peak_bytes > 0) text += ", " + bytes_text(statistics.peak_bytes);
  return text;
}

std::string opposite_order(const Problem& problem, const Result& result, std::size_t width) {
  std::vector<std::string> ids;
  for (const ConnectionIndex c : result.sequence) ids.push_back(problem.connection_id(c));
  std::ranges::reverse(ids);
  const bool assembly = problem.direction() == Direction::Assembly;
  return fmt::format("\n{} order\n{}", assembly ? "disassembly" : "assembly",
                     wrapped_list(ids, 2, width));
}

std::string summary(const Problem& problem, const Result& result, const SolveOptions& options,
                    const Context& context) {
  std::string text;
  const auto line = [&text](std::string_view name, const std::string& value) {
    text += fmt::format("{:<8} {}\n", name, value);
  };
  text += fmt::format("{}: {}, {}\n", title(problem, options.problem),
                      counted(problem.num_parts(), "part"),
                      counted(problem.num_connections(), "connection"));
  line("method", result.method);
  line("status", status_text(result, context.colour()));
  if (result.has_plan()) line("reward", number_text(result.reward));
  if (const std::optional<double> bound = known_bound(result)) {
    line("bound", number_text(*bound));
    if (result.has_plan()) line("gap", number_text(*bound - result.reward));
  }
  line("effort", statistics_text(result.statistics));

  if (result.has_plan()) {
    const Evaluation evaluation =
        evaluate(problem, std::span<const ConnectionIndex>(result.sequence));
    if (!evaluation.valid)
      throw std::logic_error(fmt::format("{} returned a plan that breaks a rule: {}", result.method,
                                         evaluation.violations.front().violation.message));
    if (!evaluation.steps.empty()) {
      text += '\n' + step_table(problem, evaluation.steps, context);
      text += opposite_order(problem, result, context.width());
    }
  }
  if (!result.notes.empty()) text += '\n';
  for (const std::string& note : result.notes) text += printable(note) + '\n';
  return text;
}

}  // namespace

int run(const SolveOptions& options, const Context& context) {
  const Planner& planner = planner_named(options.method);
  refuse_foreign_options(options);
  const Options chosen = planner_options(options);
  const Problem problem = load_problem(options.problem, options.changes, context);

  Result result;
  {
    ProgressLine progress(context, title(problem, options.problem) + ", " + options.method);
    Budget budget = make_budget(options.limits);
    progress.attach_to(budget);
    result = solve(problem, planner.name, chosen, budget);
  }
  const std::string plan = options.json || !options.output.empty()
                               ? plan_text(problem, result, settings_of(options))
                               : std::string();
  if (!options.output.empty()) {
    // What stands in the file may be the plan of yesterday: a run without a plan leaves it alone.
    if (result.has_plan()) {
      write_file(options.output, plan);
    } else {
      context.warn("there is no plan, so " + options.output + " is not written");
    }
  }
  context.print(options.json ? plan : summary(problem, result, options, context));
  return exit_code(result);
}

}  // namespace orasp::cli
