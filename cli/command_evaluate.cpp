#include "cli/command_evaluate.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/json_output.h"
#include "cli/step_table.h"
#include "cli/text.h"
#include "orasp/io/problem_json.h"
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

}  // namespace

int run(const EvaluateOptions& options, const Context& context) {
  if (options.problem == "-" && options.plan == "-")
    throw InputError("PROBLEM and PLAN cannot both be read from standard input");
  const Problem problem = load_problem(options.problem, options.changes, context);
  const PlanFile plan = read_plan(options.plan, problem.direction());
  if (!plan.problem_digest.empty() && plan.problem_digest != problem_digest(problem))
    context.warn("the plan was made for another problem: its problem_digest differs");

  const Evaluation evaluation = evaluate(problem, plan.sequence);
  print_result(context, options.output, options.json, as_json(evaluation),
               [&] { return summary(problem, evaluation, options, context); });
  return evaluation.valid ? kSolved : kNoPlan;
}

}  // namespace orasp::cli
