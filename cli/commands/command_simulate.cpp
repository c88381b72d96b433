#include "cli/commands/command_simulate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/json_output.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/catalogue.h"
#include "orasp/execution/simulation.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/state_policy_json.h"
#include "orasp/model/validate.h"
#include "orasp/planners/reward_statistics.h"
#include "orasp/task/task.h"

namespace orasp::cli {
namespace {

struct AttemptFigures {
  double mean = 0;
  std::uint64_t most = 0;
};

AttemptFigures attempt_figures(const std::vector<std::uint64_t>& attempts) {
  AttemptFigures figures;
  if (attempts.empty()) return figures;
  double total = 0;
  for (const std::uint64_t number : attempts) total += static_cast<double>(number);
  figures.mean = total / static_cast<double>(attempts.size());
  figures.most = *std::ranges::max_element(attempts);
  return figures;
}

double standard_error(const RewardFigures& figures, std::size_t runs) {
  return runs == 0 ? 0 : figures.deviation / std::sqrt(static_cast<double>(runs));
}

std::vector<PolicyState> policy_of(const TransitionSystem& system, const std::string& file) {
  const std::string text = read_text(file);
  try {
    return parse_state_policy(system, text);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file == "-" ? "standard input" : file, error.what()));
  }
}

Followed followed(const TransitionSystem& system, const SimulateOptions& options,
                  const Context& context) {
  const Problem& problem = system.problem();
  if (system.wide() && !options.policy.empty())
    throw InputError(
        "--policy: a policy is for attempts that may fail, and here each succeeds; give a plan");
  std::optional<Evaluation> plan;
  if (!options.plan.empty()) {
    const PlanFile file = read_plan(options.plan, problem.direction());
    warn_of_another_problem(context, file.problem_digest, problem);
    plan = replayed(problem, file);
  }
  std::optional<std::vector<PolicyState>> policy;
  if (!options.policy.empty()) policy = policy_of(system, options.policy);

  ProgressLine progress(context, title(problem, options.problem) + ", simulate");
  Budget budget = make_budget(options.limits);
  progress.attach_to(budget);
  const auto find = [&](const Budget& within) {
    return solve(Task(problem), "auto", Options(), within);
  };
  return follow(system, plan ? &*plan : nullptr, policy ? &*policy : nullptr, find,
                {.runs = options.count, .seed = options.seed}, budget);
}

nlohmann::ordered_json as_json(const Followed& outcome, const RewardFigures& figures,
                               const AttemptFigures& attempts, const SimulateOptions& options) {
  const std::size_t runs = outcome.simulation.rewards.size();
  const auto number = [&](double value) {
    return runs == 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
  };
  nlohmann::ordered_json percentiles = nlohmann::ordered_json::object();
  constexpr std::array<const char*, 5> kNames = {"5", "25", "50", "75", "95"};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    percentiles[kNames[i]] = number(figures.percentiles[i]);
  return {{"n", runs},
          {"seed", options.seed},
          {"expected", outcome.status == Status::Feasible ? nlohmann::ordered_json(outcome.expected)
                                                          : nlohmann::ordered_json()},
          {"mean", number(figures.mean)},
          {"deviation", number(figures.deviation)},
          {"standard_error", number(standard_error(figures, runs))},
          {"min", number(figures.least)},
          {"percentiles", std::move(percentiles)},
          {"max", number(figures.greatest)},
          {"attempts",
           {{"mean", number(attempts.mean)},
            {"max", runs == 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(attempts.most)}}},
          {"aborted", outcome.simulation.aborted},
          {"replanned", outcome.simulation.replanned}};
}

std::string summary(const Problem& problem, const Followed& outcome, const RewardFigures& figures,
                    const AttemptFigures& attempts, const SimulateOptions& options) {
  const Simulation& simulation = outcome.simulation;
  const std::size_t runs = simulation.rewards.size();
  const char* const followed = !options.plan.empty()     ? "the plan"
                               : !options.policy.empty() ? "the policy"
                               : outcome.proved_best     ? "an optimal policy, solved first"
                                                         : "a plan, not proved best, found first";
  std::string text =
      fmt::format("{}: {} of {} with {}, seed {}\n", title(problem, options.problem), grouped(runs),
                  counted(options.count, "run"), followed, options.seed);
  if (runs > 0) {
    const std::vector<double> numbers = {
        outcome.expected,       figures.mean,           standard_error(figures, runs),
        figures.deviation,      figures.least,          figures.percentiles[0],
        figures.percentiles[1], figures.percentiles[2], figures.percentiles[3],
        figures.percentiles[4], figures.greatest};
    const std::vector<std::string> texts = aligned_numbers(numbers);
    constexpr std::array<const char*, 11> kNames = {
        "expected reward", "mean",   "standard error", "deviation", "minimum", "5 %",
        "lower quartile",  "median", "upper quartile", "95 %",      "maximum"};
    std::size_t widest = 0;
    for (const std::string& number : texts) widest = std::max(widest, number.size());
    for (std::size_t i = 0; i < texts.size(); ++i)
      text += fmt::format("{:<15}  {:>{}}\n", kNames[i], texts[i], widest);
    const auto line = [&text](const char* name, const std::string& value) {
      text += fmt::format("{:<15}  {}\n", name, value);
    };
    text += '\n';
    line("attempts", fmt::format("{} a run, {} expected, at most {}", number_text(attempts.mean),
                                 number_text(outcome.expected_attempts), grouped(attempts.most)));
    line("aborted", fmt::format("{} of {}", grouped(simulation.aborted), counted(runs, "run")));
    if (!outcome.plan.empty()) line("replanned", counted(simulation.replanned, "time"));
  }
  if (outcome.status == Status::Infeasible) text += "\ninfeasible (proved)\n";
  if (simulation.stop != Stop::None) text += '\n' + stop_text(simulation.stop) + '\n';
  for (const std::string& note : outcome.notes) text += printable(note) + '\n';
  return text;
}

}  // namespace

int run(const SimulateOptions& options, const Context& context) {
  if (!options.plan.empty() && !options.policy.empty())
    throw InputError("only one of --plan and --policy can be given");
  if (options.problem == "-" && (options.plan == "-" || options.policy == "-"))
    throw InputError("PROBLEM and what to follow cannot both be read from standard input");
  const Problem problem =
      load_one_robot_problem(options.problem, options.changes, context, "simulate");
  const TransitionSystem system(problem);
  if (const auto reason = simulation_obstacle(system)) throw InputError(*reason);
  const Followed outcome = followed(system, options, context);
  const RewardFigures figures = figures_of(outcome.simulation.rewards);
  const AttemptFigures attempts = attempt_figures(outcome.simulation.attempts);
  if (options.json) {
    for (const std::string& note : outcome.notes) context.warn(printable(note));
  }
  print_result(context, options.output, options.json, as_json(outcome, figures, attempts, options),
               [&] { return summary(problem, outcome, figures, attempts, options); });
  if (outcome.status == Status::Infeasible) return kNoPlan;
  return outcome.simulation.stop == Stop::None ? kSolved : kStopped;
}

CommandWork simulate_command(CommandLine& line) {
  const auto chosen = std::make_shared<SimulateOptions>();
  SimulateOptions& options = *chosen;
  line.about(
      "Executes a plan or a policy with random failures, again and again, and describes\n"
      "the rewards and the attempts. The mean agrees with the computed expectation.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Followed");
  line.text(
      "--plan", "FILE",
      "Follow this plan; where its next connection is not legal, replan; - for standard input "
      "(default: an optimal policy, solved first).",
      options.plan);
  line.text(
      "--policy", "FILE",
      "Follow this policy of `orasp solve -o`; - for standard input (default: an optimal one, "
      "solved first).",
      options.policy);
  line.group("Simulation");
  line.whole("-n,--count", "N", "Runs (default: 10000).", options.count, 1);
  add_seed_option(line, options.seed, "the failures");
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits, "", false);
  add_output_options(line, options.json, options.output, "the figures");
  line.footer(
      "\nExamples:\n"
      "  orasp simulate product.json\n"
      "  orasp solve product.json -o policy.json && orasp simulate product.json --policy "
      "policy.json\n"
      "  orasp simulate product.json --plan plan.json -n 100000 --seed 7 --json\n"
      "\n"
      "Exit codes: 0 simulated, 10 proved infeasible, 20 a limit or Ctrl-C stopped it (the\n"
      "runs so far are described), 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
