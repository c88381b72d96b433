#include "cli/commands/command_convert.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/fleet_plan_json.h"
#include "orasp/io/formats.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"

namespace orasp::cli {
namespace {

std::string spoken(const std::string& file) {
  return file == "-" ? "standard input" : printable(file);
}

void require_sense(const ConvertOptions& options) {
  if (options.input.empty())
    throw InputError("INPUT is missing, a file; `orasp convert --list` lists the formats");
  if (options.output.empty())
    throw InputError("-o OUTPUT is missing, the file to write (-o - prints it)");
  if (options.input == "-" && options.plan == "-")
    throw InputError("INPUT and --plan cannot both be read from standard input");
}

/// The sentence of whatever `work()` refuses, with the file in front.
template <class Work>
auto about(const std::string& file, Work&& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", spoken(file), error.what()));
  }
}

bool is_built_in(const std::string& name) {
  std::error_code ignored;
  return name != "-" && is_scenario(name) && !std::filesystem::exists(name, ignored);
}

Problem problem_of(const ConvertOptions& options, const Context& context) {
  if (options.from.empty() && is_built_in(options.input)) return load_scenario(options.input);
  const Format* stated = options.from.empty() ? nullptr : &find_format(options.from);
  const std::string text = read_text(options.input);
  return about(options.input, [&] {
    const Format& format = stated != nullptr ? *stated : format_of_input(options.input, text);
    const Converted converted = read_format(text, format.name);
    for (const std::string& note : converted.notes) context.warn(printable(note));
    return Problem(converted.problem);
  });
}

/// What the method auto finds; nothing where it finds none, and `code` says why.
std::optional<PlanFile> found_plan(const Problem& problem, const ConvertOptions& options,
                                   const Context& context, int& code) {
  Budget budget = make_budget(options.limits);
  const Result result = [&] {
    ProgressLine line(context, title(problem, options.input));
    budget.progress = [&line](const Progress& progress) { line.show(progress); };
    return solve(problem, "auto", {}, budget);
  }();
  if (!result.has_plan()) {
    code = exit_code(result);
    context.say(fmt::format("orasp: {}: {}, so nothing was written", title(problem, options.input),
                            result.status == Status::Infeasible
                                ? "no plan exists"
                                : "no plan was found (" + stop_text(result.stop) + ")"));
    return std::nullopt;
  }
  context.say(fmt::format("orasp: no --plan was given; the plan is that of the method auto ({})",
                          status_name(result.status)));
  return parse_plan(plan_text(problem, result, {}), problem.direction());
}

std::optional<PlanFile> plan_of(const Problem& problem, const ConvertOptions& options,
                                const Context& context, int& code) {
  if (problem.objective().of_fleet()) {
    throw InputError(
        fmt::format("a plan of one robot is written, and {} is an objective of several",
                    problem.objective().type));
  }
  if (options.plan.empty()) return found_plan(problem, options, context, code);
  const std::string text = read_text(options.plan);
  require_plan_for(problem, text, options.plan);
  PlanFile plan = parse_plan_text(text, options.plan, problem.direction());
  warn_of_another_problem(context, plan.problem_digest, problem);
  const Evaluation evaluation = about(options.plan, [&] { return replayed(problem, plan); });
  if (!evaluation.valid) {
    code = kNoPlan;
    const StepViolation& first = evaluation.violations.front();
    print_error(fmt::format("{}: the plan breaks a rule at step {}, so nothing was written: {}",
                            spoken(options.plan), first.step, printable(first.violation.message)));
    return std::nullopt;
  }
  return plan;
}

std::string list_text(const Context& context) {
  TextTable table;
  for (const char* column : {"format", "reads", "writes", "endings", "what it is"})
    table.add_column(column, TextTable::Align::Left);
  std::string limits;
  for (const Format& format : formats()) {
    const std::string_view writes = format.write == nullptr ? ""
                                    : format.of_plan        ? "a plan"
                                                            : "yes";
    table.add_row({std::string(format.name), format.read == nullptr ? "" : "yes",
                   std::string(writes), std::string(format.endings), std::string(format.summary)});
    limits += fmt::format("  {:<24}{}\n", format.name, format.limits);
  }
  return table.text(context.colour()) + "\nLimits:\n" + limits;
}

}  // namespace

int run(const ConvertOptions& options, const Context& context) {
  if (options.list) {
    context.print(list_text(context));
    return kSolved;
  }
  require_sense(options);
  const Format& target =
      options.to.empty() ? format_of_output(options.output) : find_format(options.to);
  const Problem problem = problem_of(options, context);
  Written written;
  if (target.of_plan || !options.plan.empty()) {
    int code = kSolved;
    const std::optional<PlanFile> plan = plan_of(problem, options, context, code);
    if (!plan) return code;
    if (!target.of_plan)
      context.warn(
          fmt::format("{} holds a problem: the plan is checked, and left out", target.name));
    written = about(options.input, [&] { return write_format(problem, target.name, *plan); });
  } else {
    written = about(options.input, [&] { return write_format(problem, target.name); });
  }
  for (const std::string& note : written.notes) context.warn(printable(note));
  if (options.output == "-") {
    context.print(written.text);
  } else {
    write_file(options.output, written.text);
  }
  return kSolved;
}

namespace {

std::string formats_help() {
  std::string text = "\nFormats:\n";
  for (const Format& format : formats()) text += help_entry(format.name, format.summary);
  return text;
}

template <class Wanted>
std::vector<std::string> names_where(Wanted&& wanted) {
  std::vector<std::string> names;
  for (const Format& format : formats())
    if (wanted(format)) names.emplace_back(format.name);
  return names;
}

}  // namespace

CommandWork convert_command(CommandLine& line) {
  const auto chosen = std::make_shared<ConvertOptions>();
  ConvertOptions& options = *chosen;
  line.about(
      "Reads a problem in one format and writes it, or a plan for it, in another. What is left\n"
      "out on the way is said on standard error, a line each.");
  line.positional("[INPUT]", options.input,
                  "a file, - for standard input, or a built-in scenario (default: none, with "
                  "--list)");
  line.group("Conversion");
  line.text("-o,--output", "FILE",
            "Write to FILE, whole or not at all; - prints it (default: none).", options.output);
  line.text("--from", "FORMAT",
            "The format of INPUT (default: by its ending and by what stands in it).", options.from);
  line.words(names_where([](const Format& format) { return format.read != nullptr; }));
  line.text("--to", "FORMAT", "The format to write (default: by the ending of FILE).", options.to);
  line.words(names_where([](const Format& format) { return format.write != nullptr; }));
  line.text(
      "--plan", "FILE",
      "The plan to write, as for `orasp evaluate`; it must be valid (default: what the method "
      "auto finds, where the format needs a plan).",
      options.plan);
  line.flag("--list", options.list,
            "List the formats with their limits instead (default: convert).");
  line.group("Limits");
  line.real("--time-limit", "SECONDS", "Search so long for a plan (default: none).",
            options.limits.time_limit, Sign::Positive);
  line.group("Output");
  line.quiet_flag("No notes and no progress on standard error (default: both).");
  line.footer(
      formats_help() +
      "\nExamples:\n"
      "  orasp convert product.graphml -o product.json\n"
      "  orasp convert MERTENS.IN2 -o mertens.json\n"
      "  orasp convert hubble --to behavior-tree -o hubble.xml\n"
      "  orasp convert product.json --to task-graph --plan plan.json -o tasks.json\n"
      "\n"
      "Exit codes: 0 written, 10 the plan breaks a rule or none exists (proved), 20 a limit\n"
      "stopped the search for a plan, 30 wrong input. Unless it is 0, nothing is written.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
