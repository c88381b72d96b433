#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "orasp/model/transition_system.h"
#include "orasp/symmetry/automorphisms.h"

namespace orasp {

/// A problem as a coloured graph. Its automorphisms exchange parts and connections so that nothing
/// that the problem states tells the two apart: which steps are legal, where they lead, and what
/// they earn.
///
/// Vertices. First the parts, then the connections, in the order of the file. A connection is
///           joined to its parts. Clauses of precedence and pairs of parts of which one blocks the
///           other have vertices of their own.
/// Colours.  All that the problem says of a part or connection, but for ids, names and positions:
///           mass, numbers, whether it is in the base; duration, success, numbers, attributes, and
///           whether it is still to be handled.
/// Blocking. Directions are vertices as well, joined to the pairs that are blocked in them, and may
///           be exchanged, as they are where the product is turned or reflected: a step is legal
///           where some direction is free, whichever it is. Of more than 64 directions each stays
///           what it is.
/// Off.      The list of what is known is explicit: a member of the problem's types that it does
///           not name is an error of compilation, an objective that it does not name a reason
///           against all symmetry. So are objectives that look at positions or at the order of the
///           file, functions of the user, formulas that see the masses or numbers of pieces (two
///           pieces that weigh the same up to rounding are told apart by the order of the file),
///           steps that take several connections, goals, and work in a set order.
struct ProblemGraph {
  ColouredGraph graph{};
  /// Why nothing is known of the symmetry, a clause that goes on from the name of a method; then
  /// the graph is empty.
  std::optional<std::string> obstacle{};

  [[nodiscard]] static std::uint32_t vertex_of_connection(const Problem& problem,
                                                          ConnectionIndex connection) {
    return static_cast<std::uint32_t>(problem.num_parts()) + connection;
  }
};

/// O(what the problem states), with logarithms.
[[nodiscard]] ProblemGraph problem_graph(const TransitionSystem& system);

}  // namespace orasp
