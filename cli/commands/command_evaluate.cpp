#include "cli/commands/command_evaluate.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/fleet_summary.h"
#include "cli/output/json_output.h"
#include "cli/output/step_table.h"
#include "cli/output/text.h"
#include "orasp/io/fleet_plan_json.h"
#include "orasp/model/validate.h"

namespace orasp::cli {
namespace {

nlohmann::ordered_json as_json(const Evaluation& evaluation) {
  nlohmann::ordered_json violations = nlohmann::ordered_json::array();
  for (const StepViolation& found : evaluation.violations) {
    violations.push_back({{"step", found.step},
                          {"connection", found.connection},
                          {"constraint", constraint_name(found.violation.constraint)},
                          {"message", found.violation.message}});
  }
  return {{"valid", evaluation.valid},
          {"reward", evaluation.reward},
          {"steps", evaluation.steps.size()},
          {"violations", std::move(violations)}};
}

std::string summary(const Problem& problem, const Evaluation& evaluation,
                    const EvaluateOptions& options, const Context& context) {
  std::string text = fmt::format("{}: {}\n", title(problem, options.problem),
                                 evaluation.valid ? "the plan is valid" : "the plan is not valid");
  text += fmt::format("reward   {}\nsteps    {} of {}\n", number_text(evaluation.reward),
                      grouped(evaluation.steps.size()), grouped(problem.num_connections()));
  if (!evaluation.steps.empty()) text += '\n' + step_table(problem, evaluation.steps, context);
  if (!evaluation.violations.empty())
    text += fmt::format("\n{}\n", counted(evaluation.violations.size(), "violation"));
  for (const StepViolation& found : evaluation.violations) {
    text += fmt::format("  step {}, {}: {}: {}\n", found.step, printable(found.connection),
                        constraint_name(found.violation.constraint),
                        printable(found.violation.message));
  }
  return text;
}

nlohmann::ordered_json as_json(const FleetEvaluation& evaluation, double reward) {
  nlohmann::ordered_json violations = nlohmann::ordered_json::array();
  for (const FleetViolation& found : evaluation.violations) {
    violations.push_back({{"step", found.step},
                          {"connection", found.connection},
                          {"constraint", rule_name(found.rule)},
                          {"message", found.message}});
  }
  return {{"valid", evaluation.valid},    {"reward", reward},
          {"steps", evaluation.makespan}, {"makespan", evaluation.makespan},
          {"travel", evaluation.travel},  {"violations", std::move(violations)}};
}

std::string summary(const FleetProblem& fleet, const FleetPlan& plan,
                    const FleetEvaluation& evaluation, const EvaluateOptions& options,
                    const Context& context) {
  std::string text = fmt::format("{}: {}\n", title(fleet.problem(), options.problem),
                                 evaluation.valid ? "the plan is valid" : "the plan is not valid");
  text += fmt::format("makespan {}\ntravel   {} m^2\n", counted(evaluation.makespan, "step"),
                      number_text(evaluation.travel));
  if (!plan.steps.empty()) text += '\n' + fleet_table(fleet, plan, context);
  if (!evaluation.violations.empty())
    text += fmt::format("\n{}\n", counted(evaluation.violations.size(), "violation"));
  for (const FleetViolation& found : evaluation.violations)
    text += fmt::format("  step {}: {}: {}\n", found.step, rule_name(found.rule),
                        printable(found.message));
  return text;
}

int evaluate_fleet_plan(const Problem& problem, const std::string& text,
                        const EvaluateOptions& options, const Context& context) {
  const FleetProblem fleet(problem);
  FleetPlanFile file;
  try {
    file = parse_fleet_plan(text, fleet);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}: {}", options.plan == "-" ? "standard input" : options.plan, error.what()));
  }
  warn_of_another_problem(context, file.problem_digest, problem);
  if (options.changes.objective) {
    const auto objective = fleet_objective_called(*options.changes.objective);
    if (!objective)
      throw InputError(fmt::format(
          "--objective: the objectives of a plan of several robots are makespan and travel, not {}",
          in_quotes(*options.changes.objective)));
    file.objective = *objective;
  }
  const FleetEvaluation evaluation = evaluate(fleet, file.plan);
  const double reward = file.objective == FleetObjective::Makespan
                            ? 0.0 - static_cast<double>(evaluation.makespan)
                            : 0.0 - evaluation.travel;
  print_result(context, options.output, options.json, as_json(evaluation, reward),
               [&] { return summary(fleet, file.plan, evaluation, options, context); });
  return evaluation.valid ? kSolved : kNoPlan;
}

}  // namespace

int run(const EvaluateOptions& options, const Context& context) {
  if (options.problem == "-" && options.plan == "-")
    throw InputError("PROBLEM and PLAN cannot both be read from standard input");
  const std::string text = read_text(options.plan);
  const bool for_fleet = is_fleet_plan(text);
  ProblemChanges changes = options.changes;
  if (for_fleet) changes.objective.reset();  // it is one of fleets, or means nothing
  const Problem problem = load_fleet_problem(options.problem, changes, context);
  if (for_fleet) return evaluate_fleet_plan(problem, text, options, context);
  warn_of_unused_fleet(problem, context);
  const PlanFile plan = parse_plan_text(text, options.plan, problem.direction());
  warn_of_another_problem(context, plan.problem_digest, problem);

  const Evaluation evaluation = evaluate(problem, plan.sequence);
  print_result(context, options.output, options.json, as_json(evaluation),
               [&] { return summary(problem, evaluation, options, context); });
  return evaluation.valid ? kSolved : kNoPlan;
}

int evaluate_command(const Arguments& arguments) {
  EvaluateOptions options;
  bool quiet = false;
  CommandLine line("evaluate",
                   "Replays a plan step by step: its reward, and every rule that it breaks.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.positional(
      "PLAN", options.plan,
      "a plan file, a JSON array of connection ids or a text with one id a line, in the problem's "
      "direction; - for standard input");
  add_problem_options(line, options.changes);
  add_output_options(line, options.json, options.output, quiet, "the verdict");
  line.footer(
      "\nExamples:\n"
      "  orasp evaluate hubble plan.json\n"
      "  orasp solve hubble --method greedy --json | orasp evaluate hubble -\n"
      "  orasp evaluate product.json order.txt --max-moved-parts 3\n"
      "\n"
      "Exit codes: 0 valid, 10 not valid, 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

}  // namespace orasp::cli
