#include "orasp/io/problem_source.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/detail/input_file.h"
#include "orasp/io/objective_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::in_quotes;

bool names_a_file(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".json");
}

bool is_there(const std::string& name) {
  std::error_code ignored;
  return std::filesystem::exists(name, ignored);
}

Objective read_objective(const std::string& file) {
  std::string text;
  try {
    text = detail::input_bytes(file);
  } catch (const InputError& error) {
    throw InputError(fmt::format("cannot read {}: {}", in_quotes(file), error.what()));
  }
  return parse_objective(text, file);
}

}  // namespace

Problem find_problem(const std::string& name) {
  if (names_a_file(name)) return read_problem(name);
  if (is_scenario(name)) return load_scenario(name);
  if (is_there(name)) return read_problem(name);
  const std::vector<ScenarioInfo> known = scenarios();
  std::vector<std::string_view> names;
  for (const ScenarioInfo& scenario : known) names.push_back(scenario.name);
  const std::string guess = detail::suggestion(name, names);
  throw InputError(fmt::format(
      "no problem {}: there is neither a file nor a built-in scenario of that name{}",
      in_quotes(name), guess.empty() ? "; `orasp scenarios` lists the scenarios" : guess));
}

Objective find_objective(const std::string& name) {
  std::vector<std::string_view> types(kObjectiveTypes.begin(), kObjectiveTypes.end());
  types.insert(types.end(), kFleetObjectiveTypes.begin(), kFleetObjectiveTypes.end());
  if (std::ranges::find(types, name) != types.end()) return Objective::named(name);
  if (names_a_file(name) || is_there(name)) return read_objective(name);
  throw InputError(fmt::format("no objective {}: it is neither a file nor one of {}{}",
                               in_quotes(name), detail::listed(types),
                               detail::suggestion(name, types)));
}

Direction find_direction(const std::string& name) {
  if (name == "disassembly") return Direction::Disassembly;
  if (name == "assembly") return Direction::Assembly;
  throw InputError(
      fmt::format("unknown direction {}; it is disassembly or assembly", in_quotes(name)));
}

Problem edited(const Problem& problem, const ProblemEdits& edits, std::string_view mark) {
  ProblemSpec spec = problem.spec();
  if (edits.objective) {
    spec.objective = *edits.objective;
    if (!spec.objective.of_fleet()) spec.fleet.reset();
  }
  if (edits.direction) spec.direction = *edits.direction;
  if (edits.max_subassemblies) spec.limits.max_subassemblies = *edits.max_subassemblies;
  if (edits.max_moved_parts) spec.limits.max_moved_parts = *edits.max_moved_parts;
  if (edits.max_moved_mass) spec.limits.max_moved_mass = *edits.max_moved_mass;
  const auto fleet = [&](std::string_view edit) -> Fleet& {
    if (!spec.fleet)
      throw InputError(fmt::format("{}{}: {}", mark, edit,
                                   problem.spec().fleet
                                       ? "an objective of one robot leaves the fleet out"
                                       : "the problem has no \"fleet\" to change"));
    return *spec.fleet;
  };
  if (edits.robots) fleet("robots").robots = *edits.robots;
  if (edits.sites) {
    auto& sites = fleet("sites").sites;
    if (*edits.sites > sites.size())
      throw InputError(fmt::format("{}sites: {} is more than the {} {} of the problem", mark,
                                   *edits.sites, sites.size(),
                                   sites.size() == 1 ? "site" : "sites"));
    sites.resize(*edits.sites);
  }
  return Problem(std::move(spec));
}

}  // namespace orasp
