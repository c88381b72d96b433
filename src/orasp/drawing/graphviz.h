#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/graph/state_graph.h"
#include "orasp/model/problem.h"

namespace orasp {

/// The largest H that is written in the DOT language, and the largest that is drawn: beyond them
/// the text runs to hundreds of megabytes, and nobody can read the picture.
inline constexpr std::uint64_t kMaxDotStates = 200'000;
inline constexpr std::uint64_t kMaxDrawnStates = 5'000;

/// How state_graph_dot draws.
struct StateGraphStyle {
  /// For a column of a paper: narrow names, on actions the reward alone, states without names
  /// earlier.
  bool compact = false;
  /// Colours of actions, one a connection, from the first again when there are more; empty: grey.
  std::span<const std::string_view> colours;
  /// The graph of the same problem without some constraints, which is then drawn: what the
  /// constraints take from it faint and dashed.
  const StateGraph* whole = nullptr;
};

/// H in the DOT language, top to bottom, one rank a layer; the actions of `highlighted_path`
/// (connections from the start on; may be empty) and their states in green, dead ends in red. A
/// state is named by the connections present in it where that is short, else by their number. In
/// larger graphs the names go first from the actions, then from the states; an SVG viewer still
/// shows them under the pointer.
/// @throws InputError above kMaxDotStates, or if the path is not one of H.
[[nodiscard]] std::string state_graph_dot(const StateGraph& graph,
                                          std::span<const ConnectionIndex> highlighted_path = {},
                                          const StateGraphStyle& style = {});

/// A point of a drawing, in points (1/72 inch), y upwards.
struct Place {
  double x = 0;
  double y = 0;
};

/// How assembly_dot draws.
struct AssemblyStyle {
  /// Colours of connections, one each, from the first again when there are more; empty: grey.
  std::span<const std::string_view> colours;
  /// Where the parts stand; empty: where the problem says they are, if it does, else Graphviz finds
  /// places.
  std::span<const Place> places;
  std::string
      start;  ///< where Graphviz begins its search, its attribute of that name; empty: its default
};

/// The assembly graph G in the DOT language: a node `p0`, `p1`, ... a part, an edge a connection.
/// Up to 60 parts are named; beyond that an SVG viewer shows the names under the pointer.
[[nodiscard]] std::string assembly_dot(const Problem& problem, const AssemblyStyle& style = {});

/// Where Graphviz puts the nodes `p0` to `p(nodes-1)` of a text in the DOT language. @throws
/// InputError as svg_text.
[[nodiscard]] std::vector<Place> places_of(std::string_view dot, std::size_t nodes);

/// @throws InputError if H has more than kMaxDrawnStates states.
void require_drawable(const StateGraph& graph);

/// The picture that Graphviz's `dot` makes of a text in the DOT language. Runs the program in a
/// process of its own, without a shell. @throws InputError if `dot` is missing (the sentence names
/// the Debian package) or fails.
[[nodiscard]] std::string svg_text(std::string_view dot);

/// svg_text into a file, written whole or not at all. @throws InputError.
void write_svg(std::string_view dot, const std::filesystem::path& file);

}  // namespace orasp
