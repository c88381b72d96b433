#include "cli/commands/command_explain.h"

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/conflict.h"
#include "cli/output/json_output.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/explain/explain_connection.h"
#include "orasp/explain/explain_problem.h"
#include "orasp/io/explanation_json.h"
#include "orasp/model/validate.h"

namespace orasp::cli {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kRefusalsShown = 20;

std::vector<std::string> connection_ids(const Problem& problem,
                                        const std::vector<ConnectionIndex>& connections) {
  std::vector<std::string> ids;
  for (const ConnectionIndex c : connections) ids.push_back(problem.connection_id(c));
  return ids;
}

/// At most `width` columns of `text`, control characters made harmless.
std::string cut(std::string_view text, std::size_t width) {
  constexpr std::string_view kMore = " ...";
  std::string line = printable(text);
  if (display_width(line) <= width || width <= kMore.size()) return line;
  std::size_t columns = 0;
  std::size_t end = 0;
  while (end < line.size()) {
    const bool starts = (static_cast<unsigned char>(line[end]) & 0xc0U) != 0x80U;
    if (starts && columns++ == width - kMore.size()) break;
    ++end;
  }
  return line.substr(0, end).append(kMore);
}

// -------------------------------------------------------------------------------------------------
// The whole problem

/// What cannot go first, and one reason each: of the first kRefusalsShown of them.
struct Refusals {
  std::size_t count = 0;
  std::vector<std::pair<std::string, Violation>> shown;

  /// `why` is asked only for what is shown.
  template <class Why>
  void add(const std::string& id, Why&& why) {
    if (count++ < kRefusalsShown) shown.emplace_back(printable(id), why());
  }
};

std::string text_of(const Refusals& refusals, const Context& context) {
  std::size_t width = 0;
  for (const auto& [id, violation] : refusals.shown) width = std::max(width, display_width(id));
  std::string text;
  for (const auto& [id, violation] : refusals.shown) {
    const std::string head = "  " + id + std::string(width - display_width(id) + 2, ' ') +
                             std::string(constraint_name(violation.constraint)) + ": ";
    const std::size_t room =
        context.width() > display_width(head) + 20 ? context.width() - display_width(head) : 20;
    text += head + cut(violation.message, room) + '\n';
  }
  if (refusals.count > kRefusalsShown)
    text += fmt::format("  ... and {} more\n", grouped(refusals.count - kRefusalsShown));
  return text;
}

/// Which connections cannot be the first, and one reason each.
std::string refusals_text(const Problem& problem, const Context& context) {
  const TransitionSystem system(problem);
  Expander expander(system);
  const ConnectionSet start = system.start();
  std::vector<bool> legal(problem.num_connections(), false);
  for (const Action& action : expander.legal_actions(start.view())) legal[action.connection] = true;
  Refusals refusals;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    if (legal[c]) continue;
    refusals.add(problem.connection_id(c),
                 [&] { return expander.violations(start.view(), c).front(); });
  }
  if (problem.num_connections() == 0) return "there is no connection, so the plan is empty\n";
  if (refusals.count == 0) return "every connection may go first\n";
  return fmt::format("{} may go first, {} may not:\n",
                     counted(problem.num_connections() - refusals.count, "connection"),
                     grouped(refusals.count)) +
         text_of(refusals, context);
}

/// Why a part cannot come off first by itself, without the step that would take it off.
Violation of_part(const Problem& problem, PartIndex part, const PlanStep& step,
                  Violation violation) {
  if (violation.constraint == Constraint::Blocking) {
    std::vector<std::string> in_the_way;
    for (const Blocker& blocker : problem.blockers()[part])
      in_the_way.push_back(in_quotes(problem.part_id(blocker.by)));
    violation.message =
        fmt::format("no direction is free; in the way: {}", fmt::join(in_the_way, ", "));
    return violation;
  }
  const std::string id = in_quotes(problem.connection_id(step.connections.front()));
  const std::string cut = "step 1, which removes " + id + ", ";
  const std::string does = "step 1 removes " + id + " before ";
  if (violation.message.starts_with(cut)) {
    violation.message = "this " + violation.message.substr(cut.size());
  } else if (violation.message.starts_with(does)) {
    violation.message = id + " must go after " + violation.message.substr(does.size());
  }
  return violation;
}

/// Where steps take parts off: which parts cannot come off first, each by itself, and one reason
/// each. A part of the base and one that nothing holds are not asked about.
std::string parts_refused_text(const Problem& problem, const Context& context) {
  const TransitionSystem system(problem);
  const SetView start = system.start_state();
  std::vector<PlanStep> alone(problem.num_parts());
  for_each_connection(system.open(start), [&](ConnectionIndex c) {
    const auto [first, second] = problem.ends(c);
    if (first == second) return;
    alone[first].connections.push_back(c);
    alone[second].connections.push_back(c);
  });
  Refusals refusals;
  std::size_t asked = 0;
  for (PartIndex p = 0; p < problem.num_parts(); ++p) {
    if (problem.in_base(p) || alone[p].connections.empty()) continue;
    ++asked;
    const Evaluation one = evaluate(system, {&alone[p], 1});
    const auto broken = std::ranges::find(one.violations, std::size_t{1}, &StepViolation::step);
    if (broken == one.violations.end()) continue;
    refusals.add(problem.part_id(p),
                 [&] { return of_part(problem, p, alone[p], broken->violation); });
  }
  if (asked == 0) return "";
  if (refusals.count == 0) return "\nevery part may come off first, each by itself\n";
  return fmt::format("\n{} may come off first, each by itself, {} may not:\n",
                     counted(asked - refusals.count, "part"), grouped(refusals.count)) +
         text_of(refusals, context);
}

int explain_all(const Problem& problem, const ExplainOptions& options, const Context& context) {
  ProblemExplanation found;
  {
    ProgressLine progress(context, title(problem, options.problem) + ", explain");
    Budget budget = make_budget(options.limits);
    progress.attach_to(budget);
    found = explain_problem(problem, budget);
  }
  ordered_json document = {{"status", status_name(found.status)},
                           {"conflict", conflict_json(found.conflict)}};
  if (found.status == Status::Infeasible) document["minimal"] = found.minimal;
  document["tests"] = found.tests;
  if (found.stop != Stop::None) document["stopped"] = stop_name(found.stop);
  print_result(context, options.output, options.json, document, [&] {
    const std::string head = title(problem, options.problem) + ": ";
    if (found.status == Status::Infeasible) return head + conflict_text(found);
    if (found.status == Status::Unknown)
      return head + "not decided whether a plan exists: " + stop_text(found.stop) + '\n';
    if (problem.spec().action == StepKind::Part) {
      const bool takes_off = problem.direction() == Direction::Disassembly;
      return head + "a plan exists\n" + (takes_off ? parts_refused_text(problem, context) : "");
    }
    return head + "a plan exists\n\n" + refusals_text(problem, context);
  });
  if (found.status == Status::Infeasible) return kNoPlan;
  return found.status == Status::Unknown ? kStopped : kSolved;
}

// -------------------------------------------------------------------------------------------------
// One connection

/// The state before the step at hand: the plan's steps before it are done.
ConnectionSet state_in_plan(const Problem& problem, const ExplainOptions& options,
                            const Context& context) {
  const TransitionSystem system(problem);
  ConnectionSet open = system.start();
  if (!options.plan) return open;
  const PlanFile plan = read_plan(*options.plan, problem.direction());
  warn_of_another_problem(context, plan.problem_digest, problem);
  const std::size_t step = options.step.value_or(1);
  if (step > plan.sequence.size() + 1)
    throw InputError(fmt::format("--step: the plan has only {}, so step {} is not in it",
                                 counted(plan.sequence.size(), "step"), step));
  Expander expander(system);
  bool warned = false;
  for (std::size_t i = 0; i + 1 < step; ++i) {
    const std::string place = fmt::format("{}: step {}", *options.plan, i + 1);
    const ConnectionIndex c = problem.find_connection(plan.sequence[i], place);
    if (!open.contains(c))
      throw InputError(
          fmt::format("{}: {} is handled a second time", place, in_quotes(plan.sequence[i])));
    const auto violations = expander.violations(open.view(), c);
    if (!violations.empty() && !warned) {
      context.warn(fmt::format("step {} of the plan is not legal: {}", i + 1,
                               printable(violations.front().message)));
      warned = true;
    }
    open.erase(c);
  }
  return open;
}

ordered_json connection_json(const Problem& problem, const std::string& id, std::uint64_t step,
                             const ConnectionExplanation& found) {
  ordered_json document = {{"status", found.legal ? "legal" : "illegal"},
                           {"conflict", conflict_json(found.violations)},
                           {"connection", id},
                           {"step", step}};
  if (found.legal) {
    document["plan_exists"] =
        found.plan_exists ? ordered_json(*found.plan_exists) : ordered_json(nullptr);
    return document;
  }
  document["changes"] = ordered_json::parse(changes_text(problem, found));
  const bool later = found.later == ConnectionExplanation::Later::Legal;
  document["legal_later"] = found.later == ConnectionExplanation::Later::Unknown
                                ? ordered_json(nullptr)
                                : ordered_json(later);
  document["legal_after"] =
      later ? ordered_json(connection_ids(problem, found.after)) : ordered_json(nullptr);
  if (later) document["fewest"] = found.fewest;
  return document;
}

std::string connection_text(const Problem& problem, const ExplainOptions& options,
                            const ConnectionExplanation& found, const Context& context) {
  const bool assembly = problem.direction() == Direction::Assembly;
  const std::string when =
      options.plan ? fmt::format("at step {}", options.step.value_or(1)) : "first";
  std::string text = fmt::format("{}: {} {} be {} {}\n", title(problem, options.problem),
                                 in_quotes(*options.connection), found.legal ? "may" : "cannot",
                                 assembly ? "made" : "removed", when);
  if (found.legal) {
    text += !found.plan_exists   ? "whether a plan goes on from there is not decided\n"
            : *found.plan_exists ? "a plan goes on from there\n"
                                 : "but no plan goes on from there: it is a dead end\n";
    return text;
  }
  text += '\n';
  for (std::size_t i = 0; i < found.violations.size(); ++i) {
    const Violation& violation = found.violations[i];
    text += fmt::format("  {}: {}\n    {}\n",
                        violation.where.empty() ? constraint_name(violation.constraint)
                                                : std::string_view(violation.where),
                        printable(violation.message), printable(found.remedies[i].message));
    const std::vector<BlockedDirection>& directions = found.remedies[i].directions;
    for (std::size_t d = 1; d < directions.size(); ++d) {
      std::vector<std::string> in_the_way;
      for (const PartIndex part : directions[d].in_the_way)
        in_the_way.push_back(problem.part_id(part));
      const std::string width =
          directions[d].width
              ? fmt::format(" ({})", width_text(*problem.spec().blocking, *directions[d].width))
              : std::string();
      text += fmt::format("    along {}: {}{}\n", directions[d].direction,
                          capped_list(in_the_way, context.width() - 16 - width.size()), width);
    }
  }
  text += '\n';
  switch (found.later) {
    case ConnectionExplanation::Later::Legal:
      text +=
          fmt::format("it becomes legal after {}{}:\n{}", counted(found.after.size(), "other step"),
                      found.fewest ? ", and after no fewer" : "",
                      wrapped_list(connection_ids(problem, found.after), 2, context.width()));
      break;
    case ConnectionExplanation::Later::Never: text += "no other steps make it legal\n"; break;
    case ConnectionExplanation::Later::Unknown:
      text += "whether other steps make it legal is not decided\n";
      break;
  }
  return text;
}

int explain_one(const Problem& problem, const ExplainOptions& options, const Context& context) {
  const ConnectionIndex connection = problem.find_connection(*options.connection, "--connection");
  const ConnectionSet open = state_in_plan(problem, options, context);
  ConnectionExplanation found;
  {
    ProgressLine progress(context, title(problem, options.problem) + ", explain");
    Budget budget = make_budget(options.limits);
    progress.attach_to(budget);
    found = explain_connection(problem, open, connection, budget);
  }
  print_result(context, options.output, options.json,
               connection_json(problem, *options.connection, options.step.value_or(1), found),
               [&] { return connection_text(problem, options, found, context); });
  return found.legal ? kSolved : kNoPlan;
}

}  // namespace

int run(const ExplainOptions& options, const Context& context) {
  if (options.plan && !options.connection)
    throw InputError("--plan needs --connection, the connection to explain");
  if (options.step && !options.plan) throw InputError("--step needs --plan, the plan it counts in");
  if (options.problem == "-" && options.plan == "-")
    throw InputError("PROBLEM and --plan cannot both be read from standard input");
  const Problem problem =
      load_one_robot_problem(options.problem, options.changes, context, "explain");
  if (options.connection && problem.spec().action == StepKind::Part)
    throw InputError(
        "explain --connection answers for steps that take one connection; with \"action\": "
        "\"part\" a step takes several: explain says without it which parts may come off first");
  return options.connection ? explain_one(problem, options, context)
                            : explain_all(problem, options, context);
}

CommandWork explain_command(CommandLine& line) {
  const auto chosen = std::make_shared<ExplainOptions>();
  ExplainOptions& options = *chosen;
  line.about(
      "Says why there is no plan: a smallest set of constraints that conflict; or why a\n"
      "connection cannot be handled first, and what would have to change.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("One connection");
  line.text("--connection", "ID", "Explain this connection (default: the whole problem).",
            options.connection);
  line.text("--plan", "FILE",
            "Explain it in the middle of this plan; - for standard input (default: at the start).",
            options.plan);
  line.whole("--step", "K", "Explain it in the place of step K of the plan (default: 1).",
             options.step, 1);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output, "the explanation");
  line.footer(
      "\nExamples:\n"
      "  orasp explain product.json\n"
      "  orasp explain 4brick --max-moved-parts 0\n"
      "  orasp explain lattice --connection 4-5\n"
      "  orasp explain lattice --connection 4-5 --plan plan.json --step 3\n"
      "\n"
      "Exit codes: 0 a plan exists, or the connection may be handled; 10 no plan exists, or\n"
      "it may not; 20 not decided within the limits; 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
