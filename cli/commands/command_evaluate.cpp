#include "cli/commands/command_evaluate.h"

#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/fleet_table.h"
#include "cli/output/json_output.h"
#include "cli/output/step_table.h"
#include "cli/output/text.h"
#include "orasp/fleet/fleet_validate.h"
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
  // How many there are to make is known where each takes one connection until none is left.
  const bool counted_steps = !problem.spec().goal && problem.spec().action == StepKind::Connection;
  text += fmt::format("reward   {}\nsteps    {}{}\n", number_text(evaluation.reward),
                      grouped(evaluation.steps.size()),
                      counted_steps ? " of " + grouped(problem.num_connections()) : "");
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
  if (!plan.steps.empty()) text += '\n' + fleet_table(fleet.problem(), plan, context);
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
  const FleetEvaluation evaluation = evaluate(fleet, file.plan);
  const double reward = fleet.objective() == FleetObjective::Makespan
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
  const Problem problem = load_problem(options.problem, options.changes, context);
  require_plan_for(problem, text, options.plan);
  if (problem.objective().of_fleet()) return evaluate_fleet_plan(problem, text, options, context);
  const PlanFile plan = parse_plan_text(text, options.plan, problem.direction());
  warn_of_another_problem(context, plan.problem_digest, problem);

  const Evaluation evaluation = replayed(problem, plan);
  print_result(context, options.output, options.json, as_json(evaluation),
               [&] { return summary(problem, evaluation, options, context); });
  return evaluation.valid ? kSolved : kNoPlan;
}

CommandWork evaluate_command(CommandLine& line) {
  const auto chosen = std::make_shared<EvaluateOptions>();
  EvaluateOptions& options = *chosen;
  line.about("Replays a plan step by step: its reward, and every rule that it breaks.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.positional(
      "PLAN", options.plan,
      "a plan file, a JSON array of connection ids or a text with one id a line, in the problem's "
      "direction; - for standard input");
  add_problem_options(line, options.changes);
  add_output_options(line, options.json, options.output, "the verdict");
  line.footer(
      "\nExamples:\n"
      "  orasp evaluate hubble plan.json\n"
      "  orasp solve hubble --method greedy --json | orasp evaluate hubble -\n"
      "  orasp evaluate product.json order.txt --max-moved-parts 3\n"
      "\n"
      "Exit codes: 0 valid, 10 not valid, 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
