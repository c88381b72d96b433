#pragma once

#include <string_view>

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// Node-link JSON, as networkx writes it (node_link_data): "nodes" with an "id" are parts, "links",
/// or "edges" as newer versions call them, with "source" and "target" are connections. Values mean
/// what they mean in GraphML (io/formats/graphml.h).
/// @throws InputError with the place of the first fault: nodes[3].
[[nodiscard]] Converted read_node_link(std::string_view text);

}  // namespace orasp
