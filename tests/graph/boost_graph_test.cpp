// H handed to the Boost Graph Library: its shortest paths are another oracle for dijkstra and
// bellman-ford, on graphs too large for tests/oracle.h.

#include <limits>
#include <utility>
#include <vector>

#include <boost/graph/bellman_ford_shortest_paths.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/dijkstra_shortest_paths.hpp>
#include <gtest/gtest.h>

#include "orasp/graph/state_graph.h"
#include "orasp/io/scenarios.h"
#include "orasp/planners/bellman_ford.h"
#include "orasp/planners/dijkstra.h"
#include "orasp/planners/value_iteration.h"
#include "tests/checks.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

struct Length {
  double length = 0;
};
using BoostGraph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, Length>;

/// H with the length shift - reward on every action.
BoostGraph lengths(const StateGraph& graph, double shift) {
  std::vector<std::pair<StateId, StateId>> edges;
  std::vector<Length> properties;
  for (StateId s = 0; s < graph.num_states(); ++s) {
    for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
      edges.emplace_back(s, graph.successor(a));
      properties.push_back({shift - graph.reward(a)});
    }
  }
  return {boost::edges_are_sorted, edges.begin(), edges.end(), properties.begin(),
          graph.num_states()};
}

/// Named parameters of both algorithms: where the distances go and what an edge measures.
auto parameters(const BoostGraph& graph, std::vector<double>& distance) {
  return boost::distance_map(
             boost::make_iterator_property_map(distance.begin(), get(boost::vertex_index, graph)))
      .weight_map(get(&Length::length, graph));
}

void expect_same_paths(const Problem& problem) {
  const TransitionSystem system(problem);
  if (system.infeasibility()) return;
  const StateGraph graph = StateGraph::build(system, Budget{});

  // Bellman-Ford takes rewards of both signs as they are.
  const BoostGraph plain = lengths(graph, 0);
  std::vector<double> distance(graph.num_states(), std::numeric_limits<double>::max());
  distance[0] = 0;
  ASSERT_TRUE(boost::bellman_ford_shortest_paths(plain, static_cast<int>(graph.num_states()),
                                                 parameters(plain, distance)));
  const Result all = bellman_ford(graph, {}, Budget{});
  ASSERT_EQ(all.values.size(), graph.num_states());
  for (StateId s = 0; s < graph.num_states(); ++s) {
    EXPECT_NEAR(all.values[s], -distance[s], reward_tolerance(all.values[s]));
  }

  // Dijkstra on lengths made non-negative by a constant an action.
  const Result result = dijkstra(graph, Budget{});
  EXPECT_EQ(result.has_plan(), graph.goal().has_value());
  if (!graph.goal() || graph.num_actions() == 0) return;
  const double shift = graph.greatest_reward();
  const BoostGraph shifted = lengths(graph, shift);
  std::vector<double> length(graph.num_states());
  boost::dijkstra_shortest_paths(shifted, StateId{0}, parameters(shifted, length));
  const double best =
      static_cast<double>(problem.num_connections()) * shift - length[*graph.goal()];
  EXPECT_NEAR(result.reward, best, 1e-8 * std::max(1.0, std::abs(shift)));
  EXPECT_NEAR(all.reward, best, 1e-8 * std::max(1.0, std::abs(shift)));
}

TEST(BoostGraphLibrary, AgreesOnTheScenarios) {
  for (const char* name : {"2x3", "lattice", "hubble"}) {
    for (const char* objective : {"cubesat", "indexed", "completion", "fuel"}) {
      SCOPED_TRACE(std::string(name) + ", " + objective);
      expect_same_paths(load_scenario(name).with_objective(Objective::named(objective)));
    }
  }
}

TEST(BoostGraphLibrary, AgreesOnTheLatticeInAssembly) {
  const Problem problem = load_scenario("lattice").with_direction(Direction::Assembly);
  for (const char* objective : {"cubesat", "indexed"}) {
    expect_same_paths(problem.with_objective(Objective::named(objective)));
  }
}

TEST(BoostGraphLibrary, AgreesOnRandomProblems) {
  for (std::uint64_t seed = 5000; seed < 5000 + some_of(200U); ++seed) {
    SCOPED_TRACE(seed);
    expect_same_paths(Problem(random_problem(seed)));
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace orasp
