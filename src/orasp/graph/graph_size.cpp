#include "orasp/graph/graph_size.h"

#include <boost/multiprecision/cpp_int.hpp>

namespace orasp {

namespace {

using BigInt = boost::multiprecision::cpp_int;

/// Paths from the start to each state, summed over all states and at the goal. No state has more
/// than (connections)! paths, so `Count` must hold that.
template <class Count>
void count_paths(const StateGraph& graph, GraphSize& size) {
  std::vector<Count> paths(graph.num_states(), Count(0));
  BigInt nodes = 0;
  paths[0] = 1;
  for (StateId s = 0; s < graph.num_states(); ++s) {
    nodes += BigInt(paths[s]);
    for (ActionId a = graph.begin(s); a < graph.end(s); ++a) paths[graph.successor(a)] += paths[s];
  }
  size.tree_nodes = nodes.str();
  const auto goal = graph.goal();
  size.sequences = goal ? BigInt(paths[*goal]).str() : "0";
}

}  // namespace

GraphSize graph_size(const StateGraph& graph) {
  GraphSize size;
  size.states = graph.num_states();
  size.actions = graph.num_actions();
  const auto goal = graph.goal();
  for (std::size_t k = 0; k < graph.num_layers(); ++k) {
    const StateId begin = graph.layer_begin(k);
    const StateId end = graph.layer_end(k);
    size.layers.push_back(
        {end - begin, end == begin ? 0 : graph.end(end - 1) - graph.begin(begin)});
    for (StateId s = begin; s < end; ++s) {
      if (graph.begin(s) == graph.end(s) && goal != s) ++size.dead_ends;
    }
  }
  constexpr std::size_t kMost64 = 20;   // 20! < 2^64
  constexpr std::size_t kMost128 = 34;  // 34! < 2^128
  const std::size_t connections = graph.system().num_steps();
  if (graph.system().wide()) {
    count_paths<BigInt>(graph, size);  // a step may be made in several ways
  } else if (connections <= kMost64) {
    count_paths<std::uint64_t>(graph, size);
  } else if (connections <= kMost128) {
    count_paths<boost::multiprecision::uint128_t>(graph, size);
  } else {
    count_paths<BigInt>(graph, size);
  }
  return size;
}

}  // namespace orasp
