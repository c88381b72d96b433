#include "orasp/graph/state_index.h"

#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "orasp/model/scenario_generators.h"
#include "tests/instances.h"
#include "tests/random_problems.h"

namespace orasp {
namespace {

/// Every state is found, and the table is from a quarter to half full.
void expect_finds_all(const StateGraph& graph) {
  const StateIndex index(graph);
  for (StateId s = 0; s < graph.num_states(); ++s) {
    ASSERT_EQ(index.find(graph.state(s)), std::optional<StateId>(s));
  }
  EXPECT_GE(index.bytes(), 8 * graph.num_states());
  EXPECT_LT(index.bytes(), 16 * graph.num_states());
}

TEST(StateIndex, FindsJustTheStatesAmongAllSets) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Problem problem(seed < 260 ? random_problem(seed) : larger_random_problem(seed));
    SCOPED_TRACE(problem.name());
    const TransitionSystem system(problem);
    const StateGraph graph = StateGraph::build(system, Budget{});
    expect_finds_all(graph);
    const StateIndex index(graph);
    std::uint64_t found = 0;
    for (std::uint64_t set = 0; set >> problem.num_connections() == 0; ++set) {
      const auto state = index.find({&set, 1});
      if (!state) continue;
      ++found;
      ASSERT_EQ(graph.state(*state).front(), set);
    }
    EXPECT_EQ(found, graph.num_states());
  }
}

TEST(StateIndex, FindsStatesOfSeveralWords) {
  ProblemSpec spec = chain(100);
  for (std::size_t c = 2; c < 99; ++c) {  // all but the last in order
    spec.precedence.push_back({std::to_string(c) + "-" + std::to_string(c + 1),
                               {std::to_string(c - 1) + "-" + std::to_string(c)},
                               {}});
  }
  const Problem problem(spec);
  const TransitionSystem system(problem);
  ASSERT_EQ(system.words(), 2U);
  const StateGraph graph = StateGraph::build(system, Budget{});
  ASSERT_GT(graph.num_states(), 100U);
  expect_finds_all(graph);
  const StateIndex index(graph);
  ConnectionSet set = system.start();
  set.erase(50);
  EXPECT_EQ(index.find(set.view()), std::nullopt);
}

TEST(StateIndex, StaysValidWhereTheGraphMoves) {
  const Problem problem = load_scenario("hubble");
  const TransitionSystem system(problem);
  StateGraph built = StateGraph::build(system, Budget{});
  const StateIndex index(built);
  const StateGraph graph = std::move(built);
  for (StateId s = 0; s < graph.num_states(); ++s) ASSERT_EQ(index.find(graph.state(s)), s);
}

}  // namespace
}  // namespace orasp
