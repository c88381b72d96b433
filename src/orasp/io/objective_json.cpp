#include "orasp/io/objective_json.h"

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_members.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/detail/objective_members.h"
#include "orasp/io/formula_parser.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/problem.h"

namespace orasp {
namespace detail {
namespace {

using nlohmann::ordered_json;

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
                                           listed(types), suggestion(type, types)));
  }
  return finished(knows({}), Objective::named(type).parameters);  // those without parameters
}

}  // namespace

Objective read_objective(JsonValue value, const Place& place) {
  return read_objective(value, place, 0, nullptr);
}

nlohmann::ordered_json objective_json(const Objective& objective, Defaults defaults) {
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

}  // namespace detail

Objective parse_objective(std::string_view json, const std::string& place) {
  const std::string_view name =
      place.empty() ? std::string_view("objective") : std::string_view(place);
  Objective objective = [&] {
    try {
      const detail::JsonDocument document = detail::JsonDocument::parse(json);
      return detail::read_objective(document.root(), detail::Place(name));
    } catch (const InputError& error) {
      const std::string message = error.what();
      throw message.starts_with(name) ? InputError(message) : InputError(detail::at(name, message));
    }
  }();
  check_objective(objective, std::string(name));
  return objective;
}

std::string objective_text(const Objective& objective) {
  return detail::inline_text(detail::objective_json(objective, detail::Defaults::LeftOut));
}

}  // namespace orasp
