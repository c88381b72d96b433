#include "cli/commands/command_scenarios.h"

#include <memory>
#include <utility>

#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/json_output.h"
#include "cli/output/text.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"

namespace orasp::cli {
namespace {

nlohmann::ordered_json as_json(const std::vector<ScenarioInfo>& list) {
  nlohmann::ordered_json entries = nlohmann::ordered_json::array();
  for (const ScenarioInfo& scenario : list) {
    nlohmann::ordered_json entry = {{"name", scenario.name},
                                    {"parts", nullptr},
                                    {"connections", nullptr},
                                    {"summary", scenario.summary},
                                    {"generator", scenario.generator}};
    if (!scenario.generator) {
      const Problem problem = load_scenario(scenario.name);
      entry["parts"] = problem.num_parts();
      entry["connections"] = problem.num_connections();
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

std::string summary(const std::vector<ScenarioInfo>& list, const Context& context) {
  TextTable table;
  table.add_column("name", TextTable::Align::Left);
  table.add_column("summary", TextTable::Align::Left);
  for (const ScenarioInfo& scenario : list) table.add_row({scenario.name, scenario.summary});
  return table.text(context.colour());
}

}  // namespace

int run(const ScenariosOptions& options, const Context& context) {
  if (options.name.empty()) {
    const std::vector<ScenarioInfo> list = scenarios();
    print_result(context, options.output, options.json, as_json(list),
                 [&] { return summary(list, context); });
    return kSolved;
  }
  const std::string text = problem_text(load_scenario(options.name));
  if (!options.output.empty()) write_file(options.output, text);
  context.print(text);
  return kSolved;
}

CommandWork scenarios_command(CommandLine& line) {
  const auto chosen = std::make_shared<ScenariosOptions>();
  ScenariosOptions& options = *chosen;
  line.about("Lists the built-in problems, or prints one as a problem file.");
  line.positional("[NAME]", options.name, "a scenario: hubble, grid:5x5 (default: list them)");
  add_output_options(line, options.json, options.output, "the list or the problem");
  line.footer(
      "\nExamples:\n"
      "  orasp scenarios\n"
      "  orasp scenarios lattice > lattice.json\n"
      "  orasp scenarios tree:500:7 | orasp sample - -n 10\n"
      "\n"
      "Exit codes: 0 printed, 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
