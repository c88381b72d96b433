#include "cli/commands/command_compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/on_ranks.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/json_output.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/cluster/share_out.h"
#include "orasp/cluster/workshop.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/problem_json.h"

namespace orasp::cli {
namespace {

/// One method on one problem. Without a result the method refused the problem, or `failed`: the
/// process that worked on it did, twice. `message` says why.
struct Row {
  std::string problem;
  std::string method;
  bool exact = false;
  bool of_fleet = false;
  bool failed = false;
  std::optional<Result> result;
  std::string message;
  /// Of a plan of several robots.
  std::size_t makespan = 0;
  double travel = 0;

  [[nodiscard]] std::string status() const {
    if (failed) return "failed";
    return result ? std::string(status_name(result->status)) : std::string("refused");
  }
  /// For people: a proved optimum needs no words.
  [[nodiscard]] std::string note() const {
    return result && result->status == Status::Optimal ? std::string() : message;
  }
  [[nodiscard]] bool has_plan() const { return result && result->has_plan(); }
  [[nodiscard]] std::optional<double> reward() const {
    return has_plan() ? std::optional(result->reward) : std::nullopt;
  }
  [[nodiscard]] std::optional<double> bound() const {
    return result && result->bound && std::isfinite(*result->bound) ? result->bound : std::nullopt;
  }
};

/// Where no methods are named: every method for fleets, or every method for one robot that proves
/// something, as the objective says; not the baseline, which takes minutes where the others take
/// milliseconds.
std::vector<const Planner*> all_methods(const Problem& problem) {
  const bool of_fleet = problem.objective().of_fleet();
  std::vector<const Planner*> chosen;
  for (const Planner& planner : planners()) {
    if (planner.role == Role::Chooser || planner.role == Role::Baseline) continue;
    const bool proves = planner.exact || planner.bounds;
    if (of_fleet ? planner.fleets : proves && planner.one_robot) chosen.push_back(&planner);
  }
  return chosen;
}

std::vector<const Planner*> named_methods(const std::string& names) {
  std::vector<const Planner*> chosen;
  if (names.empty()) return chosen;
  for (const std::string& name : comma_separated(names)) {
    const Planner* const planner = &find_planner(name);
    if (std::ranges::find(chosen, planner) == chosen.end()) chosen.push_back(planner);
  }
  return chosen;
}

std::string message_of(const Result& result) {
  std::string text = stop_text(result.stop);
  for (const std::string& note : result.notes) text += (text.empty() ? "" : "; ") + note;
  return text;
}

/// Changes what a run may spend; may be empty.
using AdaptBudget = std::function<void(Budget&)>;

Row row_of(const Problem& problem, const std::string& name, const Planner& planner,
           const CompareOptions& options, const Context& context, const AdaptBudget& adapt) {
  Row row{.problem = name,
          .method = std::string(planner.name),
          .exact = planner.exact,
          .of_fleet = problem.objective().of_fleet(),
          .result = {},
          .message = {}};
  ProgressLine progress(context, printable(name) + ", " + row.method);
  Budget budget = make_budget(options.limits);
  if (adapt) adapt(budget);
  progress.attach_to(budget);
  Options planner_options;
  planner_options.seed = options.seed;
  Task task(problem);
  task.steps = options.steps;
  try {
    row.result = solve(task, planner.name, planner_options, budget);
    row.result->values = {};
    row.makespan = row.result->fleet_plan.makespan();
    row.travel = row.result->fleet_plan.travel();
    row.message = message_of(*row.result);
  } catch (const InputError& error) {
    row.message = error.what();
  }
  return row;
}

/// Whether what `proof` proves speaks of plans such as that of `other`.
bool comparable(const Row& proof, const Row& other) {
  if (!proof.result->steps_allowed) return true;
  // The least travel in so many steps.
  return other.makespan <= *proof.result->steps_allowed;
}

/// Rows of one problem that contradict each other, in a sentence; empty if none do. A proved
/// optimum is the greatest reward of all, whoever finds it.
std::string contradiction(const std::vector<Row>& rows, const std::string& problem) {
  constexpr double kTolerance = 1e-9;
  for (const Row& proof : rows) {
    if (proof.problem != problem || !proof.result) continue;
    for (const Row& other : rows) {
      if (other.problem != problem || !other.has_plan() || !comparable(proof, other)) continue;
      const double reward = other.result->reward;
      if (proof.result->status == Status::Infeasible)
        return fmt::format("{} proves that there is no plan and {} has one", proof.method,
                           other.method);
      if (proof.result->status != Status::Optimal) continue;
      const double slack = kTolerance * std::max(1.0, std::abs(reward));
      const bool better = reward > proof.result->reward + slack;
      const bool worse =
          other.result->status == Status::Optimal && reward < proof.result->reward - slack;
      if (better || worse)
        return fmt::format("{} proves the optimum {} and {} finds {}", proof.method,
                           proof.result->reward, other.method, reward);
    }
  }
  return {};
}

nlohmann::ordered_json as_json(const std::vector<Row>& rows) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  const auto number = [](std::optional<double> value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
  };
  for (const Row& row : rows) {
    const Statistics statistics = row.result ? row.result->statistics : Statistics();
    list.push_back({{"problem", row.problem},
                    {"method", row.method},
                    {"status", row.status()},
                    {"reward", number(row.reward())},
                    {"bound", number(row.bound())},
                    {"seconds", statistics.seconds},
                    {"states", statistics.states},
                    {"actions", statistics.actions},
                    {"expanded", statistics.expanded},
                    {"generated", statistics.generated},
                    {"pruned", statistics.pruned},
                    {"message", row.message}});
    if (row.of_fleet && row.has_plan()) {
      list.back()["makespan"] = row.makespan;
      list.back()["travel"] = row.travel;
    }
  }
  return {{"rows", std::move(list)}};
}

/// A cell of RFC 4180: in quotes if it holds a comma, a quote or a line break; quotes doubled.
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) {
    cell += c;
    if (c == '"') cell += c;
  }
  return cell + '"';
}

std::string as_csv(const std::vector<Row>& rows) {
  const bool any_fleet = std::ranges::any_of(rows, &Row::of_fleet);
  std::string text =
      "problem,method,status,reward,bound,seconds,states,actions,expanded,generated,pruned,message";
  text += any_fleet ? ",makespan,travel\n" : "\n";
  const auto number = [](std::optional<double> value) {
    return value ? fmt::to_string(*value) : std::string();
  };
  for (const Row& row : rows) {
    const Statistics statistics = row.result ? row.result->statistics : Statistics();
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}", csv_cell(row.problem), row.method,
                        row.status(), number(row.reward()), number(row.bound()), statistics.seconds,
                        statistics.states, statistics.actions, statistics.expanded,
                        statistics.generated, statistics.pruned, csv_cell(row.message));
    if (any_fleet) {
      text +=
          row.of_fleet && row.has_plan() ? fmt::format(",{},{}", row.makespan, row.travel) : ",,";
    }
    text += '\n';
  }
  return text;
}

TextTable as_table(const std::vector<Row>& rows) {
  std::vector<double> rewards;
  for (const Row& row : rows) {
    if (row.has_plan()) rewards.push_back(row.result->reward);
  }
  const std::vector<std::string> reward_texts = aligned_numbers(rewards);
  const bool any_message =
      std::ranges::any_of(rows, [](const Row& row) { return !row.note().empty(); });

  const bool any_fleet = std::ranges::any_of(rows, &Row::of_fleet);

  TextTable table;
  table.add_column("problem", TextTable::Align::Left);
  table.add_column("method", TextTable::Align::Left);
  table.add_column("status", TextTable::Align::Left);
  table.add_column("reward", TextTable::Align::Right);
  if (any_fleet) {
    table.add_column("makespan", TextTable::Align::Right);
    table.add_column("travel", TextTable::Align::Right);
  }
  table.add_column("seconds", TextTable::Align::Right);
  table.add_column("states", TextTable::Align::Right);
  if (any_message) table.add_column("note", TextTable::Align::Left);
  std::size_t next_reward = 0;
  for (const Row& row : rows) {
    std::string seconds = row.result ? seconds_text(row.result->statistics.seconds) : "-";
    if (seconds.ends_with(" s")) seconds.resize(seconds.size() - 2);
    std::vector<std::string> cells = {
        row.problem,        row.method,
        row.status(),       row.has_plan() ? reward_texts[next_reward++] : "-",
        std::move(seconds), row.result ? grouped(row.result->statistics.states) : "-"};
    if (any_fleet) {
      const bool has_figures = row.of_fleet && row.has_plan();
      const std::vector<std::string> figures = {has_figures ? fmt::to_string(row.makespan) : "-",
                                                has_figures ? number_text(row.travel) : "-"};
      cells.insert(cells.begin() + 4, figures.begin(), figures.end());
    }
    if (any_message) cells.push_back(row.note());
    table.add_row(std::move(cells));
  }
  return table;
}

std::vector<Problem> load_all(const CompareOptions& options, const Context& context) {
  if (std::ranges::count(options.problems, "-") > 1)
    throw InputError("only one PROBLEM can be read from standard input");
  ProblemChanges changes = options.changes;
  changes.objective.reset();  // a problem that it does not fit is refused in its rows
  std::vector<Problem> problems;
  for (const std::string& name : options.problems)
    problems.push_back(load_problem(name, changes, context));
  return problems;
}

/// A problem under the objective that is asked for, or as it is written with the reason why it
/// cannot have that objective.
struct Asked {
  Problem problem;
  std::string fault;

  Asked(Problem its_problem, std::string its_fault)
      : problem(std::move(its_problem)), fault(std::move(its_fault)) {}
  Asked(const Problem& written, const CompareOptions& options) : problem(written) {
    ProblemChanges changes;
    changes.objective = options.changes.objective;
    if (!changes.objective) return;
    try {
      problem = changed(written, changes);
    } catch (const InputError& error) {
      fault = error.what();
    }
  }
};

/// Runs the methods on one problem and adds their rows. Where the methods were not named, those
/// that refuse are left out, unless all do. @returns false when it was interrupted.
bool add_rows(const Asked& asked, const std::string& name, const std::vector<const Planner*>& named,
              const CompareOptions& options, const Context& context, const AdaptBudget& adapt,
              std::vector<Row>& rows) {
  const Problem& problem = asked.problem;
  const std::vector<const Planner*> methods = named.empty() ? all_methods(problem) : named;
  if (!asked.fault.empty()) {
    for (const Planner* const planner : methods)
      rows.push_back({.problem = name,
                      .method = std::string(planner->name),
                      .exact = planner->exact,
                      .of_fleet = problem.objective().of_fleet(),
                      .result = {},
                      .message = asked.fault});
    return true;
  }
  std::vector<Row> refused;
  const std::size_t before = rows.size();
  for (const Planner* const planner : methods) {
    Row row = row_of(problem, name, *planner, options, context, adapt);
    const bool interrupted = row.result && row.result->stop == Stop::Cancelled;
    std::vector<Row>& list = row.result || !options.methods.empty() ? rows : refused;
    list.push_back(std::move(row));
    if (interrupted) return false;
  }
  if (rows.size() == before) std::ranges::move(refused, std::back_inserter(rows));
  return true;
}

/// Prints the table. @returns the exit code.
int conclude(const std::vector<Row>& rows, bool interrupted, const CompareOptions& options,
             const Context& context) {
  if (options.csv || options.markdown) {
    const std::string table = options.csv ? as_csv(rows) : as_table(rows).markdown();
    if (!options.output.empty()) write_file(options.output, table);
    context.print(table);
  } else {
    print_result(context, options.output, options.json, as_json(rows),
                 [&] { return as_table(rows).text(context.colour()); });
  }

  for (const std::string& problem : options.problems) {
    const std::string found = contradiction(rows, problem);
    if (!found.empty()) {
      print_error(
          fmt::format("internal error: METHODS DISAGREE on {}: {}", printable(problem), found));
      return kInternalError;
    }
  }
  const auto failed = std::ranges::find_if(rows, &Row::failed);
  if (failed != rows.end()) {
    print_error(fmt::format("internal error: {} {}", printable(failed->problem), failed->message));
    return kInternalError;
  }
  return interrupted ? kStopped : kSolved;
}

/// Rows on their way from one process to another: what the table holds of them.
std::string rows_text(const std::vector<Row>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const Row& row : rows) {
    nlohmann::json entry = {{"problem", row.problem},   {"method", row.method},
                            {"exact", row.exact},       {"of_fleet", row.of_fleet},
                            {"failed", row.failed},     {"message", row.message},
                            {"makespan", row.makespan}, {"travel", row.travel}};
    if (row.result) {
      const Statistics& counted = row.result->statistics;
      entry["status"] = static_cast<int>(row.result->status);
      entry["stop"] = static_cast<int>(row.result->stop);
      if (row.has_plan()) entry["reward"] = row.result->reward;
      if (row.bound()) entry["bound"] = *row.bound();
      if (row.result->steps_allowed) entry["steps_allowed"] = *row.result->steps_allowed;
      entry["seconds"] = counted.seconds;
      entry["counters"] = {counted.states, counted.actions, counted.expanded, counted.generated,
                           counted.pruned};
    }
    list.push_back(std::move(entry));
  }
  return list.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::vector<Row> rows_of(const std::string& text) {
  std::vector<Row> rows;
  for (const nlohmann::json& entry : nlohmann::json::parse(text)) {
    Row row{.problem = entry.at("problem"),
            .method = entry.at("method"),
            .exact = entry.at("exact"),
            .of_fleet = entry.at("of_fleet"),
            .failed = entry.at("failed"),
            .result = {},
            .message = entry.at("message"),
            .makespan = entry.at("makespan"),
            .travel = entry.at("travel")};
    if (entry.contains("status")) {
      Result result;
      result.status = static_cast<Status>(entry.at("status").get<int>());
      result.stop = static_cast<Stop>(entry.at("stop").get<int>());
      if (entry.contains("reward")) result.reward = entry.at("reward");
      if (entry.contains("bound")) result.bound = entry.at("bound").get<double>();
      if (entry.contains("steps_allowed"))
        result.steps_allowed = entry.at("steps_allowed").get<std::size_t>();
      const auto counters = entry.at("counters").get<std::array<std::uint64_t, 5>>();
      result.statistics.seconds = entry.at("seconds");
      result.statistics.states = counters[0];
      result.statistics.actions = counters[1];
      result.statistics.expanded = counters[2];
      result.statistics.generated = counters[3];
      result.statistics.pruned = counters[4];
      row.result = std::move(result);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The problems as rank 0 reads them, for all ranks: each with its objective, or why it cannot have
/// that.
std::string asked_text(const CompareOptions& options, const Context& context) {
  nlohmann::json list = nlohmann::json::array();
  for (const Problem& written : load_all(options, context)) {
    const Asked asked(written, options);
    list.push_back({{"problem", problem_text(asked.problem)}, {"fault", asked.fault}});
  }
  return list.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// A piece of the work, for the process that does it.
std::string task_text(const Asked& asked, const std::string& name, std::size_t ranks_near) {
  const nlohmann::json task = {{"problem", problem_text(asked.problem)},
                               {"fault", asked.fault},
                               {"name", name},
                               {"ranks_near", ranks_near}};
  return task.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Does a piece. @returns its rows.
std::string rows_of_task(const std::string& text, const CompareOptions& options,
                         const Context& context, const std::stop_token& stop) {
  const nlohmann::json task = nlohmann::json::parse(text);
  const std::size_t near = task.at("ranks_near");
  const Asked asked(parse_problem(task.at("problem").get<std::string>()),
                    task.at("fault").get<std::string>());
  const AdaptBudget adapt = [&](Budget& budget) {
    budget.stop = stop;
    share_memory(near, options.limits.memory_limit.has_value(), budget);
    if (!options.limits.threads)
      budget.threads = std::max(1U, budget.threads / static_cast<unsigned>(near));
  };
  std::vector<Row> rows;
  static_cast<void>(add_rows(asked, task.at("name"), named_methods(options.methods), options,
                             context, adapt, rows));
  return rows_text(rows);
}

/// The problems are shared out as ranks become free, each of which does them in processes of their
/// own; rank 0 prints the one table.
int compare_on_ranks(const CompareOptions& options, const Context& context) {
  const std::vector<const Planner*> methods = named_methods(options.methods);
  Workshop workshop([&](const std::string& task, const std::stop_token& stopping) {
    return rows_of_task(task, options, context, stopping);
  });
  const std::stop_token stop = make_budget(options.limits).stop;
  return on_ranks([&](Ranks& ranks) {
    std::vector<Asked> asked;
    const std::string text = made_at_rank_0(ranks, [&] { return asked_text(options, context); });
    for (const nlohmann::json& entry : nlohmann::json::parse(text)) {
      asked.emplace_back(parse_problem(entry.at("problem").get<std::string>()),
                         entry.at("fault").get<std::string>());
    }
    const std::size_t near = ranks.on_this_machine();
    const auto work = [&](std::size_t piece, const std::stop_token& stopping) {
      return workshop.make(task_text(asked[piece], options.problems[piece], near), stopping);
    };
    const auto failed = [&](std::size_t piece, const std::string& why) {
      const bool one = methods.size() == 1;
      return rows_text({{.problem = options.problems[piece],
                         .method = one ? std::string(methods.front()->name) : "all methods",
                         .of_fleet = asked[piece].problem.objective().of_fleet(),
                         .failed = true,
                         .result = {},
                         .message = "failed on two ranks: " + why}});
    };
    const auto answers = share_out(ranks, asked.size(), work, failed, stop);
    if (ranks.rank() != 0) return static_cast<int>(kSolved);
    std::vector<Row> rows;
    bool interrupted = false;
    for (const auto& answer : answers) {
      interrupted = interrupted || !answer;
      if (answer) std::ranges::move(rows_of(*answer), std::back_inserter(rows));
    }
    interrupted = interrupted || std::ranges::any_of(rows, [](const Row& row) {
                    return row.result && row.result->stop == Stop::Cancelled;
                  });
    return conclude(rows, interrupted, options, context);
  });
}

}  // namespace

int run(const CompareOptions& options, const Context& context) {
  if (std::ranges::count(std::array{options.json, options.csv, options.markdown}, true) > 1)
    throw InputError("only one of --json, --csv and --markdown can be given");
  if (among_ranks()) return compare_on_ranks(options, context);
  const std::vector<const Planner*> methods = named_methods(options.methods);
  const std::vector<Problem> problems = load_all(options, context);

  std::vector<Row> rows;
  bool interrupted = false;
  for (std::size_t i = 0; i < problems.size() && !interrupted; ++i)
    interrupted = !add_rows(Asked(problems[i], options), options.problems[i], methods, options,
                            context, {}, rows);
  return conclude(rows, interrupted, options, context);
}

CommandWork compare_command(CommandLine& line) {
  const auto chosen = std::make_shared<CompareOptions>();
  CompareOptions& options = *chosen;
  line.about("Runs several methods on several problems and prints one table.");
  line.positionals("PROBLEM", options.problems, kProblemHelp);
  line.group("Method");
  line.text(
      "--methods", "A,B,...",
      "Methods to run (default: every one with a proof that accepts the problem; every one for "
      "fleets where there is a fleet).",
      options.methods);
  line.words(method_names());
  add_seed_option(line, options.seed, "the methods that draw random numbers");
  add_steps_option(line, options.steps);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits, " each run");
  add_output_options(line, options.json, options.output, "the table");
  line.flag("--csv", options.csv,
            "Print the table as CSV; -o then writes CSV too (default: text for people).");
  line.flag("--markdown", options.markdown,
            "Print the table as Markdown; -o then writes Markdown too (default: text for people).");
  line.footer(
      methods_help() +
      "\nExamples:\n"
      "  orasp compare 2x3 lattice hubble\n"
      "  orasp compare hubble --methods greedy,random,orasp-search --markdown\n"
      "  orasp compare problems/*.json --time-limit 10 --csv > table.csv\n"
      "  orasp compare fleet-lattice fleet-hubble --objective fleet_travel\n"
      "\n"
      "Exit codes: 0 compared, whatever the methods said; 20 interrupted, the rows so\n"
      "far are printed; 30 wrong input; 40 exact methods disagree, or on several ranks the\n"
      "work on a problem was ended twice.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
