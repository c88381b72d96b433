#include "cli/commands/command_solve.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/on_ranks.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/plan_summary.h"
#include "cli/output/progress.h"
#include "cli/output/step_table.h"
#include "cli/output/text.h"
#include "orasp/certificate/certificate.h"
#include "orasp/cluster/cluster_a_star.h"
#include "orasp/cluster/cluster_beam.h"
#include "orasp/cluster/cluster_value_iteration.h"
#include "orasp/explain/alternatives.h"
#include "orasp/fleet/fleet_mip.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/certificate_json.h"
#include "orasp/io/graph_policy_file.h"
#include "orasp/io/mip_file.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/state_policy_json.h"
#include "orasp/mip/mip.h"

namespace orasp::cli {
namespace {

void refuse_idle_options(const SolveOptions& options) {
  if (options.write_model.empty()) return;
  if (options.method != "mip")
    throw InputError(
        fmt::format("--write-model belongs to the method mip, not to {}", options.method));
  require_model_file(options.write_model);
  const char* const idle = !options.output.empty()        ? "--output"
                           : !options.certificate.empty() ? "--certificate"
                           : options.count                ? "--count"
                           : options.alternatives > 0     ? "--alternatives"
                                                          : nullptr;
  if (idle != nullptr)
    throw InputError(fmt::format("--write-model solves nothing, so {} has no plan", idle));
}

/// What the file holds: a policy for one problem, or one for many products (`orasp train
/// --problems`). @throws InputError where it is damaged or for other problems.
void read_policy_into(Options& options, const std::string& file, const Problem& problem) {
  const std::string bytes = read_text(file);
  if (!is_graph_policy(bytes)) {
    options.policy = std::make_shared<const Policy>(read_policy(file, problem).trained.policy);
    return;
  }
  GraphPolicyFile read = read_graph_policy(file);
  require_kind(problem, read.kind, file);
  options.graph_policy = std::make_shared<const GraphPolicy>(std::move(read.policy));
}

Settings settings_of(const SolveOptions& options) {
  Settings settings;
  settings["method"] = json_string(options.method);
  note_changes(options.changes, settings);
  note_limits(options.limits, settings);
  const Options chosen = options_from(options.method, options.of_method);
  for (const OptionSpec& row : find_planner(options.method).options()) {
    const auto given = options.of_method.find(std::string(row.name));
    if (given == options.of_method.end()) continue;
    settings[given->first] = is_bare(row) ? value_of(row, chosen) : json_string(given->second);
  }
  if (options.count) settings["count"] = "true";
  if (options.steps) settings["steps"] = fmt::to_string(*options.steps);
  if (options.alternatives > 0) settings["alternatives"] = fmt::to_string(options.alternatives);
  return settings;
}

bool wants_other_plans(const SolveOptions& options) {
  return options.count || options.alternatives > 0;
}

/// Before the method runs: where H does not fit, nothing is done.
void require_graph_for_other_plans(const TransitionSystem& system, const SolveOptions& options,
                                   const Budget& budget) {
  if (const auto reason = graph_obstacle(system, budget))
    throw InputError((options.count ? "--count " : "--alternatives ") + *reason);
}

std::string alternatives_text(const Problem& problem, const Alternatives& alternatives,
                              const SolveOptions& options, const Context& context) {
  std::string text;
  if (alternatives.optimal_sequences)
    text += '\n' + counted(*alternatives.optimal_sequences, "optimal sequence") +
            (alternatives.optimal_up_to_symmetry
                 ? ", " + grouped(*alternatives.optimal_up_to_symmetry) + " up to symmetry"
                 : "") +
            '\n';
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
    if (plans[i].steps.empty()) {
      for (const ConnectionIndex c : plans[i].sequence) ids.push_back(problem.connection_id(c));
    }
    for (const PlanStep& step : plans[i].steps) {
      std::string taken;
      for (const ConnectionIndex c : step.connections)
        taken += (taken.empty() ? "" : " + ") + problem.connection_id(c);
      if (step.direction) taken += " " + problem.direction_name(*step.direction);
      ids.push_back(std::move(taken));
    }
    text += fmt::format("{:>4}  reward {}\n", i + 1, reward_texts[i]);
    text += wrapped_list(ids, 6, context.width());
  }
  return text;
}

std::string summary(const Task& task, const Result& result, const Alternatives& alternatives,
                    const SolveOptions& options, const Context& context) {
  std::string text = plan_summary(task, options.problem, result, context);
  text += alternatives_text(task.problem, alternatives, options, context);
  if (!result.notes.empty()) text += '\n';
  for (const std::string& note : result.notes) text += printable(note) + '\n';
  return text;
}

/// The model in a file instead of a plan.
int write_program(const MipModel& model, const SolveOptions& options, const Context& context,
                  const std::string& objective) {
  write_model(model, options.write_model);
  context.print(
      options.json
          ? fmt::format("{{\"model\": {}, \"columns\": {}, \"whole_columns\": {}, \"rows\": {}, "
                        "\"terms\": {}}}\n",
                        json_string(options.write_model), model.num_columns(), model.num_integers(),
                        model.num_rows(), model.num_terms())
          : fmt::format("{}: {} ({} whole), {}, {}; its objective, to be minimised, is {}\n",
                        printable(options.write_model), counted(model.num_columns(), "column"),
                        grouped(model.num_integers()), counted(model.num_rows(), "row"),
                        counted(model.num_terms(), "term"), objective));
  return kSolved;
}

int write_program(const Task& task, const SolveOptions& options, const Context& context) {
  if (!task.problem.objective().of_fleet())
    return write_program(mip_model(TransitionSystem(task.problem)), options, context,
                         "minus the reward");
  const FleetProblem fleet(task.problem);
  const bool travels = fleet.objective() == FleetObjective::Travel;
  if (travels && !task.steps)
    throw InputError(
        "--write-model: the integer program of the least travel needs --steps N, the most steps");
  return write_program(fleet_mip_model(fleet, task.steps.value_or(fleet_mip_horizon(fleet))),
                       options, context, travels ? "the travel in m^2" : "the number of steps");
}

/// Refuses what lists or counts orders where the plan is none, or not the whole of it.
void require_sense_of_other_plans(const Problem& problem, const SolveOptions& options) {
  if (!wants_other_plans(options)) return;
  const char* const option = options.count ? "--count" : "--alternatives";
  if (problem.objective().of_fleet())
    throw InputError(
        fmt::format("{} lists plans of one robot, and {} is an objective of several; leave it out",
                    option, problem.objective().type));
  if (problem.uncertain())
    throw InputError(fmt::format(
        "{} lists plans for attempts that always succeed, and an attempt at connection {} may fail "
        "(its success is below 1); leave it out",
        option, in_quotes(problem.connection_id(*problem.first_uncertain()))));
}

/// Why no plan is better, or why there is none.
Certified why_proved(const Problem& problem, const Result& result, const Budget& budget) {
  const auto stop = [&budget] { return budget.expired() != Stop::None; };
  if (result.status == Status::Infeasible) return certify(problem, std::nullopt, stop);
  if (!result.has_plan()) return {{}, "there is neither a plan nor a proof that there is none"};
  return certify(problem, result.sequence, stop);
}

/// Refuses what several processes do not share.
void require_sense_of_ranks(const SolveOptions& options, const Options& chosen) {
  const bool of_table = options.method == "value-iteration";
  const bool of_a_star = options.method == "a-star";
  if (!of_table && !of_a_star && options.method != "beam")
    throw InputError(fmt::format(
        "{} does its work in one process: start it without mpirun, or let several share it with "
        "--method value-iteration, beam or a-star",
        options.method));
  const char* const lone = wants_other_plans(options)     ? "--count or --alternatives"
                           : !options.write_model.empty() ? "--write-model"
                           : !options.certificate.empty() ? "--certificate"
                           : options.steps                ? "--steps"
                           : (of_table || of_a_star) && options.limits.threads ? "--threads"
                           : options.of_method.contains("policy")              ? "--policy"
                           : of_table && !options.of_method.empty() ? "an option of the method"
                           : of_a_star && chosen.symmetry == SymmetryUse::On ? "--symmetry on"
                                                                             : nullptr;
  if (lone != nullptr)
    throw InputError(
        fmt::format("{}: several processes do not share that with {}; start it without mpirun",
                    lone, options.method));
}

/// The answer of several processes to one problem of one robot, on each.
Result solved_on_ranks(const TransitionSystem& system, const SolveOptions& options,
                       const Options& chosen, Budget& budget, Ranks& ranks) {
  if (options.method == "value-iteration")
    return cluster_value_iteration(system, {}, budget, ranks);
  if (options.method == "a-star")
    return cluster_a_star(system, {.bound = chosen.bound}, budget, ranks);
  if (!options.limits.threads)
    budget.threads = std::max(1U, budget.threads / static_cast<unsigned>(ranks.on_this_machine()));
  return cluster_beam(system, {.bound = chosen.bound, .symmetry = chosen.symmetry}, budget, ranks);
}

/// The answer of several processes, printed and written by rank 0.
int solve_on_ranks(const SolveOptions& options, const Context& context) {
  const Options chosen = options_from(options.method, options.of_method, "--");
  require_sense_of_ranks(options, chosen);
  Budget budget = make_budget(options.limits);
  return on_ranks([&](Ranks& ranks) {
    share_memory(ranks.on_this_machine(), options.limits.memory_limit.has_value(), budget);
    // Rank 0 alone reads; the others get the problem from it, as a file would hold it.
    std::string digest;
    const std::string text = made_at_rank_0(ranks, [&] {
      const Problem problem = load_problem(options.problem, options.changes, context);
      digest = problem_digest(problem);
      return problem_text(problem);
    });
    const Problem problem = parse_problem(text);
    if (ranks.rank() == 0 && digest != problem_digest(problem))
      throw std::logic_error("the problem changed on its way to the other ranks");
    if (problem.objective().of_fleet())
      throw InputError(options.method + " plans for one robot, and " + problem.objective().type +
                       " is an objective of several");
    const Task task(problem);
    Result result;
    {
      ProgressLine progress(context, title(problem, options.problem) + ", " + options.method);
      if (ranks.rank() == 0) progress.attach_to(budget);
      const TransitionSystem system(problem);
      result = solved_on_ranks(system, options, chosen, budget, ranks);
      result.seed = options.seed;
    }
    if (ranks.rank() != 0) return static_cast<int>(kSolved);
    require_honest(task, result);
    const Alternatives none;
    const std::string plan = options.json || !options.output.empty()
                                 ? plan_text(task, result, settings_of(options), &none)
                                 : std::string();
    if (!options.output.empty()) {
      if (result.has_plan()) {
        write_file(options.output, plan);
      } else {
        context.warn("there is no plan, so " + options.output + " is not written");
      }
    }
    context.print(options.json ? plan : summary(task, result, none, options, context));
    return exit_code(result);
  });
}

}  // namespace

int run(const SolveOptions& options, const Context& context) {
  if (among_ranks()) return solve_on_ranks(options, context);
  const Planner& planner = find_planner(options.method);
  refuse_idle_options(options);
  Options chosen = options_from(options.method, options.of_method, "--");
  chosen.seed = options.seed;
  const Problem problem = load_problem(options.problem, options.changes, context);
  Task task(problem);
  task.steps = options.steps;
  require_sense_of_other_plans(problem, options);
  if (!options.write_model.empty()) return write_program(task, options, context);
  if (!options.certificate.empty()) {
    if (const std::string reason = without_certificates(problem); !reason.empty())
      throw InputError("--certificate: " + reason);
  }
  if (const auto file = options.of_method.find("policy"); file != options.of_method.end())
    read_policy_into(chosen, file->second, problem);

  Result result;
  Alternatives alternatives;
  Certified certified;
  {
    ProgressLine progress(context, title(problem, options.problem) + ", " + options.method);
    Budget budget = make_budget(options.limits);
    progress.attach_to(budget);
    std::optional<TransitionSystem> system;
    if (wants_other_plans(options)) {
      system.emplace(problem);
      require_graph_for_other_plans(*system, options, budget);
    }
    result = solve(task, planner.name, chosen, budget);
    if (system)
      alternatives = find_alternatives(*system, options.count, options.alternatives, budget);
    if (!options.certificate.empty()) certified = why_proved(problem, result, budget);
  }
  if (alternatives.stop != Stop::None) {
    result.notes.push_back(fmt::format(
        "{} was {}",
        alternatives.plans ? "the list of the best plans" : "building H for other plans",
        stop_text(alternatives.stop)));
  }
  // Where attempts may fail, an order is not all there is to do: the file is the policy.
  const bool writes_policy = result.expectation.has_value();
  const std::string plan = options.json || (!options.output.empty() && !writes_policy)
                               ? plan_text(task, result, settings_of(options), &alternatives)
                               : std::string();
  if (!options.output.empty()) {
    // What stands in the file may be the plan of yesterday: a run without a plan leaves it alone.
    if (result.has_plan()) {
      write_file(options.output,
                 writes_policy ? state_policy_text(TransitionSystem(problem), result) : plan);
    } else {
      context.warn("there is no plan, so " + options.output + " is not written");
    }
  }
  if (certified.certificate) {
    write_file(options.certificate, certificate_text(problem, *certified.certificate));
  } else if (!options.certificate.empty()) {
    // What stands in the file may be about the plan of yesterday: it is left alone, as that is.
    context.warn(options.certificate + " is not written: " + certified.reason);
  }
  context.print(options.json ? plan : summary(task, result, alternatives, options, context));
  const int code = exit_code(result);
  const bool lacks_certificate = !options.certificate.empty() && !certified.certificate;
  return code == kSolved && (alternatives.stop != Stop::None || lacks_certificate) ? kStopped
                                                                                   : code;
}

CommandWork solve_command(CommandLine& line) {
  const auto chosen = std::make_shared<SolveOptions>();
  SolveOptions& options = *chosen;
  line.about("Finds a plan: the order in which to take a product apart, or to put it together.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Method");
  line.text("--method", "METHOD", "One of those below (default: auto).", options.method);
  line.words(method_names());
  add_seed_option(line, options.seed, "the methods that draw random numbers");
  add_steps_option(line, options.steps);
  add_method_options(line, options.of_method);
  line.group("Of mip");
  line.text("--write-model", "FILE",
            "Write the integer program to FILE.lp or FILE.mps for another solver, and solve "
            "nothing (default: solve it).",
            options.write_model);
  line.group("Proof");
  line.text("--certificate", "FILE",
            "Write why no plan is better, or why there is none, in the format "
            "orasp-certificate/1 (default: do not).",
            options.certificate);
  line.group("Other plans");
  line.flag("--count", options.count,
            "Count the optimal sequences; builds H whatever the method (default: do not).");
  line.whole("--alternatives", "K",
             "List the K best plans; builds H whatever the method (default: the one plan).",
             options.alternatives, 1, 1'000'000);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output, "the plan (format orasp-plan/1)");
  line.footer(methods_help() +
              "\nExamples:\n"
              "  orasp solve hubble\n"
              "  orasp solve product.json --method orasp-search --time-limit 60 -o plan.json\n"
              "  orasp solve jwst --objective time --direction assembly --time-limit 10\n"
              "  orasp solve lattice --count --alternatives 3\n"
              "  orasp solve fleet-lattice --objective fleet_travel --steps 5\n"
              "  orasp scenarios grid:4x4 | orasp solve - --json\n"
              "\n"
              "Exit codes: 0 solved, 10 proved infeasible, 20 a limit or Ctrl-C stopped it\n"
              "(the best plan so far is printed) or there is no certificate, 30 wrong input,\n"
              "40 internal error.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
