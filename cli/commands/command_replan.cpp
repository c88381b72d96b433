#include "cli/commands/command_replan.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/conflict.h"
#include "cli/output/json_output.h"
#include "cli/output/plan_summary.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/execution/plan_changes.h"
#include "orasp/execution/replanner.h"
#include "orasp/execution/waiting.h"
#include "orasp/io/atomic_file.h"

namespace orasp::cli {
namespace {

using nlohmann::ordered_json;

/// Calls visit(id) for the ids of an option; none for an empty list.
template <class Visit>
void for_each_id(const std::string& list, Visit&& visit) {
  if (list.empty()) return;
  for (const std::string& id : comma_separated(list)) visit(id);
}

ConnectionSet connections_called(const Problem& problem, const std::string& list,
                                 const std::string& option) {
  ConnectionSet set(problem.num_connections());
  for_each_id(list,
              [&](const std::string& id) { set.insert(problem.find_connection(id, option)); });
  return set;
}

/// All connections of the parts.
ConnectionSet connections_of_parts(const Problem& problem, const std::string& list,
                                   const std::string& option) {
  ConnectionSet set(problem.num_connections());
  for_each_id(list, [&](const std::string& id) {
    const PartIndex part = problem.find_part(id, option);
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      if (std::ranges::count(problem.ends(c), part) > 0) set.insert(c);
    }
  });
  return set;
}

void insert_all(ConnectionSet& set, const ConnectionSet& others) {
  for_each_connection(others.view(), [&](ConnectionIndex c) { set.insert(c); });
}

std::vector<PlanStep> old_steps(const Problem& problem, const ReplanOptions& options,
                                const Context& context) {
  const PlanFile plan = read_plan(*options.plan, problem.direction());
  warn_of_another_problem(context, plan.problem_digest, problem);
  std::vector<PlanStep> steps;
  try {
    steps = plan_steps(problem, plan);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", *options.plan, error.what()));
  }
  ConnectionSet met(problem.num_connections());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    for (const ConnectionIndex c : steps[i].connections) {
      if (met.contains(c)) {
        throw InputError(fmt::format("{}: step {}: {} is handled a second time", *options.plan,
                                     i + 1, in_quotes(problem.connection_id(c))));
      }
      met.insert(c);
    }
  }
  if (options.done.value_or(0) > steps.size()) {
    throw InputError(fmt::format("--done: the plan has only {}, so {} cannot be done",
                                 counted(steps.size(), "step"), *options.done));
  }
  return steps;
}

ordered_json ids_json(const Problem& problem, std::span<const ConnectionIndex> connections) {
  ordered_json ids = ordered_json::array();
  for (const ConnectionIndex c : connections) ids.push_back(problem.connection_id(c));
  return ids;
}

std::string changes_json(const Problem& problem, const PlanChanges& changes) {
  const auto number = [](const std::optional<double>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
  };
  return ordered_json({{"kept", ids_json(problem, changes.kept)},
                       {"moved", ids_json(problem, changes.moved)},
                       {"dropped", ids_json(problem, changes.dropped)},
                       {"added", ids_json(problem, changes.added)},
                       {"reward_before", number(changes.before)},
                       {"price", number(changes.price)}})
      .dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

/// As many ids as stand on a line.
std::string capped_ids(const Problem& problem, std::span<const ConnectionIndex> connections,
                       const Context& context) {
  std::vector<std::string> ids;
  for (const ConnectionIndex c : connections) ids.push_back(problem.connection_id(c));
  return capped_list(ids, context.width() > 60 ? context.width() - 24 : 36);
}

std::string changes_text(const Problem& problem, const PlanChanges& changes,
                         const Context& context) {
  std::string text = "\nagainst the old plan\n";
  const auto list = [&](const char* name, const std::vector<ConnectionIndex>& connections) {
    if (connections.empty()) return;
    text += fmt::format("  {:<8} {}: ", name, counted(connections.size(), "step"));
    text += capped_ids(problem, connections, context) + '\n';
  };
  list("kept", changes.kept);
  list("moved", changes.moved);
  list("dropped", changes.dropped);
  list("added", changes.added);
  if (changes.price) {
    const double price = std::abs(*changes.price) < 1e-12 ? 0 : *changes.price;
    text += fmt::format("  {:<8} {} (its steps would have earned {})\n", "price",
                        number_text(price), number_text(*changes.before));
  } else if (!changes.before) {
    text += "  its steps break a rule from here, so there is no price\n";
  }
  return text;
}

std::vector<ConnectionIndex> listed(const ConnectionSet& set) {
  std::vector<ConnectionIndex> list;
  for_each_connection(set.view(), [&](ConnectionIndex c) { list.push_back(c); });
  return list;
}

/// What is done before late parts are there, and what waits for lost ones.
std::string waiting_text(const Task& task, const std::optional<Waiting>& lost,
                         const ReplanOptions& options, const Result& result,
                         const Context& context) {
  const Problem& problem = task.problem;
  std::string text;
  const auto ids = [&](const std::vector<ConnectionIndex>& connections) {
    return capped_ids(problem, connections, context);
  };
  const auto parts = [](const std::string& list) {
    std::string names;
    for (const std::string& id : comma_separated(list))
      names += (names.empty() ? "" : ", ") + in_quotes(id);
    return names;
  };
  if (lost && !lost->connections.empty()) {
    const std::vector<ConnectionIndex> waiting = listed(lost->connections);
    if (lost->status != Status::Feasible) {
      text += fmt::format("\ngiven up for {}: {}\n  {}\n", parts(options.lost_parts), ids(waiting),
                          lost->status == Status::Infeasible
                              ? "even with it the rest could not be finished"
                              : "whether the rest could be finished with it was not decided");
    } else {
      text += fmt::format("\nwaiting for {}: {}\n  {}\n", parts(options.lost_parts), ids(waiting),
                          result.has_plan() ? "once it is there, all of this can be done"
                                            : "nothing can be done before");
    }
  }
  const auto first_late = std::ranges::find_if(
      result.sequence, [&](ConnectionIndex c) { return task.situation.late.contains(c); });
  if (first_late != result.sequence.end()) {
    const auto before = static_cast<std::size_t>(first_late - result.sequence.begin());
    text += fmt::format("\n{} before {} must be there; step {}, {}, is the first that needs it\n",
                        counted(before, "step"), parts(options.late_parts), before + 1,
                        in_quotes(problem.connection_id(*first_late)));
  }
  return text;
}

Settings settings_of(const ReplanOptions& options) {
  Settings settings;
  const auto note = [&](const char* name, const std::string& ids) {
    if (!ids.empty()) settings[name] = json_string(ids);
  };
  if (options.plan) settings["plan"] = json_string(*options.plan);
  if (options.done) settings["done"] = fmt::to_string(*options.done);
  note("removed", options.removed);
  note("inaccessible", options.inaccessible);
  note("not-next", options.not_next);
  note("lost-part", options.lost_parts);
  note("late-part", options.late_parts);
  note_changes(options.changes, settings);
  note_limits(options.limits, settings);
  return settings;
}

/// H held where it has at most so many actions: about a tenth of a second.
constexpr double kMostActionsHeld = 1e6;

struct Answer {
  Result result;
  std::string
      /// Of generating H and of replacing its rewards, as JSON; empty where neither was done.
      times;
};

/// Under another objective: H is generated once for the problem as it is written, and its rewards
/// are replaced.
Answer reweighed(const Problem& written, const Problem& problem, const Situation& now,
                 const ReplanOptions& options, const Budget& budget) {
  Replanner replanner(written, {.most_actions = kMostActionsHeld}, budget);
  if (!replanner.holds_graph()) return {solve(Task(problem, now), "auto", {}, budget), ""};
  const double generated = replanner.seconds_to_build();
  const bool replaced = replanner.reweigh(problem, budget);
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    if (!now.open.contains(c)) replanner.set_done(c);
    replanner.set_accessible(c, !now.inaccessible.contains(c));
  }
  for_each_connection(now.not_next.view(),
                      [&](ConnectionIndex c) { replanner.set_possible_next(c, false); });
  for_each_id(options.late_parts, [&](const std::string& id) {
    replanner.set_late(problem.find_part(id, "--late-part"), true);
  });
  Answer answer{replanner.plan(budget), ""};
  if (replaced) {
    answer.times = ordered_json({{"states", replanner.held_states()},
                                 {"generated", generated},
                                 {"reweighed", replanner.seconds_to_build()}})
                       .dump();
    answer.result.notes.push_back(fmt::format(
        "the state-action graph was generated and solved in {}, reweighed for the other "
        "objective and solved again in {}",
        seconds_text(generated), seconds_text(replanner.seconds_to_build())));
  }
  return answer;
}

}  // namespace

int run(const ReplanOptions& options, const Context& context) {
  if (options.done && !options.plan)
    throw InputError("--done counts the steps of an old plan; give it with --plan");
  const Problem written = load_one_robot_problem(options.problem, {}, context, "replan");
  const Problem problem = changed(written, options.changes);
  std::vector<PlanStep> old;
  if (options.plan)
    old = old_steps(options.changes.direction ? problem : written, options, context);

  Situation now = Situation::whole(problem.num_connections());
  const auto no_longer_open = [&](ConnectionIndex c) { now.open.erase(c); };
  const bool wide = TransitionSystem(problem).wide();
  for (const PlanStep& step : std::span(old).first(options.done.value_or(0))) {
    if (wide) {
      note_done(problem, step, now);
    } else {
      std::ranges::for_each(step.connections, no_longer_open);
    }
  }
  for_each_connection(connections_called(problem, options.removed, "--removed").view(),
                      no_longer_open);
  now.inaccessible = connections_called(problem, options.inaccessible, "--inaccessible");
  now.not_next = connections_called(problem, options.not_next, "--not-next");
  Budget budget = make_budget(options.limits);
  std::optional<Waiting> lost;
  if (!options.lost_parts.empty()) {
    lost = waiting_for(problem, now,
                       connections_of_parts(problem, options.lost_parts, "--lost-part"), budget);
    insert_all(now.inaccessible, lost->connections);
  }
  now.late = connections_of_parts(problem, options.late_parts, "--late-part");

  const Task task(problem, now);
  Answer answer;
  std::optional<ProblemExplanation> why;
  {
    ProgressLine progress(context, title(problem, options.problem) + ", replan");
    progress.attach_to(budget);
    if (options.changes.objective && !options.changes.direction && !problem.uncertain() && !wide) {
      answer = reweighed(written, problem, now, options, budget);
      require_honest(task, answer.result);
    } else {
      answer.result = solve(task, "auto", {}, budget);
    }
    if (answer.result.status == Status::Infeasible) why = explain_problem(problem, now, budget);
  }
  const Result& result = answer.result;
  std::map<std::string, std::string> more;
  std::optional<std::vector<ConnectionIndex>> reachable;
  if (result.status == Status::Infeasible && problem.spec().goal) {
    reachable = still_reachable(problem, now, budget);
    more["still_reachable"] = ids_json(problem, *reachable).dump();
  }
  if (!answer.times.empty()) more["reweighing"] = answer.times;
  std::optional<PlanChanges> changes;
  if (options.plan && result.has_plan()) {
    changes = changes_between(problem, now, old, result);
    more["changes"] = changes_json(problem, *changes);
  }
  if (lost) more["waiting"] = ids_json(problem, listed(lost->connections)).dump();
  if (why) more["conflict"] = conflict_json(why->conflict).dump();
  const std::string plan = plan_text(task, result, settings_of(options), nullptr, more);
  if (!options.output.empty()) {
    if (result.has_plan()) {
      write_file(options.output, plan);
    } else {
      context.warn("there is no plan, so " + options.output + " is not written");
    }
  }
  if (options.json) {
    context.print(plan);
    return exit_code(result);
  }
  std::string text = plan_summary(task, options.problem, result, context);
  text += waiting_text(task, lost, options, result, context);
  if (changes) text += changes_text(problem, *changes, context);
  if (why && !why->conflict.empty()) text += '\n' + conflict_text(*why);
  if (reachable) {
    text += reachable->empty() ? "\nnothing that the goal asks for can still be taken off\n"
                               : "\nof what the goal asks for, this can still be taken off\n  " +
                                     capped_ids(problem, *reachable, context) + "\n";
  }
  if (!result.notes.empty()) text += '\n';
  for (const std::string& note : result.notes) text += printable(note) + '\n';
  context.print(text);
  return exit_code(result);
}

CommandWork replan_command(CommandLine& line) {
  const auto chosen = std::make_shared<ReplanOptions>();
  ReplanOptions& options = *chosen;
  line.about(
      "Finds the best plan from where the work stands, with what has changed since, and\n"
      "says what that changes in the old plan.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Where the work stands");
  line.value("--plan", "FILE", "The old plan; - for standard input (default: none).",
             [&options](const std::string& given) { options.plan = given; });
  line.whole("--done", "K", "The first K steps of the old plan are done (default: 0).",
             options.done, 0);
  line.text("--removed,--made", "IDS",
            "Connections that are done, separated by commas: removed, or in assembly made "
            "(default: none).",
            options.removed);
  line.group("What has changed");
  line.text("--inaccessible", "IDS",
            "Connections that stay as they are; the goal is everything else (default: none).",
            options.inaccessible);
  line.text("--not-next", "IDS",
            "Connections that cannot be the next step, but may be a later one (default: none).",
            options.not_next);
  line.text("--lost-part", "IDS",
            "Parts that are lost: their open connections wait, and what comes after them or would "
            "shut them out (default: none).",
            options.lost_parts);
  line.text("--late-part", "IDS",
            "Parts that arrive late: their connections wait until nothing else can be done that "
            "leaves a way to the end (default: none).",
            options.late_parts);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output,
                     "the steps still to come (format orasp-plan/1)");
  line.footer(
      "\nExamples:\n"
      "  orasp solve hubble -o plan.json\n"
      "  orasp replan hubble --plan plan.json --done 5 --inaccessible 3-4\n"
      "  orasp replan hubble --removed 1-2,1-3 --lost-part 7 --json\n"
      "  orasp replan hubble --plan plan.json --done 5 --objective time\n"
      "\n"
      "Exit codes: 0 solved, 10 proved infeasible (the conflict is named), 20 a limit or\n"
      "Ctrl-C stopped it (the best plan so far is printed), 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
