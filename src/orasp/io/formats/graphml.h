#pragma once

#include <string_view>

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// GraphML (Brandes, Eiglsperger, Herman, Himsolt and Marshall (2002), GraphML progress report,
/// Graph Drawing, LNCS 2265), as networkx and yEd write it: a node is a part, an edge a connection.
/// What nodes and edges have no place for stands in the graph's value "orasp", so that a problem
/// comes back as it went, with the same digest. docs/convert.md says what each key means.
/// @throws InputError with the line of the first fault.
[[nodiscard]] Converted read_graphml(std::string_view text);

/// @throws InputError where a number or an attribute of the user has the name of a key.
[[nodiscard]] Written write_graphml(const WriteRequest& request);

/// What keeps a plan legal (explain/plan_order.h), as a directed graph: a node is a step, an edge
/// leads to a step that must come later.
[[nodiscard]] Written write_order_graphml(const WriteRequest& request);

}  // namespace orasp
