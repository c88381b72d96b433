#include "cli/options/shared_options.h"

#include <set>

#include <fmt/format.h>

#include "cli/output/text.h"
#include "orasp/catalogue.h"
#include "orasp/method_options.h"

namespace orasp::cli {

std::string methods_help() {
  std::string text = "\nMethods:\n";
  for (const Planner* const planner : one_robot_planners())
    text += help_entry(planner->name, planner->summary);
  text += "\nMethods for fleets:\n";
  for (const Planner& planner : planners()) {
    if (planner.fleets && planner.role != Role::Chooser)
      text += help_entry(planner.name, planner.summary);
  }
  return text;
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Planner& planner : planners()) names.emplace_back(planner.name);
  return names;
}

void add_method_options(CommandLine& line, OptionTexts& given) {
  std::set<std::string> declared;
  for (const Planner& planner : planners()) {
    for (const OptionSpec& row : planner.options()) {
      const std::string name(row.name);
      if (!declared.insert(name).second) continue;
      line.group("Of " + owners_of(name));
      line.option(row, [&given, name](const std::string& text) { given[name] = text; });
    }
  }
}

void add_problem_options(CommandLine& line, ProblemChanges& changes) {
  line.group("Changes to the problem");
  line.text("--objective", "TYPE|FILE",
            fmt::format(
                "What a step earns: {}; or a JSON file that holds an objective (default: "
                "as in the file). With costs by size (piece_cost, cubesat, custom) the step that "
                "completes earns its completion alone. Several robots: makespan, the fewest steps, "
                "or fleet_travel, the least travel.",
                fmt::join(kObjectiveTypes, ", ")),
            changes.objective);
  std::vector<std::string> objectives(kObjectiveTypes.begin(), kObjectiveTypes.end());
  objectives.insert(objectives.end(), kFleetObjectiveTypes.begin(), kFleetObjectiveTypes.end());
  line.words(std::move(objectives));
  line.text("--direction", "DIRECTION", "disassembly or assembly (default: as in the file).",
            changes.direction);
  line.words({"disassembly", "assembly"});
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

void add_limit_options(CommandLine& line, LimitOptions& limits, const std::string& of,
                       bool uses_threads) {
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

void add_output_options(CommandLine& line, bool& json, std::string& output,
                        const std::string& result) {
  line.group("Output");
  line.flag("--json", json, fmt::format("Print {} as JSON (default: text for people).", result));
  line.text(
      "-o,--output", "FILE",
      fmt::format("Write {} as JSON to FILE too, whole or not at all (default: none).", result),
      output);
  line.quiet_flag("No progress and no warnings on standard error (default: both).");
}

void add_seed_option(CommandLine& line, std::uint64_t& seed, const std::string& of) {
  line.whole("--seed", "N", fmt::format("Seed of {} (default: 1).", of), seed, 0);
}

void add_steps_option(CommandLine& line, std::optional<std::uint64_t>& steps) {
  line.whole(
      "--steps", "N",
      "Methods for fleets: at most N steps (default: makespan as many as it takes, travel the "
      "fewest possible).",
      steps, 1, 1'000'000);
}

}  // namespace orasp::cli
