#pragma once

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// The language of Graphviz. A problem is an undirected graph: parts are nodes named by their ids,
/// connections are edges with their ids as labels. The order of a plan (explain/plan_order.h) is a
/// directed one: a node is a step, an edge leads to a step that must come later. What a problem
/// says beside is left out.
[[nodiscard]] Written write_dot(const WriteRequest& request);
[[nodiscard]] Written write_order_dot(const WriteRequest& request);

}  // namespace orasp
