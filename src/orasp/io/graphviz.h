#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "orasp/model/problem.h"
#include "orasp/planners/state_graph.h"

namespace orasp {

/// The largest H that is written in the DOT language, and the largest that is drawn: beyond them
/// the text runs to hundreds of megabytes, and nobody can read the picture.
inline constexpr std::uint64_t kMaxDotStates = 200'000;
inline constexpr std::uint64_t kMaxDrawnStates = 5'000;

/// H in the DOT language, top to bottom, one rank a layer; the actions of `highlighted_path`
/// (connections from the start on; may be empty) and their states in green, dead ends in red. A
/// state is named by the connections present in it where that is short, else by their number. In
/// larger graphs the names go first from the actions, then from the states; an SVG viewer still
/// shows them under the pointer.
/// @throws InputError above kMaxDotStates, or if the path is not one of H.
[[nodiscard]] std::string state_graph_dot(const StateGraph& graph,
                                          std::span<const ConnectionIndex> highlighted_path = {});

/// The assembly graph G in the DOT language: a node a part, an edge a connection.
[[nodiscard]] std::string assembly_dot(const Problem& problem);

/// @throws InputError if H has more than kMaxDrawnStates states.
void require_drawable(const StateGraph& graph);

/// The picture that Graphviz's `dot` makes of a text in the DOT language. Runs the program in a
/// process of its own, without a shell. @throws InputError if `dot` is missing (the sentence names
/// the Debian package) or fails.
[[nodiscard]] std::string svg_text(std::string_view dot);

/// svg_text into a file, written whole or not at all. @throws InputError.
void write_svg(std::string_view dot, const std::filesystem::path& file);

}  // namespace orasp
