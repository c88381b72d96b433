// The program: picks the command and turns exceptions into messages and exit codes. The options of
// a command and what it does stand in commands/command_NAME.cpp.

#include <algorithm>
#include <array>
#include <cstdio>
#include <new>
#include <string>
#include <string_view>
#include <vector>

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
#include "cli/options/command_line.h"
#include "cli/output/text.h"
#include "cli/signals.h"
#include "orasp/model/error.h"

namespace orasp::cli {
namespace {

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
