#include "orasp/bounds/piece_bound.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "orasp/orasp.h"
#include "orasp/planners/planner_support.h"
#include "tests/instances.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// Best reward to come of every state of H, by value iteration.
std::vector<double> true_values(const StateGraph& graph) {
  return value_iteration(graph, {}, {}).values;
}

TEST(PieceBound, IsNeverBelowATrueValueOfARandomProblem) {
  std::size_t problems = 0;
  std::size_t states = 0;
  for (std::uint64_t seed = 5000; seed < 5000 + some_of(600U); ++seed) {
    ProblemSpec spec = random_problem(seed);
    spec.direction = Direction::Disassembly;
    const Problem problem(spec);
    const TransitionSystem system(problem);
    PieceBound bound(system, PieceBound::Kind::Sizes);
    if (!bound.known() || system.infeasibility()) continue;
    ++problems;
    const StateGraph graph = StateGraph::build(system, {});
    const std::vector<double> values = true_values(graph);
    for (StateId s = 0; s < graph.num_states(); ++s) {
      ASSERT_GE(bound(graph.state(s)), values[s] - 1e-9) << spec.name << ", state " << s;
      ++states;
    }
  }
  EXPECT_GE(problems, least_of(40U));
  EXPECT_GE(states, least_of(1000U));
}

// The change of the bound that add_change tells is the difference of two bounds, but for the last
// step.
TEST(PieceBound, TellsTheChangeOfEveryAction) {
  for (const char* name : {"2x3", "lattice", "4piece"}) {
    const Problem problem = load_scenario(name);
    const TransitionSystem system(problem);
    PieceBound bound(system, PieceBound::Kind::Sizes);
    ASSERT_TRUE(bound.known());
    Expander expander(system);
    const StateGraph graph = StateGraph::build(system, {});
    for (StateId s = 0; s < graph.num_states(); ++s) {
      if (count(graph.state(s)) < 2) continue;
      const auto legal = expander.legal_actions(graph.state(s));
      std::vector<Action> scored(legal.begin(), legal.end());
      bound.add_change(graph.state(s), scored);
      ConnectionSet next(problem.num_connections(), graph.state(s));
      for (std::size_t i = 0; i < legal.size(); ++i) {
        next.erase(legal[i].connection);
        EXPECT_NEAR(scored[i].reward, legal[i].reward + bound(next.view()) - bound(graph.state(s)),
                    1e-12);
        EXPECT_LE(scored[i].reward, 1e-12) << "consistent";
        next.insert(legal[i].connection);
      }
    }
  }
}

// g(2) = -2 * 0.0967, g(3) = -0.0967 - 0.1248 + g(2), g(4) = max(-0.0967 - 0.1368 + g(3), -2 *
// 0.1248 + 2 g(2)).
TEST(PieceBound, IsTheRecursionOverSizes) {
  const Problem problem = load_scenario("4brick");
  const TransitionSystem system(problem);
  PieceBound bound(system, PieceBound::Kind::Sizes);
  const double g2 = -2 * 0.0967;
  const double g3 = -0.0967 - 0.1248 + g2;
  const double g4 = std::max(-0.0967 - 0.1368 + g3, -2 * 0.1248 + 2 * g2);
  EXPECT_NEAR(bound(system.start().view()), g4 - g2 + 1,
              1e-12);  // the last step earns 1 instead of its cost
}

TEST(PieceBound, SaysNothingWhereTheObjectiveSeesMoreThanThePiece) {
  const Problem indexed = load_scenario("lattice").with_objective(Objective::named("indexed"));
  const Problem forward = load_scenario("lattice").with_direction(Direction::Assembly);
  for (const Problem& problem : {indexed, forward}) {
    const TransitionSystem system(problem);
    PieceBound bound(system, PieceBound::Kind::Both);
    EXPECT_FALSE(bound.known());
    EXPECT_EQ(bound(system.start().view()), std::numeric_limits<double>::infinity());
  }
}

// Four parts in a row at 0, 1, 2 and 3 m from the depot, each a second's work; the first is too
// heavy to move, so it is what stays: 3 s and the ways of the others, 2 (1 + 2 + 3) m, whatever the
// order.
TEST(PieceBound, WhatIsTooHeavyToMoveStays) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  for (std::size_t i = 0; i < 4; ++i)
    spec.parts[i].position = Vector3{static_cast<double>(i), 0, 0};
  spec.parts[0].mass = 100;
  spec.objective = Objective::named("time");
  spec.limits = {.max_moved_parts = 1, .max_moved_mass = 10};
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    spec.direction = direction;
    const Problem problem(spec);
    const Result plan = solve(problem, "auto");
    EXPECT_EQ(plan.status, Status::Optimal);
    EXPECT_NEAR(plan.reward, -15, 1e-12);
    EXPECT_NEAR(detail::bound_of_start(TransitionSystem(problem)).value(), -15, 1e-12);
  }
}

}  // namespace
}  // namespace orasp
