#include "orasp/io/formats/detail/graph_builder.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/problem_spec_text.h"
#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/io/formula_parser.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/formula.h"

namespace orasp::detail {
namespace {

using Kind = GraphValue::Kind;

constexpr auto kNodeNames =
    std::to_array<std::string_view>({"id", "name", "label", "mass", "position", "x", "y", "z"});
constexpr auto kEdgeNames = std::to_array<std::string_view>(
    {"id", "duration", "success", "axis", "position", "x", "y", "z", "breaks", "abort"});

/// Values by name, of which some may be taken out.
class Values {
 public:
  explicit Values(const std::vector<GraphValue>& values) {
    for (const GraphValue& value : values) values_[value.name] = &value;
  }
  const GraphValue* take(std::string_view name) {
    const auto found = values_.find(name);
    if (found == values_.end()) return nullptr;
    const GraphValue* value = found->second;
    values_.erase(found);
    return value;
  }
  /// x, y and z, where all three are numbers.
  std::optional<Vector3> take_coordinates() {
    constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
    Vector3 point{};
    for (std::size_t i = 0; i < kAxes.size(); ++i) {
      const auto found = values_.find(kAxes[i]);
      if (found == values_.end() || found->second->kind != Kind::Number) return std::nullopt;
      point[i] = found->second->number;
    }
    for (const std::string_view axis : kAxes) take(axis);
    return point;
  }
  [[nodiscard]] const std::map<std::string, const GraphValue*, std::less<>>& rest() const {
    return values_;
  }

 private:
  std::map<std::string, const GraphValue*, std::less<>> values_;
};

/// yEd writes its descriptions even where there are none.
bool says_nothing(const GraphValue& value) {
  return value.kind == Kind::Text && value.text.empty();
}

std::string text_of(const GraphValue& value) {
  return value.kind == Kind::Number ? number_text(value.number) : value.text;
}

/// Why a problem cannot have a number or an attribute of that name; nothing where it can. The
/// problem itself is asked, so that the rule stands once.
std::optional<std::string> fault_of_name(const std::string& name, bool is_number, bool of_part) {
  if (is_number) {
    for (const std::string& used : names_in_formulas(name)) {
      if (is_formula_builtin(used))
        return in_quotes(used) + " is a function or a constant of formulas";
    }
  }
  ProblemSpec spec;
  spec.parts = {{.id = "1"}, {.id = "2"}};
  spec.connections = {{.parts = {"1", "2"}}};
  if (of_part) spec.parts[0].numbers[name] = 1;
  if (!of_part && is_number) spec.connections[0].numbers[name] = 1;
  if (!is_number) spec.connections[0].attributes[name] = "1";
  try {
    const Problem problem(std::move(spec));
  } catch (const InputError& error) {
    const std::string_view sentence = error.what();
    return std::string(sentence.substr(std::min(sentence.find(": ") + 2, sentence.size())));
  }
  return std::nullopt;
}

std::vector<std::string> ids_in(std::string_view json) {
  const JsonDocument document = JsonDocument::parse(json);
  if (!document.root().is(JsonKind::Array)) throw InputError("expected an array of ids");
  std::vector<std::string> ids;
  document.root().for_each([&](JsonValue id) {
    if (!id.is(JsonKind::String)) throw InputError("expected an array of ids");
    ids.emplace_back(id.string());
  });
  return ids;
}

}  // namespace

bool means_something_at_node(std::string_view name) {
  return std::ranges::find(kNodeNames, name) != kNodeNames.end();
}

bool means_something_at_edge(std::string_view name) {
  return std::ranges::find(kEdgeNames, name) != kEdgeNames.end();
}

double GraphBuilder::number_of(const GraphValue& value, std::size_t mark,
                               const std::string& thing) const {
  if (value.kind == Kind::Number) return value.number;
  if (value.kind == Kind::Text) {
    if (const auto number = number_in(value.text)) return *number;
  }
  throw InputError(fmt::format("{}: {}: {} is not a number, which {} must be", place_of_(mark),
                               thing, in_quotes(value.text), in_quotes(value.name)));
}

Vector3 GraphBuilder::point_of(const GraphValue& value, std::size_t mark,
                               const std::string& thing) const {
  if (value.kind == Kind::Point) return value.point;
  if (value.kind == Kind::Text) {
    if (const auto point = point_in(value.text)) return *point;
  }
  throw InputError(fmt::format("{}: {}: {} is not a position, which is three numbers, x, y and z",
                               place_of_(mark), thing, in_quotes(text_of(value))));
}

void GraphBuilder::left_out(const std::string& what, const std::string& noun,
                            const std::string& why) {
  ++left_out_[{what, noun, why}];
}

void GraphBuilder::add_part(std::size_t mark, std::string id,
                            const std::vector<GraphValue>& given) {
  if (parts_.size() == kMaxParts) {
    throw InputError(
        fmt::format("more than {} nodes, the most parts that a problem may have", kMaxParts));
  }
  const std::string thing = "node " + in_quotes(id);
  const auto [known, is_new] = part_by_id_.emplace(id, parts_.size());
  if (!is_new) {
    throw InputError(fmt::format("{}: {} is there already, at {}", place_of_(mark), thing,
                                 place_of_(marks_[known->second])));
  }
  if (const auto fault = id_fault(id))
    throw InputError(fmt::format("{}: {}: the id {}", place_of_(mark), thing, *fault));
  Part part{.id = std::move(id)};
  Values values(given);
  values.take("id");
  const GraphValue* name = values.take("name");
  if (name == nullptr) name = values.take("label");
  if (name != nullptr) part.name = text_of(*name);
  if (const GraphValue* mass = values.take("mass")) part.mass = number_of(*mass, mark, thing);
  if (const GraphValue* position = values.take("position")) {
    part.position = point_of(*position, mark, thing);
  } else {
    part.position = values.take_coordinates();
  }
  for (const auto& [own, value] : values.rest()) {
    if (value->kind == Kind::Number) {
      part.numbers[own] = value->number;
    } else if (!says_nothing(*value)) {
      left_out(in_quotes(own), "part", "parts have numbers of their own, but no words");
    }
  }
  parts_.push_back(std::move(part));
  marks_.push_back(mark);
}

void GraphBuilder::add_connection(std::size_t mark, std::string file_id, const std::string& from,
                                  const std::string& to, const std::vector<GraphValue>& given) {
  if (connections_.size() == kMaxConnections) {
    throw InputError(fmt::format("more than {} edges, the most connections that a problem may have",
                                 kMaxConnections));
  }
  const std::string thing = fmt::format("edge {}", connections_.size() + 1);
  for (const std::string& end : {from, to}) {
    if (!part_by_id_.contains(end)) {
      throw InputError(
          fmt::format("{}: {}: there is no node {}", place_of_(mark), thing, in_quotes(end)));
    }
  }
  Connection connection{.parts = {from, to}};
  Values values(given);
  if (const GraphValue* id = values.take("id")) {
    connection.id = text_of(*id);
    if (const auto fault = id_fault(connection.id))
      throw InputError(fmt::format("{}: {}: the id {}", place_of_(mark), thing, *fault));
    file_id.clear();
  }
  if (const GraphValue* duration = values.take("duration"))
    connection.duration = number_of(*duration, mark, thing);
  if (const GraphValue* success = values.take("success"))
    connection.success = number_of(*success, mark, thing);
  if (const GraphValue* axis = values.take("axis")) connection.axis = text_of(*axis);
  if (const GraphValue* position = values.take("position")) {
    connection.position = point_of(*position, mark, thing);
  } else {
    connection.position = values.take_coordinates();
  }
  if (const GraphValue* abort = values.take("abort"))
    connection.on_failure.abort = number_of(*abort, mark, thing);
  if (const GraphValue* breaks = values.take("breaks")) {
    try {
      connection.on_failure.breaks = ids_in(breaks->text);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}: breaks: {}", place_of_(mark), thing, error.what()));
    }
  }
  for (const auto& [own, value] : values.rest()) {
    switch (value->kind) {
      case Kind::Number: connection.numbers[own] = value->number; break;
      case Kind::Text: connection.attributes[own] = value->text; break;
      case Kind::Flag: connection.attributes[own] = value->text; break;
      case Kind::Point:
      case Kind::Other: left_out(in_quotes(own), "connection", "it is neither a number nor a word");
    }
  }
  connections_.push_back(std::move(connection));
  file_ids_.push_back(std::move(file_id));
}

void GraphBuilder::set_graph_value(const GraphValue& value) {
  if (says_nothing(value)) return;
  if (value.name == "name" || value.name == "label") {
    name_ = text_of(value);
  } else if (value.name == kRestName && value.kind == Kind::Text) {
    rest_ = value.text;
  } else if (value.name != "node_default" && value.name != "edge_default") {
    left_out(in_quotes(value.name), "graph", "a problem has no values of its own");
  }
}

/// The ids of the file where no two edges share one; else "a-b", and "a-b 2" where there is one.
void GraphBuilder::give_ids() {
  std::unordered_set<std::string> ids;
  bool unique = true;
  for (const std::string& id : file_ids_) {
    if (!id.empty() && !ids.insert(id).second) unique = false;
  }
  std::unordered_set<std::string> taken;
  for (std::size_t i = 0; i < connections_.size(); ++i) {
    if (unique && !id_fault(file_ids_[i]) && connections_[i].id.empty())
      connections_[i].id = file_ids_[i];
    if (!connections_[i].id.empty()) taken.insert(connections_[i].id);
  }
  for (Connection& connection : connections_) {
    if (!connection.id.empty()) continue;
    const std::string id = connection.parts[0] + "-" + connection.parts[1];
    connection.id = id;
    for (std::size_t number = 2; !taken.insert(connection.id).second; ++number)
      connection.id = fmt::format("{} {}", id, number);
  }
}

void GraphBuilder::drop_bad_names() {
  std::map<std::string, std::optional<std::string>> known;
  const auto fault = [&known](const std::string& name, bool is_number, bool of_part) {
    const std::string key = fmt::format("{}{}{}", is_number, of_part, name);
    const auto found = known.find(key);
    if (found != known.end()) return found->second;
    return known.emplace(key, fault_of_name(name, is_number, of_part)).first->second;
  };
  for (Part& part : parts_) {
    std::erase_if(part.numbers, [&](const auto& own) {
      const auto why = fault(own.first, true, true);
      if (why) left_out(in_quotes(own.first), "part", *why);
      return why.has_value();
    });
  }
  for (Connection& connection : connections_) {
    std::erase_if(connection.numbers, [&](const auto& own) {
      const auto why = fault(own.first, true, false);
      if (why) left_out(in_quotes(own.first), "connection", *why);
      return why.has_value();
    });
    std::erase_if(connection.attributes, [&](const auto& own) {
      const auto why = fault(own.first, false, false);
      if (why) left_out(in_quotes(own.first), "connection", *why);
      return why.has_value();
    });
  }
}

Converted GraphBuilder::finish() {
  if (parts_.empty()) throw InputError("the graph has no nodes, so there are no parts");
  give_ids();
  drop_bad_names();
  Converted converted;
  if (!rest_.empty()) {
    try {
      converted.problem = parse_problem_spec(rest_);
      if (!converted.problem.parts.empty() || !converted.problem.connections.empty())
        throw InputError("parts and connections are the nodes and edges, and do not stand here");
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("the value {} of the graph: {}", in_quotes(kRestName), error.what()));
    }
  }
  if (!name_.empty()) converted.problem.name = name_;
  converted.problem.parts = std::move(parts_);
  converted.problem.connections = std::move(connections_);
  if (directed_) {
    converted.notes.emplace_back(
        "the graph is directed, and connections are not: which part stands first in one is kept, "
        "no order of work is read from it");
  }
  for (const auto& [left, count] : left_out_) {
    converted.notes.push_back(fmt::format("{} is left out ({} {}{}): {}", left.what, count,
                                          left.noun, count == 1 ? "" : "s", left.why));
  }
  return converted;
}

}  // namespace orasp::detail
