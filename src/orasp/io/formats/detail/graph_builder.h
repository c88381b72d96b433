#pragma once

#include <compare>
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "orasp/io/formats/conversion.h"
#include "orasp/model/vector3.h"

namespace orasp::detail {

/// A value that a node, an edge or a graph has by name.
struct GraphValue {
  enum class Kind { Number, Text, Flag, Point, Other };
  std::string name{};
  Kind kind = Kind::Text;
  double number = 0;
  std::string text{};
  Vector3 point{};
};

/// The names that mean something at a node and at an edge; all others are the user's own.
[[nodiscard]] bool means_something_at_node(std::string_view name);
[[nodiscard]] bool means_something_at_edge(std::string_view name);

/// The name under which a graph carries what nodes and edges have no place for: a problem without
/// parts and connections, as the text of a problem file.
inline constexpr std::string_view kRestName = "orasp";

/// Makes a problem of a graph: nodes are parts, edges are connections. Known names (mass, position,
/// duration, ...) go where they belong, other numbers into `numbers`, other words of edges into
/// `attributes`; what has no place is said in a note.
class GraphBuilder {
 public:
  /// `place_of` says where the node or edge with that mark stands in the file: `line 12`.
  explicit GraphBuilder(std::function<std::string(std::size_t)> place_of)
      : place_of_(std::move(place_of)) {}

  /// @throws InputError where the id is taken or a value does not fit.
  void add_part(std::size_t mark, std::string id, const std::vector<GraphValue>& values);
  /// `file_id` is the edge's id in the file, which counts if no two edges share one; empty: none.
  void add_connection(std::size_t mark, std::string file_id, const std::string& from,
                      const std::string& to, const std::vector<GraphValue>& values);
  void set_graph_value(const GraphValue& value);
  void set_directed(bool directed) { directed_ = directed; }
  /// Notes that something is left out, and of how many things: `what is left out (3 parts): why`.
  void left_out(const std::string& what, const std::string& noun, const std::string& why);

  /// @throws InputError where the rest of the problem is not one.
  [[nodiscard]] Converted finish();

 private:
  void give_ids();
  void drop_bad_names();
  [[nodiscard]] double number_of(const GraphValue& value, std::size_t mark,
                                 const std::string& thing) const;
  [[nodiscard]] Vector3 point_of(const GraphValue& value, std::size_t mark,
                                 const std::string& thing) const;

  std::function<std::string(std::size_t)> place_of_;
  std::vector<Part> parts_;
  std::vector<Connection> connections_;
  std::vector<std::size_t> marks_;     ///< of parts
  std::vector<std::string> file_ids_;  ///< of connections
  std::unordered_map<std::string, std::size_t> part_by_id_;
  struct LeftOut {
    std::string what;
    std::string noun;
    std::string why;
    friend auto operator<=>(const LeftOut&, const LeftOut&) = default;
  };
  std::map<LeftOut, std::size_t> left_out_;  ///< and how often
  std::string name_;
  std::string rest_;
  bool directed_ = false;
};

}  // namespace orasp::detail
