#include "cli/commands/command_table.h"

#include <array>

#include "cli/commands/command_check.h"
#include "cli/commands/command_compare.h"
#include "cli/commands/command_completion.h"
#include "cli/commands/command_convert.h"
#include "cli/commands/command_evaluate.h"
#include "cli/commands/command_explain.h"
#include "cli/commands/command_graph.h"
#include "cli/commands/command_import.h"
#include "cli/commands/command_paper.h"
#include "cli/commands/command_replan.h"
#include "cli/commands/command_report.h"
#include "cli/commands/command_sample.h"
#include "cli/commands/command_scenarios.h"
#include "cli/commands/command_simulate.h"
#include "cli/commands/command_solve.h"
#include "cli/commands/command_train.h"

namespace orasp::cli {
namespace {

constexpr std::array<Command, 16> kCommands = {{
    {"solve", "find a plan", solve_command, true},
    {"graph", "size and drawing of the state-action graph", graph_command},
    {"evaluate", "replay a plan: reward, broken rules", evaluate_command},
    {"check", "whether a certificate proves that no plan is better", check_command},
    {"explain", "why there is no plan, or why a connection cannot go first", explain_command},
    {"replan", "the best plan from where the work stands", replan_command},
    {"compare", "several methods on several problems, one table", compare_command, true},
    {"sample", "rewards of random sequences", sample_command},
    {"simulate", "run a plan or a policy against random failures", simulate_command},
    {"train", "learn a policy by deep Q-learning", train_command},
    {"report", "one page that shows a problem and its plans", report_command},
    {"paper", "the paper's numbers and figures, computed again", paper_command},
    {"import", "make a problem of a CAD model", import_command},
    {"convert", "read and write other formats of problems and plans", convert_command},
    {"scenarios", "list the built-in problems, or print one", scenarios_command},
    {"completion", "print the completion script for bash", completion_command},
}};

}  // namespace

std::span<const Command> commands() {
  return kCommands;
}

}  // namespace orasp::cli
