#include "orasp/planners/value_iteration.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "tests/instances.h"

namespace orasp {
namespace {

using Order = ValueIterationOptions::Order;

/// lattice: 12 connections, 1,296 states, best 0.0735.
class ValueIterationOnLattice : public testing::Test {
 protected:
  const Problem problem_ = load_scenario("lattice");
  const TransitionSystem system_{problem_};
  const StateGraph graph_ = StateGraph::build(system_, Budget{});
};

TEST_F(ValueIterationOnLattice, LayersNeedOneSweepAndOneToConfirm) {
  const Result result = value_iteration(graph_, {}, Budget{});
  EXPECT_EQ(status_name(result.status), "optimal");
  EXPECT_NEAR(result.reward, 0.0735, 1e-9);
  EXPECT_EQ(result.statistics.sweeps, 2U);
}

TEST_F(ValueIterationOnLattice, BothOrdersEndAtTheSameValues) {
  const Result layers = value_iteration(graph_, {}, Budget{});
  const Result textbook = value_iteration(graph_, {.order = Order::Textbook}, Budget{});
  EXPECT_EQ(status_name(textbook.status), "optimal");
  EXPECT_EQ(layers.values, textbook.values);
  EXPECT_EQ(layers.sequence, textbook.sequence);
  EXPECT_GT(textbook.statistics.sweeps, 2U);
  EXPECT_LE(textbook.statistics.sweeps, 13U);  // connections + 1
}

TEST_F(ValueIterationOnLattice, InitialValuesDoNotMatterInTheEnd) {
  const Result from_zero = value_iteration(graph_, {}, Budget{});
  for (const double initial : {2.0, -1000.0, 1e6}) {
    for (const Order order : {Order::Layers, Order::Textbook}) {
      const Result result =
          value_iteration(graph_, {.order = order, .initial_value = initial}, Budget{});
      EXPECT_EQ(status_name(result.status), "optimal");
      EXPECT_EQ(result.values, from_zero.values);
      EXPECT_EQ(result.sequence, from_zero.sequence);
    }
  }
}

// From V_0 = 0 the textbook order knows after k sweeps the best of k steps: right for the last k
// layers, and it takes 12 for the start.
TEST_F(ValueIterationOnLattice, TextbookOrderStoppedEarlyIsNotOptimal) {
  for (std::uint64_t sweeps = 1; sweeps <= 11; ++sweeps) {
    const Result result =
        value_iteration(graph_, {.order = Order::Textbook, .max_sweeps = sweeps}, Budget{});
    EXPECT_EQ(status_name(result.status), "feasible") << sweeps;
    EXPECT_EQ(result.statistics.sweeps, sweeps);
    EXPECT_LE(result.reward, 0.0735 + 1e-9);
    if (result.bound) {
      EXPECT_GE(*result.bound, 0.0735 - 1e-9);
    }
    const StateId last_layers = graph_.layer_begin(graph_.num_layers() - 1 - sweeps);
    const Result all = value_iteration(graph_, {}, Budget{});
    for (StateId s = last_layers; s < graph_.num_states(); ++s)
      EXPECT_EQ(result.values[s], all.values[s]);
  }
}

// In layer order one sweep is right already.
TEST_F(ValueIterationOnLattice, OneSweepInLayerOrderIsAProof) {
  const Result result = value_iteration(graph_, {.initial_value = 7, .max_sweeps = 1}, Budget{});
  EXPECT_EQ(status_name(result.status), "optimal");
  EXPECT_NEAR(result.reward, 0.0735, 1e-9);
}

// With an epsilon above every change the textbook order stops after one sweep, without proof.
TEST_F(ValueIterationOnLattice, AWideEpsilonIsNotAProof) {
  const Result result =
      value_iteration(graph_, {.order = Order::Textbook, .epsilon = 1e9}, Budget{});
  EXPECT_EQ(result.statistics.sweeps, 1U);
  EXPECT_EQ(status_name(result.status), "feasible");
}

// V of each state is the best over its actions, V of the goal 0, of dead ends and what leads to
// them only -infinity.
TEST(ValueIteration, ValuesSatisfyBellmansEquation) {
  const Problem problem(instances::sandwich());
  const TransitionSystem system(problem);
  const StateGraph graph = StateGraph::build(system, Budget{});
  for (const Order order : {Order::Layers, Order::Textbook}) {
    const Result result = value_iteration(graph, {.order = order}, Budget{});
    ASSERT_EQ(result.values.size(), 5U);
    std::size_t dead = 0;
    for (StateId s = 0; s < graph.num_states(); ++s) {
      double best = graph.goal() == s ? 0 : -std::numeric_limits<double>::infinity();
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
        best = std::max(best, graph.reward(a) + result.values[graph.successor(a)]);
      }
      EXPECT_EQ(result.values[s], best);
      if (std::isinf(best)) ++dead;
    }
    EXPECT_EQ(dead, 1U);
  }
}

}  // namespace
}  // namespace orasp
