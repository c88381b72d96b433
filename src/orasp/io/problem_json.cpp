#include "orasp/io/problem_json.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/digest.h"
#include "orasp/io/formula_parser.h"
#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::JsonKind;
using detail::JsonValue;
using nlohmann::ordered_json;

constexpr std::string_view kFormat = "orasp-problem/1";

// -------------------------------------------------------------------------------------------------
// reading

/// Where a value stands in the file. Places live on the stack, each pointing to the one around it,
/// and become text only for a message: files have millions of them.
class Place {
 public:
  explicit Place(std::string_view name) : name_(name) {}
  Place(const Place& parent, std::string_view key) : parent_(&parent), name_(key) {}
  Place(const Place& parent, std::size_t index) : parent_(&parent), index_(index) {}

  [[nodiscard]] std::string text() const {
    if (parent_ == nullptr) return std::string(name_);
    const std::string outer = parent_->text();
    if (index_) return fmt::format("{}[{}]", outer, *index_);
    return outer.empty() ? detail::key_text(name_) : outer + "." + detail::key_text(name_);
  }

 private:
  const Place* parent_ = nullptr;
  std::string_view name_;
  std::optional<std::size_t> index_;
};

[[noreturn]] void fail(const Place& place, std::string_view message) {
  throw InputError(detail::at(place.text(), message));
}

[[noreturn]] void fail_type(const Place& place, JsonValue value, std::string_view wanted) {
  fail(place, fmt::format("expected {}, found {}", wanted, value.description()));
}

/// Keys that any object may have and that mean nothing to a planner.
bool is_comment(JsonValue member) {
  const std::string_view key = member.key();
  return key.starts_with("x-") ||
         ((key == "note" || key == "source") && member.is(JsonKind::String));
}

/// The members of one JSON object whose keys are known. Owns nothing.
class Members {
 public:
  /// @throws InputError if `object` is not an object or has a key that is neither known nor a
  /// comment.
  Members(JsonValue object, const Place& place, std::span<const std::string_view> known)
      : place_(place), known_(known), values_(known.size()) {
    if (!object.is(JsonKind::Object)) fail_type(place, object, "an object");
    object.for_each([&](JsonValue member) {
      const auto found = std::ranges::find(known, member.key());
      if (found != known.end()) {
        values_[static_cast<std::size_t>(found - known.begin())] = member;
      } else if (member.key() == "note" || member.key() == "source") {
        if (!member.is(JsonKind::String)) fail_type(Place(place, member.key()), member, "a string");
      } else if (!is_comment(member)) {
        fail(place, fmt::format("unknown key {}; known keys are {}{}", in_quotes(member.key()),
                                detail::listed(known), detail::suggestion(member.key(), known)));
      }
    });
  }

  [[nodiscard]] std::optional<JsonValue> find(std::string_view key) const {
    return values_[static_cast<std::size_t>(std::ranges::find(known_, key) - known_.begin())];
  }
  [[nodiscard]] JsonValue require(std::string_view key) const {
    const auto value = find(key);
    if (!value) fail(place_, fmt::format("the key {} is missing", in_quotes(key)));
    return *value;
  }

  /// Reads `key` with `read(value, place)` into `target` if it is there; `target` keeps its default
  /// if not.
  template <class Target, class Read>
  void read(std::string_view key, Target& target, Read&& read) const {
    if (const auto value = find(key)) target = read(*value, Place(place_, key));
  }
  template <class Read>
  [[nodiscard]] auto read_required(std::string_view key, Read&& read) const {
    return read(require(key), Place(place_, key));
  }

 private:
  const Place& place_;
  std::span<const std::string_view> known_;
  std::vector<std::optional<JsonValue>> values_;
};

std::string read_string(JsonValue value, const Place& place) {
  if (!value.is(JsonKind::String)) fail_type(place, value, "a string");
  return std::string(value.string());
}

std::string read_id(JsonValue value, const Place& place) {
  if (value.is(JsonKind::Number)) {
    fail(place, fmt::format("expected an id, which is a string, found {0}; write \"{1}\"",
                            value.description(), detail::number_text(value.number())));
  }
  if (!value.is(JsonKind::String)) fail_type(place, value, "an id, which is a string");
  if (value.string().empty()) fail(place, "an id must not be empty");
  return std::string(value.string());
}

double read_number(JsonValue value, const Place& place) {
  if (!value.is(JsonKind::Number)) fail_type(place, value, "a number");
  return value.number();
}

std::size_t read_count(JsonValue value, const Place& place) {
  constexpr double kMost =
      9007199254740991;  // 2^53 - 1: beyond it a JSON number may not be what was written
  const bool is_number = value.is(JsonKind::Number);
  if (!is_number || value.number() < 0 || value.number() > kMost ||
      value.number() != std::floor(value.number())) {
    fail_type(place, value, "a whole number from 0 to 2^53 - 1");
  }
  return static_cast<std::size_t>(value.number());
}

template <class Read>
auto read_array(JsonValue value, const Place& place, std::string_view wanted, Read&& read) {
  if (!value.is(JsonKind::Array)) fail_type(place, value, wanted);
  std::vector<decltype(read(value, place))> elements;
  value.for_each(
      [&](JsonValue element) { elements.push_back(read(element, Place(place, elements.size()))); });
  return elements;
}

std::vector<std::string> read_ids(JsonValue value, const Place& place) {
  return read_array(value, place, "an array of connection ids", read_id);
}

std::vector<std::string> read_directions(JsonValue value, const Place& place) {
  return read_array(value, place, "an array of directions", read_string);
}

template <std::size_t N>
std::array<double, N> read_point(JsonValue value, const Place& place) {
  const std::string wanted = fmt::format("an array of {} numbers", N);
  const std::vector<double> numbers = read_array(value, place, wanted, read_number);
  if (numbers.size() != N)
    fail(place, fmt::format("expected {}, found {}", wanted, numbers.size()));
  std::array<double, N> point{};
  std::ranges::copy(numbers, point.begin());
  return point;
}

Part read_part(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"id", "name", "mass", "position"});
  const Members members(value, place, kKeys);
  Part part;
  part.id = members.read_required("id", read_id);
  members.read("name", part.name, read_string);
  members.read("mass", part.mass, read_number);
  members.read("position", part.position, read_point<3>);
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
      std::to_array<std::string_view>({"id", "parts", "duration", "success", "axis", "on_failure"});
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
  return connection;
}

Precedence read_precedence(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"connection", "after", "after_any"});
  const Members members(value, place, kKeys);
  Precedence rule;
  rule.connection = members.read_required("connection", read_id);
  members.read("after", rule.after, read_ids);
  members.read("after_any", rule.after_any, read_ids);
  const auto after_any = members.find("after_any");
  if (after_any && rule.after_any.empty()) {
    fail(Place(place, "after_any"), "an empty list could never be met; leave the key out");
  }
  if (!after_any && !members.find("after"))
    fail(place, R"("after" or "after_any" is missing, one of them is needed)");
  return rule;
}

Blocked read_blocked(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"part", "by", "directions"});
  const Members members(value, place, kKeys);
  return {.part = members.read_required("part", read_id),
          .by = members.read_required("by", read_id),
          .directions = members.read_required("directions", read_directions)};
}

Blocking read_blocking(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"directions", "blocked"});
  const Members members(value, place, kKeys);
  Blocking blocking;
  blocking.directions = members.read_required("directions", read_directions);
  blocking.blocked = members.read_required("blocked", [](JsonValue list, const Place& list_place) {
    return read_array(list, list_place, "an array of objects", read_blocked);
  });
  return blocking;
}

Limits read_limits(JsonValue value, const Place& place) {
  constexpr auto kKeys =
      std::to_array<std::string_view>({"max_subassemblies", "max_moved_parts", "max_moved_mass"});
  const Members members(value, place, kKeys);
  Limits limits;
  members.read("max_subassemblies", limits.max_subassemblies, read_count);
  members.read("max_moved_parts", limits.max_moved_parts, read_count);
  members.read("max_moved_mass", limits.max_moved_mass, read_number);
  return limits;
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

std::map<std::size_t, double> read_pieces(JsonValue value, const Place& place) {
  if (!value.is(JsonKind::Object)) fail_type(place, value, "an object of costs by piece size");
  std::map<std::size_t, double> pieces;
  value.for_each([&](JsonValue member) {
    if (is_comment(member)) return;
    const std::string_view key = member.key();
    std::size_t size = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), size);
    const bool is_number =
        error == std::errc{} && end == key.data() + key.size() && !key.starts_with('0');
    if (!is_number || size > kMaxParts) {
      fail(place, fmt::format(R"({} is not a piece size; sizes are "1" to "{}")", in_quotes(key),
                              kMaxParts));
    }
    pieces[size] = read_number(member, Place(place, key));
  });
  return pieces;
}

std::map<std::string, double> read_constants(JsonValue value, const Place& place) {
  if (!value.is(JsonKind::Object)) fail_type(place, value, "an object of numbers by name");
  std::map<std::string, double> constants;
  value.for_each([&](JsonValue member) {
    if (is_comment(member)) return;
    constants[std::string(member.key())] = read_number(member, Place(place, member.key()));
  });
  return constants;
}

Objective read_objective(JsonValue value, const Place& place, std::size_t sums_outside,
                         double* weight);

WeightedSum read_terms(JsonValue value, const Place& place, std::size_t sums_outside) {
  if (sums_outside >= kMaxSumDepth)
    fail(place, fmt::format("sums stand in sums more than {} deep", kMaxSumDepth));
  WeightedSum sum;
  sum.terms = read_array(
      value, place, "an array of objectives", [&](JsonValue term, const Place& term_place) {
        WeightedObjective weighted;
        weighted.objective = read_objective(term, term_place, sums_outside + 1, &weighted.weight);
        return weighted;
      });
  return sum;
}

/// `weight` is where the key "weight" goes, which only a term of a sum has.
Objective read_objective(JsonValue value, const Place& place, std::size_t sums_outside,
                         double* weight) {
  if (!value.is(JsonKind::Object))
    fail_type(place, value, R"(an object such as {"type": "cubesat"})");
  std::optional<JsonValue> type_value;
  value.for_each([&](JsonValue member) {
    if (member.key() == "type") type_value = member;
  });
  if (!type_value) fail(place, "the key \"type\" is missing");
  const std::string type = read_string(*type_value, Place(place, "type"));

  std::vector<std::string_view> known = {"type"};
  if (weight != nullptr) known.emplace_back("weight");
  const auto knows = [&](std::initializer_list<std::string_view> keys) {
    known.insert(known.end(), keys);
    return Members(value, place, known);
  };

  const auto finished = [&](const Members& read, Objective::Parameters parameters) {
    if (weight != nullptr) read.read("weight", *weight, read_number);
    return Objective{type, std::move(parameters)};
  };
  if (type == "piece_cost") {
    const Members read = knows({"operation", "pieces", "completion"});
    PieceCost cost;
    read.read("operation", cost.operation, read_number);
    read.read("pieces", cost.pieces, read_pieces);
    read.read("completion", cost.completion, read_number);
    return finished(read, std::move(cost));
  }
  if (type == "time") {
    const Members read = knows({"depot", "speed", "transfer"});
    TimeObjective time;
    read.read("depot", time.depot, read_point<3>);
    read.read("speed", time.speed, read_number);
    read.read("transfer", time.transfer, read_number);
    return finished(read, time);
  }
  if (type == "travel") {
    const Members read = knows({"depot"});
    Travel travel;
    read.read("depot", travel.depot, read_point<3>);
    return finished(read, travel);
  }
  if (type == "fuel") {
    const Members read = knows({"dry_mass", "delta_v", "isp"});
    Fuel fuel;
    read.read("dry_mass", fuel.dry_mass, read_number);
    read.read("delta_v", fuel.delta_v, read_number);
    read.read("isp", fuel.isp, read_number);
    return finished(read, fuel);
  }
  if (type == "completion") {
    const Members read = knows({"join", "step", "bonus"});
    CompletionObjective completion;
    read.read("join", completion.join, read_number);
    read.read("step", completion.step, read_number);
    read.read("bonus", completion.bonus, read_number);
    return finished(read, completion);
  }
  if (type == "expression") {
    const Members read = knows({"formula", "constants", "depot"});
    Expression expression;
    expression.formula = read.read_required("formula", read_string);
    read.read("constants", expression.constants, read_constants);
    read.read("depot", expression.depot, read_point<3>);
    expression.compiler = compile_formula;
    return finished(read, std::move(expression));
  }
  if (type == "sum") {
    const Members read = knows({"terms"});
    return finished(read, read_terms(read.require("terms"), Place(place, "terms"), sums_outside));
  }
  std::vector<std::string_view> types(kObjectiveTypes.begin(), kObjectiveTypes.end());
  types.insert(types.end(), kFleetObjectiveTypes.begin(), kFleetObjectiveTypes.end());
  if (std::ranges::find(types, type) == types.end()) {
    fail(Place(place, "type"), fmt::format("no objective {}; objectives are {}{}", in_quotes(type),
                                           detail::listed(types), detail::suggestion(type, types)));
  }
  return finished(knows({}), Objective::named(type).parameters);  // those without parameters
}

ProblemSpec read_spec(JsonValue root) {
  constexpr auto kKeys = std::to_array<std::string_view>(
      {"format", "name", "note", "source", "parts", "connections", "precedence", "blocking",
       "limits", "objective", "direction", "fleet"});
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
  if (members.find("fleet")) spec.objective = Objective::named("makespan");
  members.read("objective", spec.objective, [](JsonValue value, const Place& place) {
    return read_objective(value, place, 0, nullptr);
  });
  members.read("direction", spec.direction, read_direction);
  members.read("fleet", spec.fleet, read_fleet);
  return spec;
}

// -------------------------------------------------------------------------------------------------
// writing

/// Whether to leave out what a reader would fill in by itself.
enum class Defaults { LeftOut, Written };

ordered_json numbers(const auto& point) {
  ordered_json array = ordered_json::array();
  for (const double x : point) array.push_back(x + 0.0);
  return array;
}

ordered_json objective_json(const Objective& objective, Defaults defaults) {
  const bool full = defaults == Defaults::Written;
  ordered_json json = {{"type", objective.type}};
  const auto put = [&](const char* key, double value, double usual) {
    if (full || value != usual) json[key] = value + 0.0;
  };
  const auto put_depot = [&](const Vector3& depot) {
    if (full || depot != Vector3{}) json["depot"] = numbers(depot);
  };

  if (const auto* cost = std::get_if<PieceCost>(&objective.parameters)) {
    if (!full && objective.type != "piece_cost") return json;
    json["type"] = "piece_cost";
    put("operation", cost->operation, PieceCost{}.operation);
    ordered_json pieces = ordered_json::object();
    for (const auto& [size, value] : cost->pieces) {
      if (value != 0) pieces[std::to_string(size)] = value;
    }
    if (full || !pieces.empty()) json["pieces"] = std::move(pieces);
    put("completion", cost->completion, PieceCost{}.completion);
  } else if (const auto* time = std::get_if<TimeObjective>(&objective.parameters)) {
    put_depot(time->depot);
    put("speed", time->speed, TimeObjective{}.speed);
    put("transfer", time->transfer, TimeObjective{}.transfer);
  } else if (const auto* travel = std::get_if<Travel>(&objective.parameters)) {
    put_depot(travel->depot);
  } else if (const auto* fuel = std::get_if<Fuel>(&objective.parameters)) {
    put("dry_mass", fuel->dry_mass, Fuel{}.dry_mass);
    put("delta_v", fuel->delta_v, Fuel{}.delta_v);
    put("isp", fuel->isp, Fuel{}.isp);
  } else if (const auto* completion = std::get_if<CompletionObjective>(&objective.parameters)) {
    put("join", completion->join, CompletionObjective{}.join);
    put("step", completion->step, CompletionObjective{}.step);
    put("bonus", completion->bonus, CompletionObjective{}.bonus);
  } else if (const auto* expression = std::get_if<Expression>(&objective.parameters)) {
    json["formula"] = expression->formula;
    ordered_json constants = ordered_json::object();
    for (const auto& [name, value] : expression->constants) constants[name] = value + 0.0;
    if (full || !constants.empty()) json["constants"] = std::move(constants);
    put_depot(expression->depot);
  } else if (const auto* callable = std::get_if<Callable>(&objective.parameters)) {
    json["name"] = callable->name;
  } else if (const auto* sum = std::get_if<WeightedSum>(&objective.parameters)) {
    ordered_json terms = ordered_json::array();
    for (const WeightedObjective& term : sum->terms) {
      ordered_json entry = ordered_json::object();
      if (full || term.weight != 1) entry["weight"] = term.weight + 0.0;
      entry.update(objective_json(term.objective, defaults));
      terms.push_back(std::move(entry));
    }
    json["terms"] = std::move(terms);
  }
  return json;
}

bool holds_callable(const Objective& objective) {
  if (std::holds_alternative<Callable>(objective.parameters)) return true;
  const auto* sum = std::get_if<WeightedSum>(&objective.parameters);
  return sum != nullptr && std::ranges::any_of(sum->terms, [](const WeightedObjective& term) {
           return holds_callable(term.objective);
         });
}

ordered_json part_json(const Part& part) {
  ordered_json json = {{"id", part.id}};
  if (!part.name.empty()) json["name"] = part.name;
  if (part.mass != Part{}.mass) json["mass"] = part.mass + 0.0;
  if (part.position) json["position"] = numbers(*part.position);
  return json;
}

ordered_json on_failure_json(const OnFailure& failure) {
  if (failure.abort) return {{"abort", *failure.abort + 0.0}};
  return {{"breaks", failure.breaks}};
}

ordered_json connection_json(const Connection& connection) {
  ordered_json json = ordered_json::object();
  if (connection.id != connection.parts[0] + "-" + connection.parts[1]) json["id"] = connection.id;
  json["parts"] = connection.parts;
  if (connection.duration != Connection{}.duration) json["duration"] = connection.duration + 0.0;
  if (connection.success != Connection{}.success) json["success"] = connection.success;
  if (!connection.axis.empty()) json["axis"] = connection.axis;
  if (!connection.on_failure.retries()) json["on_failure"] = on_failure_json(connection.on_failure);
  return json;
}

ordered_json precedence_json(const Precedence& rule) {
  ordered_json json = {{"connection", rule.connection}};
  if (!rule.after.empty() || rule.after_any.empty()) json["after"] = rule.after;
  if (!rule.after_any.empty()) json["after_any"] = rule.after_any;
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
  return json;
}

ordered_json direction_names(DirectionMask directions) {
  ordered_json names = ordered_json::array();
  for (std::size_t d = 0; d < kDirectionNames.size(); ++d) {
    if ((directions >> d & 1U) != 0) names.push_back(kDirectionNames[d]);
  }
  return names;
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
  for (const PrecedenceClause& clause : problem.precedence()) {
    auto& all = after[clause.connection];
    all.insert(all.end(), clause.after.begin(), clause.after.end());
    if (!clause.after_any.empty()) after_any[clause.connection].push_back(clause.after_any);
  }
  const auto merge = [](auto& list) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  ordered_json json = ordered_json::array();
  for (std::size_t c = 0; c < problem.num_connections(); ++c) {
    merge(after[c]);
    merge(after_any[c]);
    if (!after[c].empty() || !after_any[c].empty()) json.push_back({c, after[c], after_any[c]});
  }
  return json;
}

/// What blocks what after closing under antisymmetry, each pair once; null if nothing blocks.
ordered_json canonical_blocking(const Problem& problem) {
  ordered_json blocked = ordered_json::array();
  for (std::size_t part = 0; part < problem.num_parts(); ++part) {
    for (const Blocker& blocker : problem.blockers()[part]) {
      if (part < blocker.by)
        blocked.push_back({part, blocker.by, direction_names(blocker.directions)});
    }
  }
  if (blocked.empty()) return nullptr;
  return {{"directions", direction_names(problem.directions())}, {"blocked", std::move(blocked)}};
}

/// docs/format.md, section "Digest". Changing one byte of this changes the digest of every problem.
std::string canonical_text(const Problem& problem) {
  ordered_json parts = ordered_json::array();
  for (const Part& part : problem.parts()) {
    parts.push_back({part.id, part.mass + 0.0,
                     part.position ? numbers(*part.position) : ordered_json(nullptr)});
  }
  ordered_json connections = ordered_json::array();
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const Connection& connection = problem.connections()[c];
    ordered_json entry = {
        connection.id, problem.ends(c), connection.duration + 0.0, connection.success,
        connection.axis.empty() ? ordered_json(nullptr) : ordered_json(connection.axis)};
    // Only where it is stated, so that problems without it keep their digests.
    if (connection.on_failure.abort) {
      entry.push_back(on_failure_json(connection.on_failure));
    } else if (!problem.breaks(c).empty()) {
      entry.push_back(ordered_json{{"breaks", problem.breaks(c)}});
    }
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
  json["objective"] = objective_json(problem.objective(), Defaults::Written);
  json["direction"] = direction_name(problem.direction());
  json["fleet"] = fleet ? fleet_json(*fleet) : ordered_json(nullptr);
  return json.dump();
}

/// The bytes of a file, at most one more than may be read. @throws InputError with the reason,
/// without the name.
std::string file_bytes(const std::filesystem::path& file) {
  const auto reason = [](int error) { return InputError(std::generic_category().message(error)); };
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw InputError("it is a directory, not a file");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"),
                                                               std::fclose);
  if (!stream) throw reason(errno);
  std::string bytes;
  constexpr std::size_t kChunk = std::size_t{1} << 20U;
  const auto size = std::filesystem::file_size(file, ignored);
  if (!ignored && size > detail::kMaxJsonBytes) throw InputError("it is larger than 256 MiB");
  if (!ignored) bytes.reserve(static_cast<std::size_t>(size) + kChunk);
  while (bytes.size() <= detail::kMaxJsonBytes) {
    const std::size_t before = bytes.size();
    bytes.resize(before + kChunk);
    const std::size_t got = std::fread(bytes.data() + before, 1, kChunk, stream.get());
    bytes.resize(before + got);
    if (got == kChunk) continue;
    if (std::ferror(stream.get()) != 0) throw reason(errno);
    return bytes;
  }
  throw InputError("it is larger than 256 MiB");
}

}  // namespace

Problem parse_problem(std::string_view json) {
  constexpr auto kLimits = std::to_array<detail::JsonDocument::ArrayLimit>(
      {{"parts", kMaxParts}, {"connections", kMaxConnections}});
  ProblemSpec spec = [&] {
    const detail::JsonDocument document = detail::JsonDocument::parse(json, kLimits);
    return read_spec(document.root());
  }();
  return Problem(std::move(spec));
}

Problem read_problem(const std::filesystem::path& file) {
  try {
    return parse_problem(file_bytes(file));
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

std::string problem_text(const Problem& problem) {
  const ProblemSpec& spec = problem.spec();
  if (holds_callable(spec.objective)) {
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
      return ordered_json{{"part", entry.part}, {"by", entry.by}, {"directions", entry.directions}};
    });
    put("blocking", "{\n    \"directions\": " + detail::inline_text(spec.blocking->directions) +
                        ",\n    \"blocked\": " + blocked + "\n  }");
  }
  const ordered_json limits = limits_json(spec.limits, Defaults::LeftOut);
  if (!limits.empty()) put("limits", detail::inline_text(limits));
  put("objective", detail::inline_text(objective_json(spec.objective, Defaults::LeftOut)));
  if (spec.direction != Direction::Disassembly)
    put_text("direction", direction_name(spec.direction));
  if (spec.fleet) put("fleet", detail::inline_text(fleet_json(*spec.fleet)));
  return text + "\n}\n";
}

std::string problem_digest(const Problem& problem) {
  return detail::sha256_hex(canonical_text(problem));
}

Objective parse_objective(std::string_view json, const std::string& place) {
  const std::string_view name =
      place.empty() ? std::string_view("objective") : std::string_view(place);
  Objective objective = [&] {
    try {
      const detail::JsonDocument document = detail::JsonDocument::parse(json);
      return read_objective(document.root(), Place(name), 0, nullptr);
    } catch (const InputError& error) {
      const std::string message = error.what();
      throw message.starts_with(name) ? InputError(message) : InputError(detail::at(name, message));
    }
  }();
  check_objective(objective, std::string(name));
  return objective;
}

std::string objective_text(const Objective& objective) {
  return detail::inline_text(objective_json(objective, Defaults::LeftOut));
}

}  // namespace orasp
