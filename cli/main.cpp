// The program: picks the command, hands its words to CLI11, and turns exceptions into messages and
// exit codes. What a command does stands in command_NAME.cpp; this is the only file that knows
// CLI11 (it takes seconds to compile).

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "cli/commands/command_compare.h"
#include "cli/commands/command_completion.h"
#include "cli/commands/command_evaluate.h"
#include "cli/commands/command_explain.h"
#include "cli/commands/command_graph.h"
#include "cli/commands/command_paper.h"
#include "cli/commands/command_replan.h"
#include "cli/commands/command_report.h"
#include "cli/commands/command_sample.h"
#include "cli/commands/command_scenarios.h"
#include "cli/commands/command_simulate.h"
#include "cli/commands/command_solve.h"
#include "cli/commands/command_train.h"
#include "cli/exit_codes.h"
#include "cli/options/values.h"
#include "cli/output/text.h"
#include "cli/signals.h"
#include "orasp/bounds/bounds.h"

namespace orasp::cli {
namespace {

using Arguments = std::vector<std::string>;

// -------------------------------------------------------------------------------------------------
// Help texts

constexpr std::size_t kHelpWidth = 80;
constexpr std::size_t kHelpIndent = 28;

/// A name and what it means, in two columns; the second is broken into lines.
std::string entry(const std::string& name, const std::string& meaning) {
  std::string text = "  " + name;
  std::size_t column = text.size();
  const auto new_line = [&] {
    text += '\n' + std::string(kHelpIndent, ' ');
    column = kHelpIndent;
  };
  if (column + 2 > kHelpIndent) {
    new_line();
  } else {
    text.resize(kHelpIndent, ' ');
    column = kHelpIndent;
  }
  std::istringstream words(meaning);
  for (std::string word; words >> word;) {
    if (column > kHelpIndent && column + 1 + word.size() > kHelpWidth) new_line();
    if (column > kHelpIndent) {
      text += ' ';
      ++column;
    }
    text += word;
    column += word.size();
  }
  return text + '\n';
}

/// CLI11 sets its groups two empty lines apart.
std::string without_double_gaps(std::string text) {
  for (std::size_t at = text.find("\n\n\n"); at != std::string::npos; at = text.find("\n\n\n", at))
    text.erase(at, 1);
  return text;
}

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string name =
        is_positional ? option->get_name(true, false) : option->get_name(false, true);
    std::ranges::replace(name, ',', ' ');
    if (!is_positional && option->get_type_size() > 0) name += ' ' + option->get_type_name();
    return entry(name, option->get_description());
  }
  std::string make_usage(const CLI::App* app, std::string) const override {
    std::string text = "\nUsage: orasp " + app->get_name();
    for (const CLI::Option* option : app->get_options()) {
      if (option->get_positional()) text += ' ' + option->get_type_name();
    }
    return text + " [OPTIONS]\n";
  }
};

std::string methods_help() {
  std::string text = "\nMethods:\n";
  for (const Planner& planner : one_robot_planners())
    text += entry(std::string(planner.name), std::string(planner.summary));
  text += "\nMethods for fleets:\n";
  for (const Planner& planner : planners()) {
    if (planner.run_fleet != nullptr && planner.name != "auto")
      text += entry(std::string(planner.name), std::string(planner.summary));
  }
  return text;
}

constexpr const char* kProblemHelp =
    "a file, - for standard input, or a built-in scenario (`orasp scenarios` lists them)";

// -------------------------------------------------------------------------------------------------
// One command's words

/// The options of one command. Every value arrives as text and is checked by ours, so that all
/// errors read alike.
class CommandLine {
 public:
  using Setter = std::function<void(const std::string&)>;

  CommandLine(const std::string& name, const std::string& summary) : app_(summary, name) {
    app_.formatter(std::make_shared<HelpFormatter>());
    app_.get_formatter()->label("Positionals", "Arguments");
    app_.allow_extras();
    app_.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }

  /// `usage` is how the usage line shows it: "PROBLEM", "[NAME]".
  void positional(const std::string& usage, std::string& target, const std::string& help) {
    app_.add_option(bare(usage), target, help)->type_name(usage);
    required(usage, [&target] { return target.empty(); });
  }
  void positionals(const std::string& usage, std::vector<std::string>& targets,
                   const std::string& help) {
    app_.add_option(bare(usage), targets, help)
        ->type_name(usage + "...")
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    required(usage, [&targets] { return targets.empty(); });
  }
  void flag(const std::string& names, bool& target, const std::string& help) {
    app_.add_flag(names, target, help)->disable_flag_override()->group(group_);
  }
  void value(const std::string& names, const std::string& unit, const std::string& help,
             Setter set) {
    const auto take = [=, set = std::move(set)](const std::string& given) {
      if (given.empty()) throw InputError(needs_value(names.substr(names.find("--")), unit));
      set(given);
    };
    app_.add_option_function<std::string>(names, take, help)->type_name(unit)->group(group_);
  }
  void text(const std::string& names, const std::string& unit, const std::string& help,
            auto& target) {
    value(names, unit, help, [&target](const std::string& given) { target = given; });
  }
  void whole(const std::string& name, const std::string& unit, const std::string& help,
             auto& target, std::uint64_t least,
             std::uint64_t greatest = std::numeric_limits<std::uint64_t>::max()) {
    value(name, unit, help, [=, &target](const std::string& given) {
      target = whole_number(name.substr(name.find("--")), given, least, greatest);
    });
  }
  void real(const std::string& name, const std::string& unit, const std::string& help, auto& target,
            Sign sign) {
    value(name, unit, help,
          [=, &target](const std::string& given) { target = number(name, given, sign); });
  }
  /// Options that follow stand under this title in the help.
  void group(const std::string& title) { group_ = title; }
  void footer(const std::string& text) { app_.footer(text); }

  /// @returns false if it was a cry for help, which is then printed. @throws InputError.
  [[nodiscard]] bool parse(const Arguments& arguments) {
    app_.set_help_flag("-h,--help", "Print this help.")->group(group_);  // the last in the list
    try {
      app_.parse(Arguments(arguments.rbegin(), arguments.rend()));
    } catch (const CLI::CallForHelp&) {
      Context(false).print(without_double_gaps(app_.help()));
      return false;
    } catch (const CLI::ParseError& error) {
      refuse_extras();
      throw InputError(sentence(error));
    }
    refuse_extras();
    for (const auto& [name, missing] : required_) {
      if (missing()) throw InputError(fmt::format("{} is missing; {}", name, see_help()));
    }
    return true;
  }

 private:
  static std::string bare(const std::string& usage) {
    const std::size_t begin = usage.find_first_not_of('[');
    return usage.substr(begin, usage.find_first_of("].") - begin);
  }
  void required(const std::string& usage, std::function<bool()> missing) {
    if (usage.front() != '[') required_.emplace_back(usage, std::move(missing));
  }
  [[nodiscard]] static std::string needs_value(const std::string& option, const std::string& unit) {
    return fmt::format("{} needs a value, {}", option, unit);
  }
  [[nodiscard]] std::string see_help() const {
    return fmt::format("`orasp {} --help` lists what it takes", app_.get_name());
  }
  /// An option without its value, a flag with one; otherwise what CLI11 says.
  [[nodiscard]] std::string sentence(const CLI::ParseError& error) const {
    std::string message = error.what();
    const std::string name = message.substr(0, message.find_first_of(": "));
    if (error.get_name() == "ArgumentMismatch" && app_.get_option_no_throw("--" + name) != nullptr)
      return fmt::format("--{} takes no value", name);
    const CLI::Option* const option = app_.get_option_no_throw(name);
    if (option == nullptr) return message;
    return needs_value(name, option->get_type_name());
  }
  void refuse_extras() const {
    const Arguments extras = app_.remaining();
    const auto option =
        std::ranges::find_if(extras, [](const std::string& word) { return word.starts_with('-'); });
    if (option != extras.end()) {
      const std::string name = option->substr(0, option->find('='));
      Arguments known;
      for (const CLI::Option* candidate : app_.get_options()) {
        for (const std::string& long_name : candidate->get_lnames())
          known.push_back("--" + long_name);
      }
      const std::string guess = suggestion(name, known);
      throw InputError(fmt::format("unknown option {}{}", in_quotes(name),
                                   guess.empty() ? "; " + see_help() : guess));
    }
    if (!extras.empty())
      throw InputError(
          fmt::format("unexpected argument {}; {}", in_quotes(extras.front()), see_help()));
  }

  CLI::App app_;
  std::string group_ = "Options";
  std::vector<std::pair<std::string, std::function<bool()>>> required_;
};

void add_problem_options(CommandLine& line, ProblemChanges& changes) {
  line.group("Changes to the problem");
  line.text("--objective", "TYPE|FILE",
            fmt::format(
                "What a step earns: {}; or a JSON file that holds an objective (default: "
                "as in the file). Several robots: makespan, the fewest steps, or travel, the least "
                "(default: makespan).",
                fmt::join(kObjectiveTypes, ", ")),
            changes.objective);
  line.text("--direction", "DIRECTION", "disassembly or assembly (default: as in the file).",
            changes.direction);
  line.whole("--max-subassemblies", "N",
             "At most N pieces of two or more parts after every step (default: as in the file).",
             changes.max_subassemblies, 0);
  line.whole("--max-moved-parts", "N",
             "At most N parts in a moved piece (default: as in the file).", changes.max_moved_parts,
             0);
  line.real("--max-moved-mass", "KG",
            "At most this mass of a moved piece, in kg (default: as in the file).",
            changes.max_moved_mass, Sign::NotNegative);
  line.whole("--robots", "N", "Robots of the fleet (default: as in the file).", changes.robots, 1);
  line.whole("--sites", "K", "The first K sites of the fleet (default: all).", changes.sites, 1);
}

void add_limit_options(CommandLine& line, LimitOptions& limits, const std::string& of = "",
                       bool uses_threads = true) {
  line.group("Limits");
  line.real("--time-limit", "SECONDS",
            fmt::format("Stop{} after this time with the best so far (default: none).", of),
            limits.time_limit, Sign::Positive);
  line.whole("--memory-limit", "MIB",
             "Stop where the method's own tables hold more than this; refuse at once what is sure "
             "to need more (default: three quarters of the machine's memory).",
             limits.memory_limit, 1, std::uint64_t{1} << 40);
  if (!uses_threads) return;
  line.whole(
      "--threads", "N",
      "Threads of beam, and-or and the methods that build H (default: all of the machine's).",
      limits.threads, 1, 4096);
}

void add_output_options(CommandLine& line, bool& json, std::string& output, bool& quiet,
                        const std::string& result) {
  line.group("Output");
  line.flag("--json", json, fmt::format("Print {} as JSON (default: text for people).", result));
  line.text(
      "-o,--output", "FILE",
      fmt::format("Write {} as JSON to FILE too, whole or not at all (default: none).", result),
      output);
  line.flag("--quiet", quiet, "No progress and no warnings on standard error (default: both).");
}

void add_seed_option(CommandLine& line, std::uint64_t& seed, const std::string& of) {
  line.whole("--seed", "N", fmt::format("Seed of {} (default: 1).", of), seed, 0);
}

// -------------------------------------------------------------------------------------------------
// The commands

int solve_command(const Arguments& arguments) {
  SolveOptions options;
  bool quiet = false;
  CommandLine line(
      "solve", "Finds a plan: the order in which to take a product apart, or to put it together.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Method");
  line.text("--method", "METHOD", "One of those below (default: auto).", options.method);
  add_seed_option(line, options.seed, "the methods that draw random numbers");
  line.text(
      "--bound", "BOUND",
      fmt::format(
          "orasp-search, a-star, beam, q-learning: the upper bound on what is left: {} (default: "
          "best; none is the paper's).",
          fmt::join(kBoundNames, ", ")),
      options.bound);
  line.text("--policy", "FILE",
            "dqn: plan with this policy of `orasp train` (default: train one first).",
            options.policy);
  line.text("--write-model", "FILE",
            "mip: write the integer program to FILE.lp or FILE.mps for another solver, and solve "
            "nothing (default: solve it).",
            options.write_model);
  line.text("--sweep-order", "ORDER",
            "value-iteration: layers, or textbook as in the paper (default: layers).",
            options.sweep_order);
  line.real("--epsilon", "REWARD",
            "value-iteration: stop when no value changed by this much (default: 1e-9).",
            options.epsilon, Sign::Positive);
  line.whole("--max-sweeps", "N", "value-iteration: stop after N sweeps (default: none).",
             options.max_sweeps, 1);
  line.real("--initial-value", "REWARD",
            "value-iteration: value of every state to begin with (default: 0).",
            options.initial_value, Sign::Any);
  line.whole(
      "--steps", "N",
      "Methods for fleets: at most N steps (default: makespan as many as it takes, travel the "
      "fewest possible).",
      options.steps, 1, 1'000'000);
  line.group("Other plans");
  line.flag("--count", options.count,
            "Count the optimal sequences; builds H whatever the method (default: do not).");
  line.whole("--alternatives", "K",
             "List the K best plans; builds H whatever the method (default: the one plan).",
             options.alternatives, 1, 1'000'000);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output, quiet, "the plan (format orasp-plan/1)");
  line.footer(methods_help() +
              "\nExamples:\n"
              "  orasp solve hubble\n"
              "  orasp solve product.json --method orasp-search --time-limit 60 -o plan.json\n"
              "  orasp solve jwst --objective time --direction assembly --time-limit 10\n"
              "  orasp solve lattice --count --alternatives 3\n"
              "  orasp solve fleet-lattice --objective travel --steps 5\n"
              "  orasp scenarios grid:4x4 | orasp solve - --json\n"
              "\n"
              "Exit codes: 0 solved, 10 proved infeasible, 20 a limit or Ctrl-C stopped it\n"
              "(the best plan so far is printed), 30 wrong input, 40 internal error.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int graph_command(const Arguments& arguments) {
  GraphOptions options;
  bool quiet = false;
  CommandLine line("graph",
                   "Builds the state-action graph H and prints its size, layer by layer, and that\n"
                   "of the tree H~ that repeats a state for every order that reaches it.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Drawing");
  line.text("--dot", "FILE",
            "Write H in the DOT language, an optimal plan in green; - for standard output "
            "(default: none).",
            options.dot);
  line.text("--svg", "FILE",
            "Draw H with Graphviz, up to 5,000 states; - for standard output (default: none).",
            options.svg);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output, quiet, "the sizes");
  line.footer(
      "\nExamples:\n"
      "  orasp graph lattice\n"
      "  orasp graph 4piece --svg 4piece.svg\n"
      "  orasp graph 2x3 --dot - | dot -Tpdf -o 2x3.pdf\n"
      "\n"
      "Exit codes: 0 built, 10 proved infeasible, 20 a limit stopped it, 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int evaluate_command(const Arguments& arguments) {
  EvaluateOptions options;
  bool quiet = false;
  CommandLine line("evaluate",
                   "Replays a plan step by step: its reward, and every rule that it breaks.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.positional(
      "PLAN", options.plan,
      "a plan file, a JSON array of connection ids or a text with one id a line, in the problem's "
      "direction; - for standard input");
  add_problem_options(line, options.changes);
  add_output_options(line, options.json, options.output, quiet, "the verdict");
  line.footer(
      "\nExamples:\n"
      "  orasp evaluate hubble plan.json\n"
      "  orasp solve hubble --method greedy --json | orasp evaluate hubble -\n"
      "  orasp evaluate product.json order.txt --max-moved-parts 3\n"
      "\n"
      "Exit codes: 0 valid, 10 not valid, 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int explain_command(const Arguments& arguments) {
  ExplainOptions options;
  bool quiet = false;
  CommandLine line(
      "explain",
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
  add_output_options(line, options.json, options.output, quiet, "the explanation");
  line.footer(
      "\nExamples:\n"
      "  orasp explain product.json\n"
      "  orasp explain 4brick --max-moved-parts 0\n"
      "  orasp explain lattice --connection 4-5\n"
      "  orasp explain lattice --connection 4-5 --plan plan.json --step 3\n"
      "\n"
      "Exit codes: 0 a plan exists, or the connection may be handled; 10 no plan exists, or\n"
      "it may not; 20 not decided within the limits; 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int replan_command(const Arguments& arguments) {
  ReplanOptions options;
  bool quiet = false;
  CommandLine line(
      "replan",
      "Finds the best plan from where the work stands, with what has changed since, and\n"
      "says what that changes in the old plan.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Where the work stands");
  line.value("--plan", "FILE", "The old plan; - for standard input (default: none).",
             [&](const std::string& given) { options.plan = given; });
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
            "Parts that are lost: their open connections are inaccessible (default: none).",
            options.lost_parts);
  line.text("--late-part", "IDS",
            "Parts that arrive late: their connections wait until nothing else can be done "
            "(default: none).",
            options.late_parts);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output, quiet,
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
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int compare_command(const Arguments& arguments) {
  CompareOptions options;
  bool quiet = false;
  CommandLine line("compare", "Runs several methods on several problems and prints one table.");
  line.positionals("PROBLEM", options.problems, kProblemHelp);
  line.group("Method");
  line.text("--methods", "A,B,...",
            "Methods to run (default: every exact one that accepts the problem; every one for "
            "fleets where there is a fleet).",
            options.methods);
  add_seed_option(line, options.seed, "the methods that draw random numbers");
  line.whole(
      "--steps", "N",
      "Methods for fleets: at most N steps (default: makespan as many as it takes, travel the "
      "fewest possible).",
      options.steps, 1, 1'000'000);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits, " each run");
  add_output_options(line, options.json, options.output, quiet, "the table");
  line.flag("--csv", options.csv,
            "Print the table as CSV; -o then writes CSV too (default: text for people).");
  line.flag("--markdown", options.markdown,
            "Print the table as Markdown; -o then writes Markdown too (default: text for people).");
  line.footer(methods_help() +
              "\nExamples:\n"
              "  orasp compare 2x3 lattice hubble\n"
              "  orasp compare hubble --methods greedy,random,orasp-search --markdown\n"
              "  orasp compare problems/*.json --time-limit 10 --csv > table.csv\n"
              "  orasp compare fleet-lattice fleet-hubble --objective travel\n"
              "\n"
              "Exit codes: 0 compared, whatever the methods said; 20 interrupted, the rows so\n"
              "far are printed; 30 wrong input; 40 exact methods disagree.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int sample_command(const Arguments& arguments) {
  SampleOptions options;
  bool quiet = false;
  CommandLine line("sample",
                   "Draws random legal sequences, every legal action of a state as likely as any\n"
                   "other, and describes their rewards.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Sample");
  line.whole("-n,--count", "N", "Sequences to draw (default: 100).", options.count, 1);
  add_seed_option(line, options.seed, "the sample");
  line.text("--policy", "FILE",
            "Say too what this policy of `orasp train` earns, and the best plan that auto finds in "
            "the time limit, or 10 s (default: neither).",
            options.policy);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output, quiet, "the figures and all rewards");
  line.flag("--sequences", options.sequences,
            "Add the sequences to the JSON (default: rewards alone).");
  line.footer(
      "\nExamples:\n"
      "  orasp sample hubble-free -n 1000\n"
      "  orasp sample jwst -n 100 --seed 7 --json --sequences\n"
      "\n"
      "Exit codes: 0 drawn, 10 proved infeasible, 20 a limit stopped it, 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int simulate_command(const Arguments& arguments) {
  SimulateOptions options;
  bool quiet = false;
  CommandLine line(
      "simulate",
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
  add_output_options(line, options.json, options.output, quiet, "the figures");
  line.footer(
      "\nExamples:\n"
      "  orasp simulate product.json\n"
      "  orasp solve product.json -o policy.json && orasp simulate product.json --policy "
      "policy.json\n"
      "  orasp simulate product.json --plan plan.json -n 100000 --seed 7 --json\n"
      "\n"
      "Exit codes: 0 simulated, 10 proved infeasible, 20 a limit or Ctrl-C stopped it (the\n"
      "runs so far are described), 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int train_command(const Arguments& arguments) {
  TrainOptions options;
  bool quiet = false;
  DqnOptions& dqn = options.dqn;
  bool no_double_q = false;
  bool no_returns = false;
  bool no_known_reward = false;
  bool no_scaling = false;
  bool to_the_end = false;
  CommandLine line("train",
                   "Learns a policy by deep Q-learning: a network that says in every state which\n"
                   "connection to handle next. `orasp solve --method dqn --policy` plans with it.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Training");
  line.text("-o,--output", "FILE",
            "Write the policy to FILE, now and then and at the end (default: none).",
            options.policy);
  line.text("--resume", "FILE", "Go on from this policy (default: begin anew).", options.resume);
  line.text("--log", "FILE", "Write a line of JSON after every round of episodes (default: none).",
            options.log);
  line.real("--checkpoint-every", "SECONDS", "Write the policy this often (default: 30).",
            options.checkpoint_every, Sign::Positive);
  line.whole("--episodes", "N",
             "Episodes to play in all (default: 5000, and 20000 from 128 connections on).",
             dqn.episodes, 1);
  add_seed_option(line, dqn.seed, "the network's first weights and the random actions");
  line.text("--device", "DEVICE", "auto, cpu or cuda (default: auto).", dqn.device);
  line.flag("--to-the-end", to_the_end,
            "Play all episodes (default: stop when the policy's plan earns the proved bound).");
  line.group("As in the paper");
  line.value("--hidden", "N,N,...",
             "Units of the hidden layers (default: two of 128, or of the connections if they are "
             "more).",
             [&dqn](const std::string& given) {
               dqn.hidden = whole_numbers("--hidden", given, 1, 65'536);
             });
  line.real("--learning-rate", "RATE", "Of AdamW (default: 0.001).", dqn.learning_rate,
            Sign::Positive);
  line.whole("--batch", "N", "Steps in a gradient step (default: three times the connections).",
             dqn.batch, 1, 1'000'000);
  line.whole("--replay", "N", "Steps remembered (default: 100000).", dqn.replay, 1, 100'000'000);
  line.real("--discount", "SHARE", "Of the rewards to come (default: 1).", dqn.discount,
            Sign::Share);
  line.real("--epsilon-start", "SHARE", "Random actions at first (default: 0.85).",
            dqn.epsilon_start, Sign::Share);
  line.real("--epsilon-end", "SHARE", "Random actions in the end (default: 0.05).", dqn.epsilon_end,
            Sign::Share);
  line.real("--epsilon-decay", "STEPS", "Steps in which they fall by 1/e (default: 1000).",
            dqn.epsilon_decay, Sign::Positive);
  line.real("--target-rate", "SHARE",
            "What the target network takes over at each gradient step (default: 0.01).",
            dqn.target_rate, Sign::Share);
  line.real("--gradient-clip", "SIZE", "Cut the gradient's components here (default: 100).",
            dqn.gradient_clip, Sign::Positive);
  line.real("--curriculum", "SHARE",
            "Share of the episodes in which the network takes over ever earlier, having begun with "
            "the last connection (default: 0.5).",
            dqn.curriculum, Sign::Share);
  line.group("Beyond the paper");
  line.whole("--environments", "N",
             "Episodes side by side that explore, beside one that acts greedily (default: 7, "
             "and 31 from 128 connections on).",
             dqn.environments, 1, 65'536);
  line.whole("--updates-per-step", "N",
             "Gradient steps for each step of all episodes (default: 1).", dqn.updates_per_step, 1,
             1'000'000);
  line.whole("--n-step", "N",
             "Rewards that a target takes from its episode before the network's estimate; 0: all "
             "(default: 5).",
             dqn.n_step, 0);
  line.real("--imitation", "SHARE",
            "Share of each batch that is taken from the best episode (default: 0.1).",
            dqn.imitation, Sign::Share);
  line.flag("--no-double-q", no_double_q,
            "Let the target network choose the action it values (default: the network chooses).");
  line.flag("--no-returns", no_returns,
            "Let a target be below what its episode earned (default: never).");
  line.flag("--no-known-reward", no_known_reward,
            "Let the network learn each step's own reward too (default: it is added).");
  line.flag("--no-scaling", no_scaling,
            "Learn rewards as they are (default: centred and scaled by random episodes).");
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits, "", false);
  line.group("Output");
  line.flag("--json", options.json, "Print the outcome as JSON (default: text for people).");
  line.flag("--quiet", quiet, "No progress and no warnings on standard error (default: both).");
  line.footer(
      "\nExamples:\n"
      "  orasp train hubble-upc -o policy.pt\n"
      "  orasp solve hubble-upc --method dqn --policy policy.pt\n"
      "  orasp train jwst-upc -o policy.pt --time-limit 600 --log training.jsonl\n"
      "  orasp train jwst-upc --resume policy.pt -o policy.pt --time-limit 600\n"
      "\n"
      "Exit codes: 0 trained, 10 proved infeasible, 20 a limit or Ctrl-C stopped it (the\n"
      "best policy so far is written), 30 wrong input or no libtorch.");
  if (!line.parse(arguments)) return kSolved;
  dqn.double_q = !no_double_q;
  dqn.returns = !no_returns;
  dqn.known_reward = !no_known_reward;
  dqn.scale = !no_scaling;
  dqn.stop_when_proved = !to_the_end;
  return run(options, Context(quiet));
}

int paper_command(const Arguments& arguments) {
  PaperOptions options;
  bool quiet = false;
  bool no_learning = false;
  CommandLine line("paper",
                   "Computes everything of the paper again that can be computed, beside the\n"
                   "printed numbers: DIR/paper.html, paper.md, paper.json, figures/*.svg.");
  line.text("-o,--output", "DIR",
            "Write into this folder, which is made if it is missing (default: orasp-paper).",
            options.folder);
  line.flag("--quick", options.effort.quick,
            "Fewer repeats, smaller growth, training of a second or two (default: a few minutes).");
  line.flag("--no-learning", no_learning, "Leave the learned plans out (default: train them).");
  line.flag("--json", options.json, "Print the numbers as JSON (default: what was written).");
  line.flag("--quiet", quiet, "No progress on standard error (default: what comes next).");
  line.footer(
      "\nExamples:\n"
      "  orasp paper -o paper\n"
      "  orasp paper --quick -o /tmp/paper\n"
      "\n"
      "Exit codes: 0 written, 20 Ctrl-C stopped it (nothing is written), 30 wrong input, or\n"
      "Graphviz or gnuplot is missing.");
  if (!line.parse(arguments)) return kSolved;
  options.effort.learning = !no_learning;
  return run(options, Context(quiet));
}

int report_command(const Arguments& arguments) {
  ReportOptions options;
  bool quiet = false;
  CommandLine line(
      "report",
      "Writes one self-contained page (HTML) about a problem and its plans: the assembly\n"
      "as a drawing, each plan step by step with what allows it, charts, what is proved.");
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
  line.flag("--quiet", quiet, "No progress and no warnings on standard error (default: both).");
  line.footer(
      "\nExamples:\n"
      "  orasp report hubble -o hubble.html\n"
      "  orasp report product.json first.json second.json -o both.html\n"
      "  orasp report lattice --sample-count 1000 -o lattice.html\n"
      "\n"
      "Exit codes: 0 written, 10 written, but a plan breaks rules or none exists (proved),\n"
      "20 written, but a limit stopped the search for a plan, 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int scenarios_command(const Arguments& arguments) {
  ScenariosOptions options;
  bool quiet = false;
  CommandLine line("scenarios", "Lists the built-in problems, or prints one as a problem file.");
  line.positional("[NAME]", options.name, "a scenario: hubble, grid:5x5 (default: list them)");
  add_output_options(line, options.json, options.output, quiet, "the list or the problem");
  line.footer(
      "\nExamples:\n"
      "  orasp scenarios\n"
      "  orasp scenarios lattice > lattice.json\n"
      "  orasp scenarios tree:500:7 | orasp sample - -n 10\n"
      "\n"
      "Exit codes: 0 printed, 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(quiet)) : kSolved;
}

int completion_command(const Arguments& arguments) {
  CompletionOptions options;
  CommandLine line("completion",
                   "Prints a script that completes commands, options, methods and scenarios.");
  line.positional("SHELL", options.shell, "bash");
  line.footer(
      "\nExamples:\n"
      "  source <(orasp completion bash)\n"
      "  orasp completion bash > /etc/bash_completion.d/orasp\n"
      "\n"
      "Exit codes: 0 printed, 30 wrong input.");
  return line.parse(arguments) ? run(options, Context(false)) : kSolved;
}

struct Command {
  const char* name;
  const char* summary;
  int (*run)(const Arguments& arguments);
};

constexpr std::array<Command, 13> kCommands = {{
    {"solve", "find a plan", solve_command},
    {"graph", "size and drawing of the state-action graph", graph_command},
    {"evaluate", "replay a plan: reward, broken rules", evaluate_command},
    {"explain", "why there is no plan, or why a connection cannot go first", explain_command},
    {"replan", "the best plan from where the work stands", replan_command},
    {"compare", "several methods on several problems, one table", compare_command},
    {"sample", "rewards of random sequences", sample_command},
    {"simulate", "run a plan or a policy against random failures", simulate_command},
    {"train", "learn a policy by deep Q-learning", train_command},
    {"report", "one page that shows a problem and its plans", report_command},
    {"paper", "the paper's numbers and figures, computed again", paper_command},
    {"scenarios", "list the built-in problems, or print one", scenarios_command},
    {"completion", "print the completion script for bash", completion_command},
}};

std::string usage() {
  std::string text =
      "orasp plans robotic assembly: proved optimal orders in which to put products together.\n"
      "\nUsage: orasp COMMAND ...\n\nCommands:\n";
  for (const Command& command : kCommands)
    text += fmt::format("  {:<12}{}\n", command.name, command.summary);
  return text +
         "\nOptions:\n"
         "  -h --help   Print this help.\n"
         "  --version   Print the version.\n"
         "\n`orasp COMMAND --help` explains a command. A first try: `orasp solve hubble`.\n";
}

int dispatch(const Arguments& arguments) {
  if (arguments.empty()) {
    std::fputs(usage().c_str(), stderr);
    return kWrongInput;
  }
  const std::string& name = arguments.front();
  if (name == "--version") {
    Context(false).print("orasp " ORASP_VERSION "\n");
    return kSolved;
  }
  if (name == "--help" || name == "-h") {
    Context(false).print(usage());
    return kSolved;
  }
  Arguments names;
  for (const Command& command : kCommands) {
    if (name == command.name) return command.run({arguments.begin() + 1, arguments.end()});
    names.emplace_back(command.name);
  }
  const bool is_option = name.starts_with('-');
  if (is_option) names = {"--help", "--version"};
  throw InputError(
      fmt::format("unknown {} {}{}", is_option ? "option" : "command", in_quotes(name),
                  nearest(name, names) ? suggestion(name, names) : "; `orasp --help` lists them"));
}

}  // namespace
}  // namespace orasp::cli

int main(int argc, char** argv) {
  using namespace orasp::cli;
  try {
    prepare_streams();
    return dispatch(Arguments(argv + std::min(argc, 1), argv + argc));
  } catch (const orasp::InputError& error) {
    print_error(error.what());
    return kWrongInput;
  } catch (const std::bad_alloc&) {
    print_error("out of memory; --memory-limit stops a method before that");
  } catch (const std::exception& error) {
    print_error(fmt::format("internal error: {}", error.what()));
  } catch (...) {
    print_error("internal error of an unknown kind");
  }
  return kInternalError;
}
