#include "orasp/io/formats/graphml.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/detail/json_text.h"
#include "orasp/io/detail/problem_spec_text.h"
#include "orasp/io/formats/detail/graph_builder.h"
#include "orasp/io/formats/detail/plan_tasks.h"
#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/io/formats/detail/xml_document.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::GraphValue;
using detail::in_quotes;
using detail::local_name;
using pugi::xml_node;

// -------------------------------------------------------------------------------------------------
// reading

/// What <key> elements say: the name and the type of the data with that key.
struct Key {
  std::string name;  ///< empty: graphics, which mean nothing here
  std::string type;
  std::optional<std::string> default_text;
  std::string domain;  ///< "node", "edge", "graph", "all"
};

class GraphmlReader {
 public:
  explicit GraphmlReader(std::string_view text)
      : document_(text), builder_([this](std::size_t mark) { return place(mark); }) {}

  Converted read() {
    const xml_node root = document_.root();
    if (local_name(root) != "graphml") {
      throw InputError(fmt::format("{}: the outermost element of GraphML is <graphml>, not <{}>",
                                   document_.place(root), root.name()));
    }
    xml_node graph;
    for (const xml_node child : root.children()) {
      if (local_name(child) == "key") add_key(child);
      if (local_name(child) != "graph") continue;
      if (graph)
        throw InputError(
            fmt::format("{}: a second <graph>; a problem is made of one", document_.place(child)));
      graph = child;
    }
    if (!graph) throw InputError("there is no <graph> in it");
    read_graph(graph);
    return builder_.finish();
  }

 private:
  /// The place of the element with that mark, its number among those that were marked.
  [[nodiscard]] std::string place(std::size_t mark) const { return document_.place(marked_[mark]); }
  std::size_t mark(xml_node node) {
    marked_.push_back(node);
    return marked_.size() - 1;
  }

  std::string required(xml_node node, const char* attribute) const {
    const pugi::xml_attribute found = node.attribute(attribute);
    if (!found) {
      throw InputError(fmt::format("{}: <{}> has no {}", document_.place(node), node.name(),
                                   in_quotes(attribute)));
    }
    return found.value();
  }

  void add_key(xml_node node) {
    Key key{.name = node.attribute("attr.name").value(),
            .type = node.attribute("attr.type").as_string("string"),
            .default_text = {},
            .domain = node.attribute("for").as_string("all")};
    for (const xml_node child : node.children()) {
      if (local_name(child) == "default") key.default_text = detail::text_in(child);
    }
    keys_[required(node, "id")] = std::move(key);
  }

  /// A value of that type. `node`: where it stands.
  GraphValue value_of(const Key& key, std::string text, xml_node node) const {
    GraphValue value{.name = key.name, .text = std::move(text)};
    if (key.type == "boolean") {
      value.kind = GraphValue::Kind::Flag;
    } else if (key.type != "string") {
      const auto number = detail::number_in(value.text);
      if (!number) {
        throw InputError(fmt::format("{}: {} is not a finite number, which {} is by its key",
                                     document_.place(node), in_quotes(value.text),
                                     in_quotes(key.name)));
      }
      value.kind = GraphValue::Kind::Number;
      value.number = *number;
    }
    return value;
  }

  /// The data of a node, an edge or the graph.
  std::vector<GraphValue> values_of(xml_node owner, std::string_view domain) {
    std::vector<GraphValue> values;
    std::map<std::string, bool> stated;
    for (const xml_node data : owner.children()) {
      const std::string_view kind = local_name(data);
      if (kind == "graph" && domain != "graph") {
        throw InputError(
            fmt::format("{}: a graph inside of a {} is not read; take the groups apart",
                        document_.place(data), domain));
      }
      if (kind == "port")
        builder_.left_out("<port>", "element", "connections join parts, and no places on them");
      if (kind != "data") continue;
      const std::string id = required(data, "key");
      const auto key = keys_.find(id);
      if (key == keys_.end()) {
        throw InputError(fmt::format("{}: there is no <key> with the id {}", document_.place(data),
                                     in_quotes(id)));
      }
      stated[id] = true;
      if (!key->second.name.empty()) {
        values.push_back(value_of(key->second, detail::text_in(data), data));
      } else if (const auto label = label_in(data)) {
        values.push_back({.name = "label", .text = *label});
      }
    }
    for (const auto& [id, key] : keys_) {
      const bool applies = key.domain == "all" || key.domain == domain;
      if (applies && key.default_text && !key.name.empty() && !stated[id])
        values.push_back(value_of(key, *key.default_text, owner));
    }
    return values;
  }

  /// The text of yEd's first label: <y:ShapeNode> ... <y:NodeLabel>lid</y:NodeLabel>.
  static std::optional<std::string> label_in(xml_node data) {
    for (const xml_node graphics : data.children()) {
      for (const xml_node child : graphics.children()) {
        const std::string_view kind = local_name(child);
        if (kind != "NodeLabel" && kind != "EdgeLabel") continue;
        const std::string text = detail::text_in(child);
        const std::string_view plain = detail::trimmed(text);
        if (!plain.empty()) return std::string(plain);
      }
    }
    return std::nullopt;
  }

  void read_graph(xml_node graph) {
    for (const GraphValue& value : values_of(graph, "graph")) builder_.set_graph_value(value);
    bool directed = std::string_view(graph.attribute("edgedefault").value()) == "directed";
    for (const xml_node child : graph.children()) {
      if (local_name(child) == "node")
        builder_.add_part(mark(child), required(child, "id"), values_of(child, "node"));
      if (local_name(child) == "hyperedge") {
        throw InputError(
            fmt::format("{}: a <hyperedge> joins any number of nodes, and a connection "
                        "joins two parts",
                        document_.place(child)));
      }
    }
    for (const xml_node child : graph.children()) {
      if (local_name(child) != "edge") continue;
      if (const auto own = child.attribute("directed")) {
        if (own.as_bool()) directed = true;
      }
      builder_.add_connection(mark(child), child.attribute("id").value(), required(child, "source"),
                              required(child, "target"), values_of(child, "edge"));
    }
    builder_.set_directed(directed);
  }

  detail::XmlDocument document_;
  detail::GraphBuilder builder_;
  std::map<std::string, Key> keys_;
  std::vector<xml_node> marked_;
};

// -------------------------------------------------------------------------------------------------
// writing

/// Writes a graph: the keys stand in front of it, so they are collected first.
class GraphmlWriter {
 public:
  explicit GraphmlWriter(bool directed) {
    xml_node declaration = document_.append_child(pugi::node_declaration);
    declaration.append_attribute("version") = "1.0";
    declaration.append_attribute("encoding") = "UTF-8";
    root_ = document_.append_child("graphml");
    root_.append_attribute("xmlns") = "http://graphml.graphdrawing.org/xmlns";
    graph_ = root_.append_child("graph");
    graph_.append_attribute("edgedefault") = directed ? "directed" : "undirected";
  }

  xml_node node(const std::string& id) {
    xml_node node = graph_.append_child("node");
    node.append_attribute("id") = id.c_str();
    return node;
  }
  xml_node edge(const std::string& from, const std::string& to) {
    xml_node edge = graph_.append_child("edge");
    edge.append_attribute("source") = from.c_str();
    edge.append_attribute("target") = to.c_str();
    return edge;
  }
  [[nodiscard]] xml_node graph() const { return graph_; }

  void number(xml_node owner, const std::string& name, double value) {
    data(owner, name, "double", detail::number_text(value + 0.0));
  }
  void text(xml_node owner, const std::string& name, std::string value) {
    changed_ |= detail::replace_control_characters(value);
    data(owner, name, "string", value);
  }
  void point(xml_node owner, const Vector3& point) {
    number(owner, "x", point[0]);
    number(owner, "y", point[1]);
    number(owner, "z", point[2]);
  }

  Written finish() {
    Written written{.text = detail::xml_text(document_)};
    if (changed_) {
      written.notes.emplace_back(
          "control characters, which XML cannot hold, are written as question marks");
    }
    return written;
  }

 private:
  void data(xml_node owner, const std::string& name, const char* type, const std::string& text) {
    const std::string domain = owner.name();
    std::string& key = keys_[{domain, name}];
    if (key.empty()) {
      key = fmt::format("d{}", keys_.size() - 1);
      xml_node declared = root_.insert_child_before("key", graph_);
      declared.append_attribute("id") = key.c_str();
      declared.append_attribute("for") = domain.c_str();
      declared.append_attribute("attr.name") = name.c_str();
      declared.append_attribute("attr.type") = type;
    }
    xml_node data = owner.append_child("data");
    data.append_attribute("key") = key.c_str();
    data.text().set(text.c_str());
  }

  pugi::xml_document document_;
  xml_node root_;
  xml_node graph_;
  std::map<std::pair<std::string, std::string>, std::string> keys_;
  bool changed_ = false;
};

[[noreturn]] void refuse_name(const std::string& name, const std::string& thing) {
  throw InputError(fmt::format("graphml cannot carry the name {} of {}, which is that of a key",
                               in_quotes(name), thing));
}

void write_part(const Part& part, GraphmlWriter& writer) {
  const xml_node node = writer.node(part.id);
  if (!part.name.empty()) writer.text(node, "name", part.name);
  if (part.mass != Part{}.mass) writer.number(node, "mass", part.mass);
  if (part.position) writer.point(node, *part.position);
  for (const auto& [name, number] : part.numbers) {
    if (detail::means_something_at_node(name))
      refuse_name(name, "a number of the part " + in_quotes(part.id));
    writer.number(node, name, number);
  }
}

void write_connection(const Connection& connection, GraphmlWriter& writer) {
  xml_node edge = writer.edge(connection.parts[0], connection.parts[1]);
  edge.append_attribute("id") = connection.id.c_str();
  const std::string thing = "the connection " + in_quotes(connection.id);
  if (connection.duration != Connection{}.duration)
    writer.number(edge, "duration", connection.duration);
  if (connection.success != Connection{}.success)
    writer.number(edge, "success", connection.success);
  if (!connection.axis.empty()) writer.text(edge, "axis", connection.axis);
  if (connection.position) writer.point(edge, *connection.position);
  if (connection.on_failure.abort) writer.number(edge, "abort", *connection.on_failure.abort);
  if (!connection.on_failure.breaks.empty())
    writer.text(edge, "breaks", detail::inline_text(connection.on_failure.breaks));
  for (const auto& [name, number] : connection.numbers) {
    if (detail::means_something_at_edge(name)) refuse_name(name, "a number of " + thing);
    writer.number(edge, name, number);
  }
  for (const auto& [name, text] : connection.attributes) {
    if (detail::means_something_at_edge(name)) refuse_name(name, "an attribute of " + thing);
    writer.text(edge, name, text);
  }
}

/// A name that is a number here and a word there would need two keys of one name.
void require_one_meaning(const ProblemSpec& spec) {
  std::map<std::string, std::string> of_numbers;
  for (const Connection& connection : spec.connections)
    for (const auto& [name, number] : connection.numbers) of_numbers.emplace(name, connection.id);
  for (const Connection& connection : spec.connections) {
    for (const auto& [name, text] : connection.attributes) {
      if (!of_numbers.contains(name)) continue;
      throw InputError(fmt::format(
          "graphml cannot carry {} both as a number of the connection {} and as an attribute of {}",
          in_quotes(name), in_quotes(of_numbers[name]), in_quotes(connection.id)));
    }
  }
}

/// What the nodes and edges have no place for; empty if there is nothing.
std::string rest_of(const ProblemSpec& spec) {
  ProblemSpec rest = spec;
  rest.parts.clear();
  rest.connections.clear();
  rest.name.clear();
  std::string text = detail::problem_spec_text(rest);
  return text == detail::problem_spec_text(ProblemSpec{}) ? std::string() : text;
}

std::string joined(const std::vector<std::string>& ids) {
  return fmt::format("{}", fmt::join(ids, ", "));
}

}  // namespace

Converted read_graphml(std::string_view text) {
  return GraphmlReader(text).read();
}

Written write_graphml(const WriteRequest& request) {
  const ProblemSpec& spec = request.problem.spec();
  require_one_meaning(spec);
  GraphmlWriter writer(false);
  if (!spec.name.empty()) writer.text(writer.graph(), "name", spec.name);
  if (const std::string rest = rest_of(spec); !rest.empty())
    writer.text(writer.graph(), std::string(detail::kRestName), rest);
  for (const Part& part : spec.parts) write_part(part, writer);
  for (const Connection& connection : spec.connections) write_connection(connection, writer);
  return writer.finish();
}

Written write_order_graphml(const WriteRequest& request) {
  const Problem& problem = request.problem;
  const std::vector<Step>& steps = request.plan->steps;
  std::vector<std::string> notes;
  const std::vector<OrderedPair> order = detail::step_order(request, notes);
  GraphmlWriter writer(true);
  if (!problem.name().empty()) writer.text(writer.graph(), "name", problem.name());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const xml_node node = writer.node(std::to_string(i + 1));
    writer.text(node, "connections", joined(detail::connection_ids(problem, steps[i])));
    writer.number(node, "duration", detail::step_duration(problem, steps[i]));
  }
  for (const auto& [early, late] : order)
    writer.edge(std::to_string(early + 1), std::to_string(late + 1));
  Written written = writer.finish();
  for (std::string& note : notes) written.notes.push_back(std::move(note));
  return written;
}

}  // namespace orasp
