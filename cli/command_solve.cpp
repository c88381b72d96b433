#include "cli/command_solve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/progress.h"
#include "cli/step_table.h"
#include "cli/text.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/plan_json.h"
#include "orasp/model/validate.h"
#include "orasp/planners/alternatives.h"
#include "orasp/planners/state_graph.h"

namespace orasp::cli {
namespace {

void refuse_foreign_options(const SolveOptions& options) {
  const auto searches = {"orasp-search", "a-star", "beam", "q-learning"};
  if (options.bound && std::ranges::find(searches, options.method) == searches.end()) {
    throw InputError(fmt::format(
        "--bound belongs to the methods orasp-search, a-star, beam and q-learning, not to {}",
        options.method));
  }
  if (!options.policy.empty() && options.method != "dqn") {
    throw InputError(fmt::format("--policy belongs to the method dqn, not to {}", options.method));
  }
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
  if (options.bound) {
    const std::vector<std::string> known(kBoundNames.begin(), kBoundNames.end());
    if (std::ranges::find(known, *options.bound) == known.end()) {
      throw InputError(fmt::format("--bound: {} is not a bound; bounds are {}{}",
                                   in_quotes(*options.bound), fmt::join(known, ", "),
                                   suggestion(*options.bound, known)));
    }
    chosen.bound = bound_called(*options.bound);
  }
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
  if (options.bound) settings["bound"] = json_string(*options.bound);
  if (!options.policy.empty()) settings["policy"] = json_string(options.policy);
  if (options.sweep_order) settings["sweep-order"] = json_string(*options.sweep_order);
  if (options.epsilon) settings["epsilon"] = fmt::to_string(*options.epsilon);
  if (options.max_sweeps) settings["max-sweeps"] = fmt::to_string(*options.max_sweeps);
  if (options.initial_value) settings["initial-value"] = fmt::to_string(*options.initial_value);
  if (options.count) settings["count"] = "true";
  if (options.alternatives > 0) settings["alternatives"] = fmt::to_string(options.alternatives);
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
    case Status::Feasible: meaning = "not proved best"; break;
    case Status::Infeasible:
      meaning = "proved: no plan exists";
      shade = "\x1b[31m";
      break;
    case Status::Unknown: meaning = "neither a plan nor a proof that there is none"; break;
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

std::string opposite_order(const Problem& problem, const Result& result, std::size_t width) {
  std::vector<std::string> ids;
  for (const ConnectionIndex c : result.sequence) ids.push_back(problem.connection_id(c));
  std::ranges::reverse(ids);
  const bool assembly = problem.direction() == Direction::Assembly;
  return fmt::format("\n{} order\n{}", assembly ? "disassembly" : "assembly",
                     wrapped_list(ids, 2, width));
}

bool wants_other_plans(const SolveOptions& options) {
  return options.count || options.alternatives > 0;
}

/// Before the method runs: where H does not fit, nothing is done.
void require_graph_for_other_plans(const TransitionSystem& system, const SolveOptions& options,
                                   const Budget& budget) {
  const std::string asked_by = options.count ? "--count" : "--alternatives";
  try {
    require_graph_fits(system, budget, asked_by);
  } catch (const InputError& error) {
    const std::string reason = error.what();  // it goes on with methods that need no H
    throw InputError(reason.substr(0, reason.rfind("; use ")));
  }
}

std::string alternatives_text(const Problem& problem, const Alternatives& alternatives,
                              const SolveOptions& options, const Context& context) {
  std::string text;
  if (alternatives.optimal_sequences)
    text += '\n' + counted(*alternatives.optimal_sequences, "optimal sequence") + '\n';
  if (!alternatives.plans || alternatives.plans->empty()) return text;
  const std::vector<Alternative>& plans = *alternatives.plans;
  std::vector<double> rewards;
  for (const Alternative& plan : plans) rewards.push_back(plan.reward);
  const std::vector<std::string> reward_texts = aligned_numbers(rewards);
  const bool all = plans.size() < options.alternatives && alternatives.stop == Stop::None;
  text += all ? fmt::format("\nall {}\n", counted(plans.size(), "plan"))
              : fmt::format("\nthe {}\n", counted(plans.size(), "best plan"));
  for (std::size_t i = 0; i < plans.size(); ++i) {
    std::vector<std::string> ids;
    for (const ConnectionIndex c : plans[i].sequence) ids.push_back(problem.connection_id(c));
    text += fmt::format("{:>4}  reward {}\n", i + 1, reward_texts[i]);
    text += wrapped_list(ids, 6, context.width());
  }
  return text;
}

std::string summary(const Problem& problem, const Result& result, const Alternatives& alternatives,
                    const SolveOptions& options, const Context& context) {
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
  line("effort", statistics_text(result));

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
  text += alternatives_text(problem, alternatives, options, context);
  if (!result.notes.empty()) text += '\n';
  for (const std::string& note : result.notes) text += printable(note) + '\n';
  return text;
}

}  // namespace

int run(const SolveOptions& options, const Context& context) {
  const Planner& planner = planner_named(options.method);
  refuse_foreign_options(options);
  Options chosen = planner_options(options);
  const Problem problem = load_problem(options.problem, options.changes, context);
  if (!options.policy.empty()) {
    chosen.policy =
        std::make_shared<const Policy>(read_policy(options.policy, problem).trained.policy);
  }

  Result result;
  Alternatives alternatives;
  {
    ProgressLine progress(context, title(problem, options.problem) + ", " + options.method);
    Budget budget = make_budget(options.limits);
    progress.attach_to(budget);
    const TransitionSystem system(problem);
    if (wants_other_plans(options)) require_graph_for_other_plans(system, options, budget);
    result = solve(problem, planner.name, chosen, budget);
    if (wants_other_plans(options))
      alternatives = find_alternatives(system, options.count, options.alternatives, budget);
  }
  if (alternatives.stop != Stop::None) {
    result.notes.push_back(fmt::format(
        "{} was {}",
        alternatives.plans ? "the list of the best plans" : "building H for other plans",
        stop_text(alternatives.stop)));
  }
  const std::string plan = options.json || !options.output.empty()
                               ? plan_text(problem, result, settings_of(options), &alternatives)
                               : std::string();
  if (!options.output.empty()) {
    // What stands in the file may be the plan of yesterday: a run without a plan leaves it alone.
    if (result.has_plan()) {
      write_file(options.output, plan);
    } else {
      context.warn("there is no plan, so " + options.output + " is not written");
    }
  }
  context.print(options.json ? plan : summary(problem, result, alternatives, options, context));
  const int code = exit_code(result);
  return code == kSolved && alternatives.stop != Stop::None ? kStopped : code;
}

}  // namespace orasp::cli
