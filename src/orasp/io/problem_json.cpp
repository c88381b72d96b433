#include "orasp/io/problem_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/io/detail/input_file.h"
#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_members.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/detail/objective_members.h"
#include "orasp/io/detail/problem_spec_text.h"
#include "orasp/io/digest.h"
#include "orasp/io/formula_parser.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

using detail::Defaults;
using detail::fail;
using detail::fail_type;
using detail::in_quotes;
using detail::JsonKind;
using detail::JsonValue;
using detail::Members;
using detail::numbers;
using detail::Place;
using detail::read_array;
using detail::read_by_name;
using detail::read_count;
using detail::read_flag;
using detail::read_id;
using detail::read_number;
using detail::read_point;
using detail::read_string;
using nlohmann::ordered_json;

constexpr std::string_view kFormat = "orasp-problem/1";

// -------------------------------------------------------------------------------------------------
// reading

std::vector<std::string> read_ids(JsonValue value, const Place& place) {
  return read_array(value, place, "an array of connection ids", read_id);
}

std::vector<std::string> read_directions(JsonValue value, const Place& place) {
  return read_array(value, place, "an array of directions", read_string);
}

std::vector<std::string> read_part_ids(JsonValue value, const Place& place) {
  return read_array(value, place, "an array of part ids", read_id);
}

/// Numbers of the user's own. That a name is free in formulas is known here, where they are parsed.
std::map<std::string, double> read_own_numbers(JsonValue value, const Place& place) {
  auto values = read_by_name(value, place, "an object of numbers by name", read_number);
  for (const auto& [name, number] : values) {
    for (const std::string& used : names_in_formulas(name)) {
      if (is_formula_builtin(used)) {
        fail(place, fmt::format("{} is a function or a constant of every formula; give the number "
                                "another name",
                                in_quotes(used)));
      }
    }
  }
  return values;
}

Part read_part(JsonValue value, const Place& place) {
  constexpr auto kKeys =
      std::to_array<std::string_view>({"id", "name", "product", "mass", "position", "numbers"});
  const Members members(value, place, kKeys);
  Part part;
  part.id = members.read_required("id", read_id);
  members.read("name", part.name, read_string);
  members.read("product", part.product, read_string);
  members.read("mass", part.mass, read_number);
  members.read("position", part.position, read_point<3>);
  members.read("numbers", part.numbers, read_own_numbers);
  return part;
}

OnFailure read_on_failure(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"breaks", "abort"});
  if (value.is(JsonKind::String)) {
    if (value.string() == "retry") return {};
    fail(place, in_quotes(value.string()) +
                    R"( is not what a failure does; that is "retry", {"breaks": [...]} or )"
                    R"({"abort": reward})");
  }
  if (!value.is(JsonKind::Object))
    fail_type(place, value, R"("retry", {"breaks": [...]} or {"abort": reward})");
  const Members members(value, place, kKeys);
  const auto breaks = members.find("breaks");
  OnFailure failure;
  members.read("breaks", failure.breaks, read_ids);
  members.read("abort", failure.abort, read_number);
  if (!breaks && !failure.abort)
    fail(place, R"("breaks" or "abort" is missing, one of them is needed)");
  if (breaks && failure.breaks.empty())
    fail(Place(place, "breaks"), "an empty list breaks nothing; write \"retry\"");
  return failure;
}

Connection read_connection(JsonValue value, const Place& place) {
  constexpr auto kKeys =
      std::to_array<std::string_view>({"id", "parts", "duration", "success", "axis", "on_failure",
                                       "numbers", "attributes", "position"});
  const Members members(value, place, kKeys);
  Connection connection;
  members.read("id", connection.id, read_id);
  const auto parts = members.read_required("parts", [](JsonValue list, const Place& list_place) {
    auto ids = read_array(list, list_place, "an array of two part ids", read_id);
    if (ids.size() != 2)
      fail(list_place, fmt::format("expected two part ids, found {}", ids.size()));
    return ids;
  });
  std::ranges::copy(parts, connection.parts.begin());
  members.read("duration", connection.duration, read_number);
  members.read("success", connection.success, read_number);
  members.read("axis", connection.axis, read_string);
  members.read("on_failure", connection.on_failure, read_on_failure);
  members.read("numbers", connection.numbers, read_own_numbers);
  members.read("attributes", connection.attributes, [](JsonValue all, const Place& all_place) {
    return read_by_name(all, all_place, "an object of strings by name", read_string);
  });
  members.read("position", connection.position, read_point<3>);
  return connection;
}

Precedence read_precedence(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>(
      {"connection", "after", "after_any", "made_after", "made_after_any"});
  const Members members(value, place, kKeys);
  Precedence rule;
  rule.connection = members.read_required("connection", read_id);
  members.read("after", rule.after, read_ids);
  members.read("made_after", rule.made_after, read_ids);
  bool stated = members.find("after") || members.find("made_after");
  const auto read_any = [&](const char* key, std::vector<std::string>& ids) {
    members.read(key, ids, read_ids);
    if (!members.find(key)) return;
    if (ids.empty()) fail(Place(place, key), "an empty list could never be met; leave the key out");
    stated = true;
  };
  read_any("after_any", rule.after_any);
  read_any("made_after_any", rule.made_after_any);
  if (!stated) {
    fail(place,
         R"("after", "after_any", "made_after" or "made_after_any" is missing, one is needed)");
  }
  return rule;
}

BlockingDirection read_blocking_direction(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"id", "vector"});
  if (value.is(JsonKind::String)) return {std::string(value.string())};
  if (!value.is(JsonKind::Object))
    fail_type(place, value, R"(an axis, such as "+x", or {"id": ..., "vector": [x, y, z]})");
  const Members members(value, place, kKeys);
  return {members.read_required("id", read_id), members.read_required("vector", read_point<3>)};
}

constexpr std::string_view kWidthNote = "x-width";
constexpr std::string_view kToleranceNote = "x-tolerance";

/// The positive numbers of the note `key` of an object, one or an array of them; none where it
/// holds anything else, for a note is never wrong.
std::vector<double> noted_numbers(JsonValue object, std::string_view key) {
  std::vector<double> numbers;
  bool sound = true;
  const auto take = [&](JsonValue value) {
    sound = sound && value.is(JsonKind::Number) && value.number() > 0;
    if (sound) numbers.push_back(value.number());
  };
  object.for_each([&](JsonValue member) {
    if (member.key() != key) return;
    if (member.is(JsonKind::Array))
      member.for_each(take);
    else
      take(member);
  });
  if (!sound) numbers.clear();
  return numbers;
}

Blocked read_blocked(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"part", "by", "directions"});
  const Members members(value, place, kKeys);
  Blocked entry{.part = members.read_required("part", read_id),
                .by = members.read_required("by", read_id),
                .directions = members.read_required("directions", read_directions)};
  entry.widths = noted_numbers(value, kWidthNote);
  if (entry.widths.size() != entry.directions.size()) entry.widths.clear();
  return entry;
}

Blocking read_blocking(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"directions", "blocked"});
  const Members members(value, place, kKeys);
  Blocking blocking;
  blocking.directions =
      members.read_required("directions", [](JsonValue list, const Place& list_place) {
        return read_array(list, list_place, "an array of directions", read_blocking_direction);
      });
  blocking.blocked = members.read_required("blocked", [](JsonValue list, const Place& list_place) {
    return read_array(list, list_place, "an array of objects", read_blocked);
  });
  const std::vector<double> tolerance = noted_numbers(value, kToleranceNote);
  if (tolerance.size() == 1) blocking.tolerance = tolerance.front();
  return blocking;
}

Limits read_limits(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>(
      {"max_subassemblies", "max_moved_parts", "max_moved_mass", "grounded"});
  const Members members(value, place, kKeys);
  Limits limits;
  members.read("max_subassemblies", limits.max_subassemblies, read_count);
  members.read("max_moved_parts", limits.max_moved_parts, read_count);
  members.read("max_moved_mass", limits.max_moved_mass, read_number);
  members.read("grounded", limits.grounded, read_flag);
  return limits;
}

/// One of a few words. `thing`: what they say, "when a plan stops".
template <class Value>
Value read_word(JsonValue value, const Place& place, std::string_view thing,
                std::initializer_list<std::pair<std::string_view, Value>> words) {
  const std::string given = read_string(value, place);
  std::string known;
  for (const auto& [word, meaning] : words) {
    if (word == given) return meaning;
    known += (known.empty() ? "" : " or ") + in_quotes(word);
  }
  fail(place, fmt::format("{} is not {}; that is {}", in_quotes(given), thing, known));
}

Goal read_goal(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"free", "removed", "stop"});
  const Members members(value, place, kKeys);
  Goal goal;
  members.read("free", goal.free, read_part_ids);
  members.read("removed", goal.removed, read_ids);
  if (!members.find("free") && !members.find("removed"))
    fail(place, R"("free" or "removed" is missing, one of them is needed)");
  members.read("stop", goal.stop, [](JsonValue word, const Place& word_place) {
    return read_word<Goal::Stop>(word, word_place, "when a plan stops",
                                 {{"reached", Goal::Stop::Reached}, {"best", Goal::Stop::Best}});
  });
  return goal;
}

StepKind read_action(JsonValue value, const Place& place) {
  return read_word<StepKind>(value, place, "what a step takes",
                             {{"connection", StepKind::Connection}, {"part", StepKind::Part}});
}

Fleet read_fleet(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"robots", "depot", "sites"});
  const Members members(value, place, kKeys);
  Fleet fleet;
  fleet.robots = members.read_required("robots", read_count);
  members.read("depot", fleet.depot, read_point<2>);
  members.read("sites", fleet.sites, [](JsonValue list, const Place& list_place) {
    return read_array(list, list_place, "an array of points [x, y]", read_point<2>);
  });
  return fleet;
}

Direction read_direction(JsonValue value, const Place& place) {
  const std::string name = read_string(value, place);
  if (name == "disassembly") return Direction::Disassembly;
  if (name == "assembly") return Direction::Assembly;
  fail(place, in_quotes(name) +
                  R"( is not a direction of planning; those are "disassembly" and "assembly")");
}

Geometry read_geometry(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"file"});
  const Members members(value, place, kKeys);
  Geometry geometry;
  geometry.file = members.read_required("file", read_string);
  const Place file(place, "file");
  if (geometry.file.empty())
    fail(file, "an empty name is no file; leave \"geometry\" out where there is none");
  if (geometry.file.find('\0') != std::string::npos)
    fail(file, "a name with a zero character is no file");
  return geometry;
}

ProblemSpec read_spec(JsonValue root) {
  constexpr auto kKeys = std::to_array<std::string_view>(
      {"format", "name", "note", "source", "parts", "connections", "precedence", "blocking",
       "limits", "base", "goal", "action", "objective", "direction", "fleet", "geometry"});
  const Place top("");
  if (!root.is(JsonKind::Object)) fail_type(top, root, "a problem, which is an object");
  const Members members(root, top, kKeys);
  const std::string format = members.read_required("format", read_string);
  if (format != kFormat) {
    fail(Place(top, "format"), fmt::format("{} is not the format of a problem; that is \"{}\"",
                                           in_quotes(format), kFormat));
  }
  ProblemSpec spec;
  members.read("name", spec.name, read_string);
  members.read("note", spec.note, read_string);
  members.read("source", spec.source, read_string);
  spec.parts = members.read_required("parts", [](JsonValue list, const Place& place) {
    return read_array(list, place, "an array of parts", read_part);
  });
  spec.connections = members.read_required("connections", [](JsonValue list, const Place& place) {
    return read_array(list, place, "an array of connections", read_connection);
  });
  members.read("precedence", spec.precedence, [](JsonValue list, const Place& place) {
    return read_array(list, place, "an array of objects", read_precedence);
  });
  members.read("blocking", spec.blocking, read_blocking);
  members.read("limits", spec.limits, read_limits);
  members.read("base", spec.base, read_part_ids);
  members.read("goal", spec.goal, read_goal);
  members.read("action", spec.action, read_action);
  if (members.find("fleet")) spec.objective = Objective::named("makespan");
  members.read("objective", spec.objective, [](JsonValue value, const Place& place) {
    return detail::read_objective(value, place);
  });
  members.read("direction", spec.direction, read_direction);
  members.read("fleet", spec.fleet, read_fleet);
  members.read("geometry", spec.geometry, read_geometry);
  return spec;
}

// -------------------------------------------------------------------------------------------------
// writing

ordered_json own_numbers_json(const std::map<std::string, double>& own) {
  ordered_json json = ordered_json::object();
  for (const auto& [name, value] : own) json[name] = value + 0.0;
  return json;
}

ordered_json part_json(const Part& part) {
  ordered_json json = {{"id", part.id}};
  if (!part.name.empty()) json["name"] = part.name;
  if (!part.product.empty()) json["product"] = part.product;
  if (part.mass != Part{}.mass) json["mass"] = part.mass + 0.0;
  if (part.position) json["position"] = numbers(*part.position);
  if (!part.numbers.empty()) json["numbers"] = own_numbers_json(part.numbers);
  return json;
}

ordered_json on_failure_json(const OnFailure& failure) {
  if (failure.abort) return {{"abort", *failure.abort + 0.0}};
  return {{"breaks", failure.breaks}};
}

/// What a connection states of the user's own, where it states it.
void put_own(const Connection& connection, ordered_json& json) {
  if (!connection.numbers.empty()) json["numbers"] = own_numbers_json(connection.numbers);
  if (!connection.attributes.empty()) json["attributes"] = connection.attributes;
  if (connection.position) json["position"] = numbers(*connection.position);
}

ordered_json connection_json(const Connection& connection) {
  ordered_json json = ordered_json::object();
  if (connection.id != connection.parts[0] + "-" + connection.parts[1]) json["id"] = connection.id;
  json["parts"] = connection.parts;
  if (connection.duration != Connection{}.duration) json["duration"] = connection.duration + 0.0;
  if (connection.success != Connection{}.success) json["success"] = connection.success;
  if (!connection.axis.empty()) json["axis"] = connection.axis;
  if (!connection.on_failure.retries()) json["on_failure"] = on_failure_json(connection.on_failure);
  put_own(connection, json);
  return json;
}

ordered_json precedence_json(const Precedence& rule) {
  ordered_json json = {{"connection", rule.connection}};
  const bool nothing_else =
      rule.after_any.empty() && rule.made_after.empty() && rule.made_after_any.empty();
  if (!rule.after.empty() || nothing_else) json["after"] = rule.after;
  if (!rule.after_any.empty()) json["after_any"] = rule.after_any;
  if (!rule.made_after.empty()) json["made_after"] = rule.made_after;
  if (!rule.made_after_any.empty()) json["made_after_any"] = rule.made_after_any;
  return json;
}

ordered_json fleet_json(const Fleet& fleet) {
  ordered_json sites = ordered_json::array();
  for (const auto& site : fleet.sites) sites.push_back(numbers(site));
  return {{"robots", fleet.robots}, {"depot", numbers(fleet.depot)}, {"sites", std::move(sites)}};
}

ordered_json limits_json(const Limits& limits, Defaults defaults) {
  ordered_json json = ordered_json::object();
  const auto put = [&](const char* key, const auto& limit) {
    if (limit) {
      json[key] = *limit;
    } else if (defaults == Defaults::Written) {
      json[key] = nullptr;
    }
  };
  put("max_subassemblies", limits.max_subassemblies);
  put("max_moved_parts", limits.max_moved_parts);
  put("max_moved_mass", limits.max_moved_mass);
  if (limits.grounded) json["grounded"] = true;
  return json;
}

ordered_json goal_json(const Goal& goal) {
  ordered_json json = ordered_json::object();
  if (!goal.free.empty()) json["free"] = goal.free;
  if (!goal.removed.empty() || goal.free.empty()) json["removed"] = goal.removed;
  if (goal.stop == Goal::Stop::Best) json["stop"] = "best";
  return json;
}

ordered_json blocking_direction_json(const BlockingDirection& direction) {
  if (!direction.vector) return direction.id;
  return {{"id", direction.id}, {"vector", numbers(*direction.vector)}};
}

const char* direction_name(Direction direction) {
  return direction == Direction::Assembly ? "assembly" : "disassembly";
}

/// `[` and each element on a line of its own.
template <class Items, class ToJson>
std::string lines(const Items& items, std::string_view indent, ToJson&& to_json) {
  if (items.empty()) return "[]";
  std::string text = "[";
  const char* separator = "\n";
  for (const auto& item : items) {
    text.append(separator).append(indent).append("  ").append(detail::inline_text(to_json(item)));
    separator = ",\n";
  }
  return text.append("\n").append(indent).append("]");
}

/// Precedence as sets: the order of entries and ids, repeats and entries that ask for nothing do
/// not matter.
ordered_json canonical_precedence(const Problem& problem) {
  std::vector<std::vector<ConnectionIndex>> after(problem.num_connections());
  std::vector<std::vector<std::vector<ConnectionIndex>>> after_any(problem.num_connections());
  std::vector<std::vector<std::vector<ConnectionIndex>>> made_after_any(problem.num_connections());
  for (const PrecedenceClause& clause : problem.precedence()) {
    auto& all = after[clause.connection];
    all.insert(all.end(), clause.after.begin(), clause.after.end());
    if (!clause.after_any.empty()) after_any[clause.connection].push_back(clause.after_any);
    if (!clause.made_after_any.empty())
      made_after_any[clause.connection].push_back(clause.made_after_any);
  }
  const auto merge = [](auto& list) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  ordered_json json = ordered_json::array();
  for (std::size_t c = 0; c < problem.num_connections(); ++c) {
    merge(after[c]);
    merge(after_any[c]);
    merge(made_after_any[c]);
    if (after[c].empty() && after_any[c].empty() && made_after_any[c].empty()) continue;
    ordered_json entry = {c, after[c], after_any[c]};
    if (!made_after_any[c].empty()) entry.push_back(made_after_any[c]);
    json.push_back(std::move(entry));
  }
  return json;
}

/// What blocks what after closing under antisymmetry, each pair once; null if nothing blocks and no
/// objective looks at directions.
ordered_json canonical_blocking(const Problem& problem) {
  // Whatever the order in the file: the axes, then the named pairs by id.
  std::vector<DirectionIndex> sorted = problem.directions();
  std::ranges::sort(sorted);
  ordered_json blocked = ordered_json::array();
  for (std::size_t part = 0; part < problem.num_parts(); ++part) {
    for (const Blocker& blocker : problem.blockers()[part]) {
      if (part >= blocker.by) continue;
      ordered_json names = ordered_json::array();
      for (const DirectionIndex d : sorted) {
        if (problem.blocks(blocker, d)) names.push_back(problem.direction_name(d));
      }
      blocked.push_back({part, blocker.by, std::move(names)});
    }
  }
  LookBack look_back;
  kind_of(problem.objective()).add_look_back(problem.objective().parameters, look_back);
  const bool looked_at =
      std::ranges::find(look_back.attributes, kDirectionAttribute) != look_back.attributes.end();
  if (blocked.empty() && !looked_at) return nullptr;
  ordered_json directions = ordered_json::array();
  for (const DirectionIndex d : sorted) {
    if (d < kDirectionNames.size()) {
      directions.push_back(problem.direction_name(d));
    } else if (d % 2 == 0) {
      // Rounded, so that vectors that differ in length alone are the same.
      constexpr double kDigits = 1e12;
      Vector3 vector = problem.direction_vector(d);
      for (double& number : vector) number = std::round(number * kDigits) / kDigits;
      directions.push_back({problem.direction_name(d), numbers(vector)});
    }
  }
  return {{"directions", std::move(directions)}, {"blocked", std::move(blocked)}};
}

/// docs/format.md, section "Digest". Changing one byte of this changes the digest of every problem.
std::string canonical_text(const Problem& problem) {
  ordered_json parts = ordered_json::array();
  for (const Part& part : problem.parts()) {
    ordered_json entry = {part.id, part.mass + 0.0,
                          part.position ? numbers(*part.position) : ordered_json(nullptr)};
    // As all that follows, only where it is stated, so that problems without it keep their digests.
    if (!part.numbers.empty()) entry.push_back(own_numbers_json(part.numbers));
    parts.push_back(std::move(entry));
  }
  ordered_json connections = ordered_json::array();
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const Connection& connection = problem.connections()[c];
    ordered_json entry = {
        connection.id, problem.ends(c), connection.duration + 0.0, connection.success,
        connection.axis.empty() ? ordered_json(nullptr) : ordered_json(connection.axis)};
    if (connection.on_failure.abort) {
      entry.push_back(on_failure_json(connection.on_failure));
    } else if (!problem.breaks(c).empty()) {
      entry.push_back(ordered_json{{"breaks", problem.breaks(c)}});
    }
    ordered_json own = ordered_json::object();
    put_own(connection, own);
    if (!own.empty()) entry.push_back(std::move(own));
    connections.push_back(std::move(entry));
  }
  const auto& fleet = problem.spec().fleet;
  ordered_json json = ordered_json::object();
  json["format"] = kFormat;
  json["parts"] = std::move(parts);
  json["connections"] = std::move(connections);
  json["precedence"] = canonical_precedence(problem);
  json["blocking"] = canonical_blocking(problem);
  json["limits"] = limits_json(problem.limits(), Defaults::Written);
  json["objective"] = detail::objective_json(problem.objective(), Defaults::Written);
  json["direction"] = direction_name(problem.direction());
  json["fleet"] = fleet ? fleet_json(*fleet) : ordered_json(nullptr);
  const ProblemSpec& spec = problem.spec();
  if (!spec.base.empty()) {
    ordered_json base = ordered_json::array();
    for (PartIndex part = 0; part < problem.num_parts(); ++part) {
      if (problem.in_base(part)) base.push_back(part);
    }
    json["base"] = std::move(base);
  }
  if (spec.goal) {
    json["goal"] = {{"removed", problem.goal()},
                    {"stop", spec.goal->stop == Goal::Stop::Best ? "best" : "reached"}};
  }
  if (spec.action == StepKind::Part) json["action"] = "part";
  return json.dump();
}

}  // namespace

ProblemSpec detail::parse_problem_spec(std::string_view json) {
  constexpr auto kLimits = std::to_array<JsonDocument::ArrayLimit>(
      {{"parts", kMaxParts}, {"connections", kMaxConnections}});
  const JsonDocument document = JsonDocument::parse(json, kLimits);
  return read_spec(document.root());
}

Problem parse_problem(std::string_view json) {
  return Problem(detail::parse_problem_spec(json));
}

Problem read_problem(const std::filesystem::path& file) {
  try {
    return parse_problem(detail::input_bytes(file));
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

std::string problem_text(const Problem& problem) {
  return detail::problem_spec_text(problem.spec());
}

std::string detail::problem_spec_text(const ProblemSpec& spec) {
  if (!detail::has_text(spec.objective)) {
    throw InputError(
        "objective: a callable is code and cannot be written to a file; use \"expression\"");
  }
  std::string text = "{\n  \"format\": " + detail::inline_text(kFormat);
  const auto put = [&text](std::string_view key, std::string_view value) {
    text.append(",\n  \"").append(key).append("\": ").append(value);
  };
  const auto put_text = [&](std::string_view key, const std::string& value) {
    if (!value.empty()) put(key, detail::inline_text(value));
  };
  put_text("name", spec.name);
  put_text("note", spec.note);
  put_text("source", spec.source);
  put("parts", lines(spec.parts, "  ", part_json));
  put("connections", lines(spec.connections, "  ", connection_json));
  if (!spec.precedence.empty()) put("precedence", lines(spec.precedence, "  ", precedence_json));
  if (spec.blocking) {
    const std::string blocked = lines(spec.blocking->blocked, "    ", [](const Blocked& entry) {
      ordered_json json = {
          {"part", entry.part}, {"by", entry.by}, {"directions", entry.directions}};
      if (!entry.widths.empty()) json[kWidthNote] = entry.widths;
      return json;
    });
    ordered_json directions = ordered_json::array();
    for (const BlockingDirection& direction : spec.blocking->directions)
      directions.push_back(blocking_direction_json(direction));
    const std::string tolerance = spec.blocking->tolerance > 0
                                      ? ",\n    " + detail::inline_text(kToleranceNote) + ": " +
                                            detail::inline_text(spec.blocking->tolerance)
                                      : std::string();
    put("blocking", "{\n    \"directions\": " + detail::inline_text(directions) + tolerance +
                        ",\n    \"blocked\": " + blocked + "\n  }");
  }
  const ordered_json limits = limits_json(spec.limits, Defaults::LeftOut);
  if (!limits.empty()) put("limits", detail::inline_text(limits));
  if (!spec.base.empty()) put("base", detail::inline_text(ordered_json(spec.base)));
  if (spec.goal) put("goal", detail::inline_text(goal_json(*spec.goal)));
  if (spec.action == StepKind::Part) put_text("action", "part");
  put("objective", detail::inline_text(detail::objective_json(spec.objective, Defaults::LeftOut)));
  if (spec.direction != Direction::Disassembly)
    put_text("direction", direction_name(spec.direction));
  if (spec.fleet) put("fleet", detail::inline_text(fleet_json(*spec.fleet)));
  if (spec.geometry)
    put("geometry", detail::inline_text(ordered_json{{"file", spec.geometry->file}}));
  return text + "\n}\n";
}

std::string problem_digest(const Problem& problem) {
  return detail::sha256_hex(canonical_text(problem));
}

}  // namespace orasp
