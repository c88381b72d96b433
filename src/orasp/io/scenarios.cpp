#include "orasp/io/scenarios.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <concepts>
#include <system_error>

#include <fmt/format.h>

#include "orasp/io/embedded_scenarios.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/scenario_generators.h"

namespace orasp {
namespace {

using detail::in_quotes;

/// A family of problems: "chain:50" is its prefix and its arguments.
struct Generator {
  std::string_view prefix;
  std::string_view form;
  std::string_view summary;
  std::string_view example;
  /// What `arguments` describe, or nothing if they do not have the form.
  std::optional<ProblemSpec> (*make)(std::string_view arguments);
};

/// Reads numbers with separators between them: "50:80:3" with ':'. False if the text is anything
/// else.
template <std::unsigned_integral... Numbers>
bool read_numbers(std::string_view text, char separator, Numbers&... numbers) {
  const char* at = text.data();
  const char* const end = at + text.size();
  bool is_first = true;
  const auto read = [&](auto& number) {
    if (!is_first && (at == end || *at++ != separator)) return false;
    is_first = false;
    const auto [stop, error] = std::from_chars(at, end, number);
    at = stop;
    return error == std::errc{};
  };
  return (read(numbers) && ...) && at == end;
}

std::optional<ProblemSpec> make_chain(std::string_view arguments) {
  std::size_t parts = 0;
  if (!read_numbers(arguments, ':', parts)) return std::nullopt;
  return chain(parts);
}

std::optional<ProblemSpec> make_grid(std::string_view arguments) {
  std::size_t rows = 0;
  std::size_t columns = 0;
  if (!read_numbers(arguments, 'x', rows, columns)) return std::nullopt;
  return grid(rows, columns);
}

std::optional<ProblemSpec> make_tree(std::string_view arguments) {
  std::size_t parts = 0;
  std::uint64_t seed = 0;
  if (!read_numbers(arguments, ':', parts, seed)) return std::nullopt;
  return random_tree(parts, seed);
}

std::optional<ProblemSpec> make_random(std::string_view arguments) {
  std::size_t parts = 0;
  std::size_t connections = 0;
  std::uint64_t seed = 0;
  if (!read_numbers(arguments, ':', parts, connections, seed)) return std::nullopt;
  return random_graph(parts, connections, seed);
}

constexpr std::array<Generator, 4> kGenerators = {{
    {"chain:", "chain:N", "N parts in a row", "chain:50", make_chain},
    {"grid:", "grid:RxC", "R rows of C parts, each joined to its neighbours", "grid:5x5",
     make_grid},
    {"tree:", "tree:N:SEED", "a uniformly random tree of N parts", "tree:500:7", make_tree},
    {"random:", "random:N:E:SEED", "a random connected assembly of N parts and E connections",
     "random:50:80:3", make_random},
}};

const Generator* generator_of(std::string_view name) {
  const auto found = std::ranges::find_if(
      kGenerators, [name](const Generator& g) { return name.starts_with(g.prefix); });
  return found == kGenerators.end() ? nullptr : &*found;
}

const detail::EmbeddedFile* embedded(std::string_view name) {
  const auto files = detail::embedded_scenarios();
  const auto found = std::ranges::find(files, name, &detail::EmbeddedFile::name);
  return found == files.end() ? nullptr : &*found;
}

/// "Hubble: 20 parts, 19 connections, precedence".
std::string summary(const Problem& problem) {
  std::string text = fmt::format("{}: {} parts, {} connections", problem.name(),
                                 problem.num_parts(), problem.num_connections());
  const Limits& limits = problem.limits();
  if (!problem.precedence().empty()) text += ", precedence";
  if (!problem.directions().empty()) text += ", blocking";
  if (limits.any()) text += ", limits";
  if (!problem.spec().base.empty()) text += ", base";
  if (problem.spec().fleet) text += fmt::format(", {} robots", problem.spec().fleet->robots);
  return text;
}

}  // namespace

std::vector<ScenarioInfo> scenarios() {
  std::vector<ScenarioInfo> list;
  for (const detail::EmbeddedFile& file : detail::embedded_scenarios()) {
    list.push_back({.name = std::string(file.name), .summary = summary(parse_problem(file.text))});
  }
  for (const Generator& generator : kGenerators) {
    list.push_back({.name = std::string(generator.form),
                    .summary = fmt::format("{}, as in {}", generator.summary, generator.example),
                    .generator = true});
  }
  return list;
}

Problem load_scenario(std::string_view name) {
  if (const auto* file = embedded(name)) return parse_problem(file->text);
  if (const Generator* generator = generator_of(name)) {
    auto spec = generator->make(name.substr(generator->prefix.size()));
    if (!spec) {
      throw InputError(fmt::format("{} is not a scenario; write {} with whole numbers, as in {}",
                                   in_quotes(name), generator->form, generator->example));
    }
    return Problem(*std::move(spec));
  }
  std::vector<std::string_view> known;
  for (const detail::EmbeddedFile& file : detail::embedded_scenarios()) known.push_back(file.name);
  const std::string suggestion = detail::suggestion(name, known);
  for (const Generator& generator : kGenerators) known.push_back(generator.form);
  throw InputError(fmt::format("no scenario {}; scenarios are {}{}", in_quotes(name),
                               detail::listed(known), suggestion));
}

bool is_scenario(std::string_view name) {
  return embedded(name) != nullptr || generator_of(name) != nullptr;
}

}  // namespace orasp
