// 07: the state-action graph. Every order of work is a path from "all connections are there" to
// "none is". The tree of all orders repeats a state for each order that reaches it; the graph H
// holds each state once, and that is why a best plan can be found at all.
#include <iostream>

#include "orasp/orasp.h"

int main() {
  const orasp::Problem problem = orasp::load_scenario("lattice");
  const orasp::TransitionSystem system(problem);
  const orasp::StateGraph graph = orasp::StateGraph::build(system, {});

  const orasp::GraphSize size = orasp::graph_size(graph);
  std::cout << size.states << " states and " << size.actions << " actions stand for "
            << size.sequences << " orders, a tree of " << size.tree_nodes << " nodes\n";
  std::cout << size.dead_ends << " states are dead ends\n";
  for (std::size_t layer = 0; layer < size.layers.size(); ++layer) {
    std::cout << "  " << layer << " removed: " << size.layers[layer].states << " states, "
              << size.layers[layer].actions << " actions\n";
  }

  // The graph can be planned on again and again. Bellman-Ford finds the best reward from the start
  // to every state; the goal is the state in which no connection is left.
  const orasp::Result result = orasp::bellman_ford(graph, {}, {});
  std::cout << "best reward to the goal: " << result.values[*graph.goal()] << '\n';

  // What can be done first, and what each first step earns.
  for (orasp::ActionId action = graph.begin(0); action < graph.end(0); ++action) {
    std::cout << "  " << problem.connection_id(graph.connection(action)) << ' '
              << graph.reward(action) << '\n';
  }
}
