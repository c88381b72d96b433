#include "orasp/io/formats/node_link.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/detail/json_document.h"
#include "orasp/io/formats/detail/graph_builder.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::GraphValue;
using detail::in_quotes;
using detail::JsonKind;
using detail::JsonValue;

/// The array of edges may have either name.
constexpr std::string_view kLinks = "links";
constexpr std::string_view kEdges = "edges";

std::optional<Vector3> point_at(JsonValue value) {
  if (!value.is(JsonKind::Array) || value.size() != 3) return std::nullopt;
  Vector3 point{};
  std::size_t i = 0;
  bool numbers = true;
  value.for_each([&](JsonValue element) {
    numbers &= element.is(JsonKind::Number);
    if (numbers) point[i++] = element.number();
  });
  return numbers ? std::optional(point) : std::nullopt;
}

/// What stands there; nothing where it is null.
std::optional<GraphValue> value_at(JsonValue member) {
  GraphValue value{.name = std::string(member.key())};
  switch (member.kind()) {
    case JsonKind::Null: return std::nullopt;
    case JsonKind::Boolean:
      value.kind = GraphValue::Kind::Flag;
      value.text = member.boolean() ? "true" : "false";
      break;
    case JsonKind::Number:
      value.kind = GraphValue::Kind::Number;
      value.number = member.number();
      value.text = detail::number_text(value.number);
      break;
    case JsonKind::String: value.text = member.string(); break;
    case JsonKind::Array:
    case JsonKind::Object:
      value.kind = GraphValue::Kind::Other;
      value.text = member.description();
      if (const auto point = point_at(member)) {
        value.kind = GraphValue::Kind::Point;
        value.point = *point;
      }
  }
  return value;
}

class NodeLinkReader {
 public:
  explicit NodeLinkReader(std::string_view text)
      : document_(detail::JsonDocument::parse(text)), builder_([this](std::size_t mark) {
          return mark < nodes_ ? fmt::format("nodes[{}]", mark)
                               : fmt::format("{}[{}]", links_name_, mark - nodes_);
        }) {}

  Converted read() {
    std::optional<JsonValue> nodes;
    std::optional<JsonValue> links;
    require_object(document_.root(), "the file");
    document_.root().for_each([&](JsonValue member) {
      const std::string_view key = member.key();
      if (key == "nodes") nodes = member;
      if (key == kLinks || key == kEdges) {
        if (links)
          throw InputError(R"("links" and "edges" both stand there; one of them is needed)");
        links = member;
        links_name_ = key;
      }
      if (key == "directed" && member.is(JsonKind::Boolean))
        builder_.set_directed(member.boolean());
      if (key == "graph" && member.is(JsonKind::Object)) {
        member.for_each([&](JsonValue value) {
          if (const auto read = value_at(value)) builder_.set_graph_value(*read);
        });
      }
    });
    require_array(nodes, "nodes");
    require_array(links, links_name_.empty() ? R"("links" or "edges")" : links_name_);
    nodes_ = nodes->size();
    std::size_t mark = 0;
    nodes->for_each([&](JsonValue node) { read_node(node, mark++); });
    links->for_each([&](JsonValue link) { read_link(link, mark++); });
    return builder_.finish();
  }

 private:
  [[nodiscard]] std::string place(std::size_t mark) const {
    return mark < nodes_ ? fmt::format("nodes[{}]", mark)
                         : fmt::format("{}[{}]", links_name_, mark - nodes_);
  }

  static void require_object(JsonValue value, const std::string& place) {
    if (!value.is(JsonKind::Object))
      throw InputError(fmt::format("{}: expected an object, found {}", place, value.description()));
  }
  static void require_array(const std::optional<JsonValue>& value, std::string_view name) {
    if (!value) {
      throw InputError(fmt::format("the key {} is missing",
                                   name.starts_with('"') ? std::string(name) : in_quotes(name)));
    }
    if (!value->is(JsonKind::Array)) {
      throw InputError(fmt::format("{}: expected an array, found {}", name, value->description()));
    }
  }

  /// An id, which is a string or a whole number.
  [[nodiscard]] std::string id_of(const std::optional<JsonValue>& value, std::string_view key,
                                  std::size_t mark) const {
    if (!value) throw InputError(fmt::format("{}: the key \"{}\" is missing", place(mark), key));
    if (value->is(JsonKind::String)) return std::string(value->string());
    if (value->is(JsonKind::Number) && value->number() == std::floor(value->number()) &&
        std::abs(value->number()) < 1e15)
      return fmt::format("{:.0f}", value->number());
    throw InputError(
        fmt::format("{}.{}: expected an id, which is a string or a whole number, found "
                    "{}",
                    place(mark), key, value->description()));
  }

  void read_node(JsonValue node, std::size_t mark) {
    require_object(node, place(mark));
    std::optional<JsonValue> id;
    std::vector<GraphValue> values;
    node.for_each([&](JsonValue member) {
      if (member.key() == "id") {
        id = member;
      } else if (auto value = value_at(member)) {
        values.push_back(std::move(*value));
      }
    });
    builder_.add_part(mark, id_of(id, "id", mark), values);
  }

  void read_link(JsonValue link, std::size_t mark) {
    require_object(link, place(mark));
    std::optional<JsonValue> source;
    std::optional<JsonValue> target;
    std::vector<GraphValue> values;
    link.for_each([&](JsonValue member) {
      if (member.key() == "source") {
        source = member;
      } else if (member.key() == "target") {
        target = member;
      } else if (member.key() != "key") {  // tells parallel edges of a multigraph apart
        if (auto value = value_at(member)) values.push_back(std::move(*value));
      }
    });
    builder_.add_connection(mark, "", id_of(source, "source", mark), id_of(target, "target", mark),
                            values);
  }

  detail::JsonDocument document_;
  detail::GraphBuilder builder_;
  std::size_t nodes_ = 0;
  std::string links_name_;
};

}  // namespace

Converted read_node_link(std::string_view text) {
  return NodeLinkReader(text).read();
}

}  // namespace orasp
