#include "cli/commands/command_check.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/json_output.h"
#include "cli/output/text.h"
#include "orasp/certificate/certificate.h"
#include "orasp/io/certificate_json.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/state_policy_json.h"
#include "orasp/model/transition_system.h"

namespace orasp::cli {
namespace {

constexpr const char* kNoPlanWord = "none";

struct Verdict {
  OptimalityCheck check;
  bool infeasible = false;  ///< it is the claim that there is no plan
  std::string kind;
};

nlohmann::ordered_json number_or_nothing(double number) {
  return std::isfinite(number) ? nlohmann::ordered_json(number) : nlohmann::ordered_json();
}

nlohmann::ordered_json as_json(const Verdict& verdict) {
  const OptimalityCheck& check = verdict.check;
  nlohmann::ordered_json json = {{"proved", check.proved},
                                 {"claim", verdict.infeasible ? "infeasible" : "optimal"},
                                 {"kind", verdict.kind},
                                 {"reward", nullptr},
                                 {"bound", number_or_nothing(check.bound)},
                                 {"tolerance", check.tolerance},
                                 {"inequalities", check.inequalities}};
  if (!verdict.infeasible) json["reward"] = check.reward;
  if (!check.proved) json["fault"] = check.fault;
  return json;
}

std::string summary(const Problem& problem, const Verdict& verdict, const CheckOptions& options) {
  const OptimalityCheck& check = verdict.check;
  std::string text = title(problem, options.problem) + ": ";
  if (!check.proved) return text + "not proved: " + printable(check.fault) + '\n';
  text += verdict.infeasible ? "proved: there is no plan\n" : "proved: no plan is better\n";
  if (!verdict.infeasible)
    text += fmt::format("reward   {}\nbound    {}, reached up to rounding\n",
                        number_text(check.reward), number_text(check.bound));
  return text + fmt::format("checked  {} of the kind {}\n",
                            check.inequalities == 1 ? "1 inequality"
                                                    : grouped(check.inequalities) + " inequalities",
                            verdict.kind);
}

Certificate read_certificate(const Problem& problem, const std::string& file) {
  const std::string text = read_text(file);
  try {
    return parse_certificate(problem, text);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file == "-" ? "standard input" : file, error.what()));
  }
}

bool is_state_policy(const std::string& text) {
  const nlohmann::json file = nlohmann::json::parse(text, nullptr, false);
  return file.is_object() && file.value("format", nlohmann::json()) == "orasp-state-policy/1";
}

/// The steps of a policy for attempts that are made again until they succeed.
std::vector<ConnectionIndex> steps_of_policy(const Problem& problem, const std::string& text,
                                             const std::string& file) {
  const std::string name = file == "-" ? "standard input" : file;
  const TransitionSystem system(problem);
  std::vector<PolicyState> states;
  try {
    states = parse_state_policy(system, text);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", name, error.what()));
  }
  std::vector<ConnectionIndex> steps;
  ConnectionSet open = system.start();
  while (!open.empty()) {
    const auto here = std::ranges::find(states, open, &PolicyState::open);
    if (here == states.end() || !open.contains(here->next))
      throw InputError(fmt::format("{}: the policy says nothing of the state after step {}", name,
                                   steps.size()));
    steps.push_back(here->next);
    open.erase(here->next);
  }
  return steps;
}

OptimalityCheck checked_plan(const Problem& problem, const std::string& text,
                             const std::string& file, const Certificate& certificate,
                             const Context& context) {
  if (is_state_policy(text))
    return check_optimality(problem, steps_of_policy(problem, text, file), certificate);
  require_plan_for(problem, text, file);
  const PlanFile plan = parse_plan_text(text, file, problem.direction());
  warn_of_another_problem(context, plan.problem_digest, problem);
  return check_optimality(problem, plan, certificate);
}

}  // namespace

int run(const CheckOptions& options, const Context& context) {
  const std::vector<std::string> inputs = {options.problem, options.plan, options.certificate};
  if (std::ranges::count(inputs, "-") > 1)
    throw InputError("only one of PROBLEM, PLAN and CERTIFICATE can be read from standard input");
  const Problem problem = load_problem(options.problem, options.changes, context);
  if (const std::string reason = without_certificates(problem); !reason.empty())
    throw InputError(reason);
  const bool infeasible = options.plan == kNoPlanWord;
  // The plan first: who sends it may still be writing the certificate.
  const std::string text = infeasible ? std::string() : read_text(options.plan);
  const Certificate certificate = read_certificate(problem, options.certificate);
  Verdict verdict;
  verdict.kind = kind_name(certificate.kind);
  verdict.infeasible = infeasible;
  if (infeasible) {
    verdict.check = check_infeasibility(problem, certificate);
  } else {
    verdict.check = checked_plan(problem, text, options.plan, certificate, context);
  }
  print_result(context, options.output, options.json, as_json(verdict),
               [&] { return summary(problem, verdict, options); });
  return verdict.check.proved ? kSolved : kNoPlan;
}

CommandWork check_command(CommandLine& line) {
  const auto chosen = std::make_shared<CheckOptions>();
  CheckOptions& options = *chosen;
  line.about("Checks a certificate: that no plan earns more than this one, or that there is none.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.positional("PLAN", options.plan,
                  "a plan as `orasp evaluate` takes it, a policy of `orasp solve`, or the word "
                  "none where the certificate says "
                  "that there is no plan; - for standard input");
  line.positional("CERTIFICATE", options.certificate,
                  "what `orasp solve --certificate` wrote; - for standard input");
  add_problem_options(line, options.changes);
  add_output_options(line, options.json, options.output, "the verdict");
  line.footer(
      "\nThe check shares nothing with the planners and their bounds: docs/certificates.md.\n"
      "\nExamples:\n"
      "  orasp solve iss --output plan.json --certificate iss.cert.json\n"
      "  orasp check iss plan.json iss.cert.json\n"
      "  orasp check product.json none why-not.json\n"
      "\n"
      "Exit codes: 0 proved, 10 not proved, 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
