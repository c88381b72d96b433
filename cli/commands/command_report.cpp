#include "cli/commands/command_report.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/plan_summary.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/drawing/figures.h"
#include "orasp/explain/explain_problem.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/fleet_plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/validate.h"
#include "orasp/planners/random_rewards.h"
#include "orasp/planners/reward_statistics.h"
#include "orasp/report/fleet_report.h"
#include "orasp/report/report.h"

namespace orasp::cli {
namespace {

constexpr double kSearchSeconds = 10;

void require_sense(const ReportOptions& options) {
  if (options.output.empty() && options.svg.empty()) {
    throw InputError(
        "-o FILE is missing, the page to write (-o - prints it), or --svg DIR, the figures alone");
  }
  if (!options.sample.empty() && options.sample_count)
    throw InputError(
        "--sample and --sample-count exclude each other: one reads a sample, the other draws one");
  const auto stdin_uses = std::ranges::count(options.plans, "-") +
                          (options.problem == "-" ? 1 : 0) + (options.log == "-" ? 1 : 0) +
                          (options.sample == "-" ? 1 : 0);
  if (stdin_uses > 1) throw InputError("standard input (-) can be read for one thing only");
}

std::string spoken(const std::string& file) {
  return file == "-" ? "standard input" : file;
}

/// What to call a file in the page: its name without its folders, which are nobody's business.
std::string shown_name(const std::string& file) {
  return file == "-" ? "standard input" : std::filesystem::path(file).filename().string();
}

/// Reads a file with `parse`; what is wrong with it is said with its name.
template <class Parse>
auto parsed(const std::string& file, Parse&& parse) {
  const std::string text = read_text(file);
  try {
    return parse(text);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", spoken(file), error.what()));
  }
}

/// A plan file's text, read once.
struct PlanText {
  std::string file;
  std::string text;
  std::string label;  ///< its name; as typed where two have the same
};

std::vector<PlanText> read_plans(const std::vector<std::string>& files) {
  std::vector<PlanText> read;
  for (const std::string& file : files) {
    const bool unique = std::ranges::count_if(files, [&](const std::string& other) {
                          return shown_name(other) == shown_name(file);
                        }) == 1;
    read.push_back({file, read_text(file), unique ? shown_name(file) : file});
  }
  return read;
}

/// Warns of a plan that was made for another problem, and says so in the page.
void compare_digests(const std::string& digest, const std::string& file, const Problem& problem,
                     const Context& context, std::vector<std::string>& notes) {
  if (digest.empty() || digest == problem_digest(problem)) return;
  context.warn(fmt::format("{} was made for another problem: its problem_digest differs",
                           printable(spoken(file))));
  notes.emplace_back("It was made for another problem: its problem_digest differs.");
}

ReportPlan plan_from_file(const PlanText& file, const Problem& problem, const Context& context) {
  PlanFile read = parse_plan_text(file.text, file.file, problem.direction());
  ReportPlan plan;
  plan.label = file.label;
  plan.origin = fmt::format("Read from {}.", file.label);
  if (problem.spec().action == StepKind::Part) {
    plan.part_steps = plan_steps(problem, read);
  } else {
    plan.sequence = std::move(read.sequence);
    plan.directions = std::move(read.directions);
  }
  compare_digests(read.problem_digest, file.file, problem, context, plan.notes);
  return plan;
}

ReportPlan plan_of_result(const Problem& problem, const Result& result) {
  ReportPlan plan;
  plan.label = result.method;
  plan.origin = fmt::format("Found by {}.", result.method);
  if (problem.spec().action == StepKind::Part) {
    plan.part_steps = result.steps;
    return plan;
  }
  for (const ConnectionIndex c : result.sequence) plan.sequence.push_back(problem.connection_id(c));
  for (const PlanStep& step : result.steps) {
    plan.directions.push_back(step.direction ? problem.direction_name(*step.direction)
                                             : std::string());
  }
  if (result.expectation) {
    plan.expected = result.reward;
    plan.notes.push_back(
        fmt::format("The steps are the most likely sequence, where no failure changes the state; "
                    "{} attempts are expected.",
                    number_text(result.expectation->attempts)));
  }
  return plan;
}

ReportSample described(std::string origin, std::vector<double> rewards) {
  const RewardFigures figures = figures_of(rewards);
  return {.origin = std::move(origin),
          .rewards = std::move(rewards),
          .mean = figures.mean,
          .deviation = figures.deviation,
          .least = figures.least,
          .quartiles = {figures.percentiles[1], figures.percentiles[2], figures.percentiles[3]},
          .greatest = figures.greatest};
}

std::optional<ReportSample> sample_of(const TransitionSystem& system, const ReportOptions& options,
                                      const Budget& budget, const Context& context) {
  if (!options.sample.empty()) {
    return described(
        fmt::format("Rewards read from {}.", shown_name(options.sample)),
        parsed(options.sample, [](const std::string& text) { return parse_sample(text); }));
  }
  if (!options.sample_count || system.infeasibility()) return std::nullopt;
  RandomRewards drawn = draw_rewards(system, *options.sample_count, options.seed, false, budget);
  if (drawn.rewards.size() < *options.sample_count) {
    context.warn(fmt::format(
        "{} of {} were drawn: {}", grouped(drawn.rewards.size()),
        counted(*options.sample_count, "random sequence"),
        drawn.last.stop != Stop::None ? stop_text(drawn.last.stop) : "there is no further one"));
  }
  if (drawn.rewards.empty()) return std::nullopt;
  std::string origin =
      fmt::format("Rewards of {}, seed {}.", counted(drawn.rewards.size(), "random legal sequence"),
                  options.seed);
  return described(std::move(origin), std::move(drawn.rewards));
}

/// Adds the shapes of the parts, where the problem names a file of them. What is wrong with it is a
/// warning, and is said in the page.
void add_shapes(const Problem& problem, const std::string& problem_file, const Context& context,
                Report& report) {
  const auto& geometry = problem.spec().geometry;
  if (!geometry) return;
  const auto do_without = [&](const std::string& fault, const std::string& shown) {
    context.warn(printable(fmt::format("geometry: {}; the report does without", fault)));
    report.shapes_fault = fmt::format("The true parts are not shown: {}.", printable(shown));
  };
  const std::string name = in_quotes(shown_name(geometry->file));
  std::string bytes;
  try {
    const std::filesystem::path problem_path = problem_file == "-" ? "" : problem_file;
    const std::filesystem::path path = problem_path.parent_path() / geometry->file;
    // Pipes and devices may never end; what else is no file is said when it is read.
    std::error_code error;
    if (std::filesystem::is_other(path, error))
      return do_without(in_quotes(path.string()) + " is no file", name + " is no file");
    bytes = read_text(path == "-" ? "./-" : path.string());
  } catch (const InputError& error) {
    return do_without(error.what(), name + " cannot be read");
  }
  try {
    report.shapes = part_shapes(problem, bytes);
  } catch (const InputError& error) {
    do_without(name + ": " + error.what(), name + ": " + error.what());
  }
}

/// The figures of the problem, with the first plan that breaks no rule.
std::vector<FigureFile> drawn(const Problem& problem, const Report& report,
                              const std::string& folder, const Budget& budget) {
  FigureRequest request;
  std::vector<ConnectionIndex> sequence;
  for (const ReportPlan& plan : report.plans) {
    const Evaluation evaluation =
        evaluate(problem, std::span<const std::string>(plan.sequence), plan.directions);
    if (!evaluation.valid) continue;
    for (const std::string& id : plan.sequence) sequence.push_back(problem.find_connection(id, ""));
    request.plan = sequence;
    request.marks.push_back({plan.label, evaluation.reward, Mark::Kind::Plan});
    break;
  }
  if (report.best.status == Status::Optimal && !problem.uncertain())
    request.marks.push_back({"optimum, proved", report.best.reward, Mark::Kind::Best});
  if (report.sample) request.sample = report.sample->rewards;
  return write_figures(problem, request, folder, budget);
}

std::string size_text(std::size_t bytes) {
  return fmt::format("{} kB", grouped((bytes + 999) / 1000));
}

void write_page(const std::string& page, std::size_t plans, const Problem& problem,
                const ReportOptions& options, const Context& context) {
  if (options.output == "-") {
    context.print(page);
    return;
  }
  write_file(options.output, page);
  context.print(fmt::format("{}: {}, written to {} ({})\n", title(problem, options.problem),
                            counted(plans, "plan"), printable(options.output),
                            size_text(page.size())));
}

LimitOptions search_limits(const ReportOptions& options) {
  LimitOptions limits = options.limits;
  if (!limits.time_limit) limits.time_limit = kSearchSeconds;
  return limits;
}

/// A report on several robots.
int report_fleet(const Problem& problem, const std::vector<PlanText>& files,
                 const ReportOptions& options, const Context& context) {
  if (!options.sample.empty() || options.sample_count || !options.log.empty())
    throw InputError(
        "--log, --sample and --sample-count belong to plans of one robot, not to those of a fleet");
  if (!options.svg.empty())
    throw InputError(
        "--svg: figures are drawn of plans for one robot, and this is a fleet's; -o writes its "
        "page");
  const FleetProblem fleet(problem);
  FleetReport report;
  report.title = options.title.empty() ? title(problem, options.problem) : options.title;
  std::optional<std::size_t> steps;
  for (const PlanText& file : files) {
    try {
      FleetPlanFile read = parse_fleet_plan(file.text, fleet);
      FleetReportPlan plan{.label = file.label,
                           .origin = fmt::format("Read from {}.", file.label),
                           .plan = std::move(read.plan),
                           .notes = {}};
      compare_digests(read.problem_digest, file.file, problem, context, plan.notes);
      steps = std::max(steps.value_or(0), plan.plan.makespan());
      report.plans.push_back(std::move(plan));
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", spoken(file.file), error.what()));
    }
  }
  // Travel is compared among plans that may take as many steps.
  if (fleet.objective() == FleetObjective::Makespan) steps.reset();
  {
    ProgressLine progress(context, title(problem, options.problem) + ", report");
    Budget budget = make_budget(search_limits(options));
    progress.attach_to(budget);
    Task task(problem);
    task.steps = steps;
    report.best = solve(task, "auto", {}, budget);
  }
  report.effort = statistics_text(report.best);
  const bool solved_here = files.empty();
  if (solved_here && report.best.has_plan())
    report.plans.push_back({.label = report.best.method,
                            .origin = fmt::format("Found by {}.", report.best.method),
                            .plan = report.best.fleet_plan,
                            .notes = {}});
  write_page(report_html(fleet, report), report.plans.size(), problem, options, context);
  if (solved_here) return exit_code(report.best);
  const bool valid = std::ranges::all_of(
      report.plans, [&](const FleetReportPlan& plan) { return evaluate(fleet, plan.plan).valid; });
  return valid ? kSolved : kNoPlan;
}

}  // namespace

int run(const ReportOptions& options, const Context& context) {
  require_sense(options);
  const Problem problem = load_problem(options.problem, options.changes, context);
  const std::vector<PlanText> files = read_plans(options.plans);
  for (const PlanText& file : files) require_plan_for(problem, file.text, file.file);
  if (problem.objective().of_fleet()) return report_fleet(problem, files, options, context);
  const bool by_part = problem.spec().action == StepKind::Part;
  if (by_part && !options.svg.empty())
    throw InputError(
        "--svg: figures are drawn of steps that take one connection each; with \"action\": "
        "\"part\" "
        "a step takes several; -o writes the page");
  const TransitionSystem system(problem);
  const LimitOptions limits = search_limits(options);

  Report report;
  report.title = options.title.empty() ? title(problem, options.problem) : options.title;
  for (const PlanText& file : files) report.plans.push_back(plan_from_file(file, problem, context));
  if (!options.log.empty()) {
    report.learning =
        parsed(options.log, [](const std::string& text) { return parse_training_log(text); });
  }
  {
    ProgressLine progress(context, title(problem, options.problem) + ", report");
    Budget budget = make_budget(limits);
    progress.attach_to(budget);
    report.best = solve(problem, "auto", {}, budget);
    Budget sampling = make_budget(limits);
    progress.attach_to(sampling);
    report.sample = sample_of(system, options, sampling, context);
    if (report.best.status == Status::Infeasible) {
      for (const ConflictItem& item : explain_problem(problem, make_budget(limits)).conflict)
        report.conflict.push_back(item.where + ": " + item.message);
    }
  }
  report.effort = statistics_text(report.best);
  if (!options.output.empty()) add_shapes(problem, options.problem, context, report);
  const bool solved_here = report.plans.empty();
  if (solved_here && report.best.has_plan())
    report.plans.push_back(plan_of_result(problem, report.best));

  const std::string page = options.output.empty() ? std::string() : report_html(system, report);
  std::vector<FigureFile> figures;
  if (!options.svg.empty()) figures = drawn(problem, report, options.svg, make_budget(limits));
  if (!options.output.empty()) write_page(page, report.plans.size(), problem, options, context);
  if (options.output != "-" && !figures.empty()) {
    context.print(fmt::format("{}: {}, written into {}\n", title(problem, options.problem),
                              counted(figures.size(), "figure"), printable(options.svg)));
  }
  if (solved_here) return exit_code(report.best);
  const bool valid = std::ranges::all_of(
      report.plans, [&](const ReportPlan& plan) { return replayed(system, plan).valid; });
  return valid ? kSolved : kNoPlan;
}

CommandWork report_command(CommandLine& line) {
  const auto chosen = std::make_shared<ReportOptions>();
  ReportOptions& options = *chosen;
  line.about(
      "Writes one self-contained page (HTML) about a problem and its plans: the assembly\n"
      "as a drawing, or its true parts where the problem names their shapes, each plan step\n"
      "by step with what allows it, an instruction book, charts, what is proved.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.positionals("[PLAN]", options.plans,
                   "plans to show, several side by side: files as for `orasp evaluate`, - for "
                   "standard input (default: what auto finds)");
  line.group("Page");
  line.text(
      "-o,--output", "FILE",
      "Write the page to FILE, whole or not at all; - prints it (default: none, with --svg alone).",
      options.output);
  line.text("--svg", "DIR",
            "Draw the figures of the problem and of the first plan as SVG files into this folder, "
            "which is made if it is missing (default: none).",
            options.svg);
  line.text("--title", "TEXT", "Heading of the page (default: the problem's name).", options.title);
  line.text("--log", "FILE", "Show the learning curve of this `orasp train --log` (default: none).",
            options.log);
  line.text("--sample", "FILE",
            "Show how the rewards of this `orasp sample --json` are distributed (default: none).",
            options.sample);
  line.value("--sample-count", "N",
             "Draw N random sequences and show how their rewards are distributed (default: none).",
             [&options](const std::string& given) {
               options.sample_count = whole_number("--sample-count", given, 1, 10'000'000);
             });
  add_seed_option(line, options.seed, "the sample");
  add_problem_options(line, options.changes);
  line.group("Limits");
  line.real("--time-limit", "SECONDS",
            "Search so long for the best plan and a bound (default: 10).",
            options.limits.time_limit, Sign::Positive);
  line.whole("--memory-limit", "MIB",
             "Stop the search where its tables hold more than this (default: three quarters of the "
             "machine's memory).",
             options.limits.memory_limit, 1, std::uint64_t{1} << 40);
  line.whole("--threads", "N", "Threads of the search (default: all of the machine's).",
             options.limits.threads, 1, 4096);
  line.group("Output");
  line.quiet_flag("No progress and no warnings on standard error (default: both).");
  line.footer(
      "\nExamples:\n"
      "  orasp report hubble -o hubble.html\n"
      "  orasp report product.json first.json second.json -o both.html\n"
      "  orasp report lattice --sample-count 1000 -o lattice.html\n"
      "\n"
      "Exit codes: 0 written, 10 written, but a plan breaks rules or none exists (proved),\n"
      "20 written, but a limit stopped the search for a plan, 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
