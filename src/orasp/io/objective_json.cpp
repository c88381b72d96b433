#include "orasp/io/objective_json.h"

#include <algorithm>
#include <charconv>
#include <map>
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
#include "orasp/model/objectives/objective_kind.h"
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
  return read_by_name(value, place, "an object of numbers by name", read_number);
}

ChangeCost read_change(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"from", "to", "cost"});
  const Members members(value, place, kKeys);
  return {.from = members.read_required("from", read_string),
          .to = members.read_required("to", read_string),
          .cost = members.read_required("cost", read_number)};
}

Objective read_objective(JsonValue value, const Place& place, std::size_t sums_outside,
                         double* weight);

/// Learns which keys an objective has and which numbers hold where a file states none.
class KeyList : public ParameterVisitor {
 public:
  std::vector<std::string_view> keys;
  std::map<std::string_view, double> numbers;

  explicit KeyList(const ObjectiveKind& kind) {
    ObjectiveParameters defaults = kind.defaults();
    kind.visit_parameters(defaults, *this);
  }

  void number(std::string_view key, double& value, NumberRange /*allowed*/) override {
    keys.push_back(key);
    numbers[key] = value;
  }
  void point(std::string_view key, Vector3& /*value*/) override { keys.push_back(key); }
  void costs_by_size(std::string_view key, std::map<std::size_t, double>& /*costs*/) override {
    keys.push_back(key);
  }
  void constants(std::string_view key, std::map<std::string, double>& /*constants*/) override {
    keys.push_back(key);
  }
  void name(std::string_view key, std::string& /*name*/) override { keys.push_back(key); }
  void optional_name(std::string_view key, std::optional<std::string>& /*name*/) override {
    keys.push_back(key);
  }
  void optional_point(std::string_view key, std::optional<Vector3>& /*value*/) override {
    keys.push_back(key);
  }
  void changes(std::string_view key, std::vector<ChangeCost>& /*changes*/) override {
    keys.push_back(key);
  }
  void formula(std::string_view key, std::string& /*text*/,
               FormulaCompiler& /*compiler*/) override {
    keys.push_back(key);
  }
  void terms(std::string_view key, std::vector<WeightedObjective>& /*terms*/) override {
    keys.push_back(key);
  }
};

class JsonReader : public ParameterVisitor {
 public:
  JsonReader(const Members& members, const Place& place, std::size_t sums_outside)
      : members_(members), place_(place), sums_outside_(sums_outside) {}

  void number(std::string_view key, double& value, NumberRange /*allowed*/) override {
    members_.read(key, value, read_number);
  }
  void point(std::string_view key, Vector3& value) override {
    members_.read(key, value, read_point<3>);
  }
  void costs_by_size(std::string_view key, std::map<std::size_t, double>& costs) override {
    members_.read(key, costs, read_pieces);
  }
  void constants(std::string_view key, std::map<std::string, double>& constants) override {
    members_.read(key, constants, read_constants);
  }
  void name(std::string_view key, std::string& name) override {
    name = members_.read_required(key, read_string);
  }
  void optional_name(std::string_view key, std::optional<std::string>& name) override {
    members_.read(key, name, read_string);
  }
  void optional_point(std::string_view key, std::optional<Vector3>& value) override {
    members_.read(key, value, read_point<3>);
  }
  void changes(std::string_view key, std::vector<ChangeCost>& changes) override {
    members_.read(key, changes, [](JsonValue list, const Place& place) {
      return read_array(list, place, "an array of objects", read_change);
    });
  }
  void formula(std::string_view key, std::string& text, FormulaCompiler& compiler) override {
    text = members_.read_required(key, read_string);
    compiler = compile_formula;
  }
  void terms(std::string_view key, std::vector<WeightedObjective>& terms) override {
    const Place place(place_, key);
    const JsonValue list = members_.require(key);
    if (sums_outside_ >= kMaxSumDepth)
      fail(place, fmt::format("sums stand in sums more than {} deep", kMaxSumDepth));
    terms = read_array(list, place, "an array of objectives",
                       [&](JsonValue term, const Place& term_place) {
                         WeightedObjective weighted;
                         weighted.objective =
                             read_objective(term, term_place, sums_outside_ + 1, &weighted.weight);
                         return weighted;
                       });
  }

 private:
  const Members& members_;
  const Place& place_;
  std::size_t sums_outside_;
};

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
  const ObjectiveRow* const row = objective_row(type);
  if (row == nullptr || !row->in_files) {
    const auto types = std::span<const std::string_view>(kFileObjectiveTypes);
    fail(Place(place, "type"), fmt::format("no objective {}; objectives are {}{}", in_quotes(type),
                                           listed(types), suggestion(type, types)));
  }

  const ObjectiveKind& kind = row->kind();
  std::vector<std::string_view> known = {"type"};
  if (weight != nullptr) known.emplace_back("weight");
  const KeyList own(kind);
  known.insert(known.end(), own.keys.begin(), own.keys.end());
  const Members members(value, place, known);
  Objective objective{type, kind.defaults()};
  JsonReader reader(members, place, sums_outside);
  kind.visit_parameters(objective.parameters, reader);
  if (weight != nullptr) members.read("weight", *weight, read_number);
  return objective;
}

class JsonWriter : public ParameterVisitor {
 public:
  JsonWriter(ordered_json& json, Defaults defaults, std::map<std::string_view, double> usual)
      : json_(json), full_(defaults == Defaults::Written), usual_(std::move(usual)) {}

  void number(std::string_view key, double& value, NumberRange /*allowed*/) override {
    if (full_ || value != usual_.at(key)) put(key, value + 0.0);
  }
  void point(std::string_view key, Vector3& value) override {
    if (full_ || value != Vector3{}) put(key, numbers(value));
  }
  void costs_by_size(std::string_view key, std::map<std::size_t, double>& costs) override {
    ordered_json by_size = ordered_json::object();
    for (const auto& [size, value] : costs) {
      if (value != 0) by_size[std::to_string(size)] = value;
    }
    if (full_ || !by_size.empty()) put(key, std::move(by_size));
  }
  void constants(std::string_view key, std::map<std::string, double>& constants) override {
    ordered_json by_name = ordered_json::object();
    for (const auto& [name, value] : constants) by_name[name] = value + 0.0;
    if (full_ || !by_name.empty()) put(key, std::move(by_name));
  }
  void name(std::string_view key, std::string& name) override { put(key, name); }
  void optional_name(std::string_view key, std::optional<std::string>& name) override {
    if (name) {
      put(key, *name);
    } else if (full_) {
      put(key, nullptr);
    }
  }
  void optional_point(std::string_view key, std::optional<Vector3>& value) override {
    if (value) {
      put(key, numbers(*value));
    } else if (full_) {
      put(key, nullptr);
    }
  }
  void changes(std::string_view key, std::vector<ChangeCost>& changes) override {
    ordered_json list = ordered_json::array();
    for (const ChangeCost& change : changes)
      list.push_back({{"from", change.from}, {"to", change.to}, {"cost", change.cost + 0.0}});
    if (full_ || !list.empty()) put(key, std::move(list));
  }
  void formula(std::string_view key, std::string& text, FormulaCompiler& /*compiler*/) override {
    put(key, text);
  }
  void terms(std::string_view key, std::vector<WeightedObjective>& terms) override {
    ordered_json list = ordered_json::array();
    for (const WeightedObjective& term : terms) {
      ordered_json entry = ordered_json::object();
      if (full_ || term.weight != 1) entry["weight"] = term.weight + 0.0;
      entry.update(objective_json(term.objective, full_ ? Defaults::Written : Defaults::LeftOut));
      list.push_back(std::move(entry));
    }
    put(key, std::move(list));
  }

 private:
  void put(std::string_view key, ordered_json value) { json_[std::string(key)] = std::move(value); }

  ordered_json& json_;
  bool full_;
  std::map<std::string_view, double> usual_;
};

}  // namespace

Objective read_objective(JsonValue value, const Place& place) {
  return read_objective(value, place, 0, nullptr);
}

nlohmann::ordered_json objective_json(const Objective& objective, Defaults defaults) {
  const ObjectiveRow* row = objective_row(objective.type);
  ordered_json json = {{"type", objective.type}};
  if (row == nullptr || !row->kind().takes(objective.parameters)) return json;
  if (defaults == Defaults::Written && !row->stated_as.empty()) {
    row = objective_row(row->stated_as);
    json["type"] = row->type;
  }
  const ObjectiveKind& kind = row->kind();
  JsonWriter writer(json, defaults, KeyList(kind).numbers);
  ObjectiveParameters parameters = objective.parameters;
  kind.visit_parameters(parameters, writer);
  return json;
}

bool has_text(const Objective& objective) {
  if (const auto* const sum = std::get_if<WeightedSum>(&objective.parameters)) {
    return std::ranges::all_of(
        sum->terms, [](const WeightedObjective& term) { return has_text(term.objective); });
  }
  const ObjectiveRow* const row = objective_row(objective.type);
  return row != nullptr && row->in_files;
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
