#include "orasp/graph/state_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/graph_size.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/error.h"
#include "orasp/model/scenario_generators.h"
#include "tests/instances.h"

namespace orasp {
namespace {

// sandwich(): see the drawing. 5 states, 4 actions, one dead end; the plan is 1-2 (0), 2-3
// (-0.2215), 1-3 (1).
TEST(StateGraph, HoldsTheStatesOfTheSandwich) {
  const Problem problem(instances::sandwich());
  const TransitionSystem system(problem);
  const StateGraph graph = StateGraph::build(system, Budget{});
  EXPECT_EQ(graph.num_states(), 5U);
  EXPECT_EQ(graph.num_actions(), 4U);
  EXPECT_EQ(graph.num_layers(), 4U);
  ASSERT_TRUE(graph.goal().has_value());
  EXPECT_EQ(count(graph.state(*graph.goal())), 0U);
  EXPECT_EQ(graph.greatest_reward(), 1);
  std::multiset<double> rewards;
  for (ActionId a = 0; a < graph.num_actions(); ++a)
    rewards.insert(std::round(graph.reward(a) * 1e4));
  EXPECT_EQ(rewards, (std::multiset<double>{-2215, 0, 0, 10000}));
  const GraphSize size = graph_size(graph);
  EXPECT_EQ(size.dead_ends, 1U);
  EXPECT_EQ(size.sequences, "1");
  EXPECT_EQ(size.tree_nodes, "5");
}

TEST(StateGraph, HasNoGoalWhereNoPathReachesIt) {
  const Problem problem(instances::boxed_in());
  const TransitionSystem system(problem);
  const StateGraph graph = StateGraph::build(system, Budget{});
  EXPECT_EQ(graph.num_states(), 1U);
  EXPECT_EQ(graph.num_actions(), 0U);
  EXPECT_FALSE(graph.goal().has_value());
  EXPECT_EQ(graph.greatest_reward(), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(graph_size(graph).sequences, "0");
  EXPECT_EQ(graph_size(graph).dead_ends, 1U);
}

TEST(StateGraph, OfNothingIsOneStateWhichIsTheGoal) {
  for (const ProblemSpec& spec : {instances::nothing(), instances::one_part()}) {
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const StateGraph graph = StateGraph::build(system, Budget{});
    EXPECT_EQ(graph.num_states(), 1U);
    EXPECT_EQ(graph.goal(), 0U);
    EXPECT_EQ(graph_size(graph).sequences, "1");
    EXPECT_EQ(graph_size(graph).tree_nodes, "1");
    EXPECT_EQ(graph_size(graph).dead_ends, 0U);
  }
}

/// Every state, row and reward of two graphs.
void expect_same_graph(const StateGraph& one, const StateGraph& other) {
  ASSERT_EQ(one.num_states(), other.num_states());
  ASSERT_EQ(one.num_actions(), other.num_actions());
  ASSERT_EQ(one.num_layers(), other.num_layers());
  for (StateId s = 0; s < one.num_states(); ++s) {
    ASSERT_TRUE(std::ranges::equal(one.state(s), other.state(s))) << s;
    ASSERT_EQ(one.begin(s), other.begin(s));
  }
  for (ActionId a = 0; a < one.num_actions(); ++a) {
    ASSERT_EQ(one.successor(a), other.successor(a)) << a;
    ASSERT_EQ(one.connection(a), other.connection(a)) << a;
    ASSERT_EQ(one.reward(a), other.reward(a)) << a;
  }
}

/// A grid of 2 x 6 parts with its 16 connections free, behind `fillers` more of part 1 to itself
/// that must go before them, one after the other: layers of up to 12,870 states whose keys are few
/// among all sets of their size.
ProblemSpec grid_behind(std::size_t fillers) {
  ProblemSpec spec = grid(2, 6);
  const auto id = [](std::size_t i) { return "f" + std::to_string(i); };
  for (const Connection& connection : spec.connections) {
    spec.precedence.push_back(
        {connection.parts[0] + "-" + connection.parts[1], {id(fillers - 1)}, {}});
  }
  std::vector<Connection> in_front(fillers);
  for (std::size_t i = 0; i < fillers; ++i) {
    in_front[i].id = id(i);
    in_front[i].parts = {"1", "1"};
    if (i > 0) spec.precedence.push_back({id(i), {id(i - 1)}, {}});
  }
  spec.connections.insert(spec.connections.begin(), in_front.begin(), in_front.end());
  return spec;
}

/// Each state of a layer stands once, and each action leads to its state less its connection.
void expect_sound(const StateGraph& graph) {
  const std::size_t connections = graph.system().num_connections();
  std::set<ConnectionSet> met;
  for (StateId s = 0; s < graph.num_states(); ++s) {
    ConnectionSet state(connections, graph.state(s));
    ASSERT_TRUE(met.insert(state).second) << s;
    for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
      const ConnectionIndex c = graph.connection(a);
      ASSERT_TRUE(state.contains(c));
      state.erase(c);
      ASSERT_TRUE(std::ranges::equal(state.view(), graph.state(graph.successor(a)))) << a;
      state.insert(c);
    }
  }
}

// A key of one word and of two, found by hashing: 2^16 states and one for each filler, 16 * 2^15
// actions and as many.
TEST(StateGraph, HasTheStatesOfTheGridBehindFillers) {
  for (const std::size_t fillers : {40U, 60U}) {
    const Problem problem(grid_behind(fillers));
    const TransitionSystem system(problem);
    EXPECT_EQ(system.words(), fillers == 40 ? 1U : 2U);
    const StateGraph graph = StateGraph::build(system, Budget{});
    EXPECT_EQ(graph.num_states(), 65'536 + fillers);
    EXPECT_EQ(graph.num_actions(), 524'288 + fillers);
    expect_sound(graph);
  }
}

// Layers of more than 10,000 states (smaller ones are not shared out), in one word and in two,
// under limits and without, with few different rewards and with many.
TEST(StateGraph, IsTheSameForAnyNumberOfThreads) {
  ProblemSpec spec = grid(3, 4);  // 17 connections
  for (std::size_t p = 0; p < spec.parts.size(); ++p)
    spec.parts[p].mass = 1 + 0.37 * static_cast<double>(p);
  spec.limits.max_moved_parts = 4;
  spec.precedence = {{"1-2", {"11-12"}, {}}};
  for (const ProblemSpec& base : {spec, grid_behind(40), grid_behind(60)}) {
    for (const char* objective : {"cubesat", "fuel"}) {
      const Problem problem = Problem(base).with_objective(Objective::named(objective));
      const TransitionSystem system(problem);
      const StateGraph one = StateGraph::build(system, Budget{});
      for (const unsigned threads : {2U, 3U, 8U}) {
        Budget budget;
        budget.threads = threads;
        expect_same_graph(one, StateGraph::build(system, budget));
      }
    }
  }
}

/// A number that differs between most steps of a large problem.
double fingerprint(const Step& step) {
  double sum = static_cast<double>(step.connection) + 1e-3 * static_cast<double>(step.before);
  for (const PartIndex part : step.a) sum += std::pow(1.31, part);
  for (const PartIndex part : step.b) sum -= std::pow(1.57, part);
  return sum;
}

// Rewards are kept in 1 byte an action while they take at most 256 values, in 2 up to 65,536, in 8
// beyond: all three, and every one must be what the Expander says, in order.
TEST(StateGraph, HoldsEveryRewardHoweverManyDifferentOnesThereAre) {
  ProblemSpec spec = grid(3, 4);  // 17 connections, 131,072 states, 1,114,112 actions
  for (std::size_t c = 0; c < 17; ++c)
    spec.connections[c].duration = 1 + 0.37 * static_cast<double>(c);
  const auto check = [&spec](Objective objective, std::size_t least, std::size_t most,
                             unsigned threads) {
    spec.objective = std::move(objective);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    Budget budget;
    budget.threads = threads;
    const StateGraph graph = StateGraph::build(system, budget);
    ASSERT_EQ(graph.num_states(), 131'072U);
    Expander expander(system);
    std::vector<double> different;
    for (StateId s = 0; s < graph.num_states(); ++s) {
      const auto actions = expander.legal_actions(graph.state(s));
      ASSERT_EQ(actions.size(), graph.end(s) - graph.begin(s));
      for (std::size_t i = 0; i < actions.size(); ++i) {
        ASSERT_EQ(graph.connection(graph.begin(s) + i), actions[i].connection);
        ASSERT_EQ(graph.reward(graph.begin(s) + i), actions[i].reward);
        different.push_back(actions[i].reward);
      }
    }
    std::ranges::sort(different);
    EXPECT_EQ(graph.greatest_reward(), different.back());
    const auto repeats = std::ranges::unique(different);
    different.erase(repeats.begin(), repeats.end());
    EXPECT_GE(different.size(), least);
    EXPECT_LE(different.size(), most);
  };
  check(Objective::named("cubesat"), 2, 256, 1);
  check({"time", TimeObjective{.depot = {0.3, 7, 1}, .speed = 0.7}}, 257, 65'536, 2);
  check({"callable", Callable{.name = "fingerprint", .reward = fingerprint}}, 65'537, 2'000'000, 2);
}

// A reward that is not a number in a layer that several threads share.
TEST(StateGraph, AnErrorInAThreadReachesTheCaller) {
  ProblemSpec spec = load_scenario("hubble-upc").spec();
  spec.objective = {"callable",
                    Callable{.name = "bad", .reward = [](const Step& step) {
                               return step.before == 9 && step.connection == 3 ? std::nan("") : 0.0;
                             }}};
  const Problem problem(spec);
  const TransitionSystem system(problem);
  for (const unsigned threads : {1U, 2U, 4U}) {
    Budget budget;
    budget.threads = threads;
    EXPECT_THROW((void)StateGraph::build(system, budget), InputError);
  }
}

TEST(StateGraph, RowsAscendByConnectionAndLayersByWhatIsHandled) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  const StateGraph graph = StateGraph::build(system, Budget{});
  EXPECT_EQ(graph.layer_begin(0), 0U);
  for (std::size_t k = 0; k < graph.num_layers(); ++k) {
    for (StateId s = graph.layer_begin(k); s < graph.layer_end(k); ++s) {
      EXPECT_EQ(count(graph.state(s)), 12 - k);
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
        EXPECT_TRUE(a == graph.begin(s) || graph.connection(a - 1) < graph.connection(a));
        EXPECT_GE(graph.successor(a), graph.layer_begin(k + 1));
        EXPECT_LT(graph.successor(a), graph.layer_end(k + 1));
      }
    }
  }
}

// Whole layers only: the states held of a graph that was stopped are those of the first layers.
TEST(StateGraph, StoppedEarlyHoldsWholeLayers) {
  const Problem problem = load_scenario("hubble");
  const TransitionSystem system(problem);
  const StateGraph whole = StateGraph::build(system, Budget{});
  Budget budget;
  budget.max_bytes = 100'000;
  const StateGraph part = StateGraph::build(system, budget);
  EXPECT_EQ(part.stop(), Stop::MemoryLimit);
  ASSERT_LT(part.num_layers(), whole.num_layers());
  EXPECT_LT(part.num_states(), whole.num_states());
  EXPECT_FALSE(part.goal().has_value());
  for (std::size_t k = 0; k < part.num_layers(); ++k)
    EXPECT_EQ(part.layer_end(k), whole.layer_end(k));
  for (StateId s = 0; s < part.num_states(); ++s) {
    for (ActionId a = part.begin(s); a < part.end(s); ++a)
      EXPECT_LT(part.successor(a), part.num_states());
  }
}

TEST(StateGraph, HoldsAtMost16BytesAStateAnd6AnAction) {
  const Problem problem = load_scenario("hubble-free");
  const TransitionSystem system(problem);
  const StateGraph graph = StateGraph::build(system, Budget{});
  const double allowed = 16.0 * static_cast<double>(graph.num_states()) +
                         6.0 * static_cast<double>(graph.num_actions());
  EXPECT_LE(static_cast<double>(graph.bytes()), 1.001 * allowed);
  EXPECT_GE(graph.peak_bytes(), graph.bytes());
}

// Unconstrained: exactly 2^E and E 2^(E-1), without building it.
TEST(GraphEstimate, IsExactWithoutConstraints) {
  const Problem problem(chain(40));
  const GraphEstimate estimate = estimate_graph(TransitionSystem(problem));
  EXPECT_TRUE(estimate.exact);
  EXPECT_DOUBLE_EQ(estimate.states, std::exp2(39));
  EXPECT_DOUBLE_EQ(estimate.actions, 39 * std::exp2(38));
}

TEST(GraphEstimate, IsOfTheRightOrderUnderConstraints) {
  for (const char* name : {"2x3", "lattice", "hubble", "hubble-upc"}) {
    const Problem problem = load_scenario(name);
    const TransitionSystem system(problem);
    const GraphEstimate estimate = estimate_graph(system);
    const StateGraph graph = StateGraph::build(system, Budget{});
    const double ratio = estimate.states / static_cast<double>(graph.num_states());
    EXPECT_GT(ratio, 1 / 3.0) << name;
    EXPECT_LT(ratio, 3.0) << name;
  }
}

TEST(GraphObstacle, GivesTheEstimate) {
  const Problem problem(chain(500));
  const auto reason = graph_obstacle(TransitionSystem(problem), Budget{});
  ASSERT_TRUE(reason);
  for (const char* word : {"states", "actions", "of memory", "are allowed"})
    EXPECT_NE(reason->find(word), std::string::npos) << *reason;
  const Problem largest(chain(16000));
  EXPECT_NE(graph_obstacle(TransitionSystem(largest), Budget{})
                ->find("more than 1e308 states and more than 1e308 actions, more than 1e308 GiB"),
            std::string::npos);
  const Problem small = load_scenario("hubble");
  EXPECT_FALSE(graph_obstacle(TransitionSystem(small), Budget{}));
  Budget tiny;
  tiny.max_bytes = 10'000;
  EXPECT_TRUE(graph_obstacle(TransitionSystem(small), tiny));
}

// -------------------------------------------------------------------------------------------------

/// `lines` rows of `length` connections each of part 1 to itself; within a row they go in order. A
/// state says how far each row is, so (length + 1)^lines states, and the sequences are the ways to
/// merge the rows: the multinomial number.
Problem rows_in_order(std::size_t lines, std::size_t length) {
  ProblemSpec spec = instances::one_part();
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t i = 0; i < length; ++i) {
      Connection connection;
      connection.id = std::to_string(line) + "." + std::to_string(i);
      connection.parts = {"1", "1"};
      if (i > 0)
        spec.precedence.push_back(
            {connection.id, {std::to_string(line) + "." + std::to_string(i - 1)}, {}});
      spec.connections.push_back(connection);
    }
  }
  return Problem(spec);
}

std::string sequences_of(const Problem& problem) {
  const TransitionSystem system(problem);
  return graph_size(StateGraph::build(system, Budget{})).sequences;
}

// 20 connections fit 64 bits, 34 fit 128, beyond that numbers of any size.
TEST(GraphSize, CountsSequencesBeyondEveryMachineWord) {
  EXPECT_EQ(sequences_of(rows_in_order(2, 10)), "184756");                 // 20! / (10!)^2
  EXPECT_EQ(sequences_of(rows_in_order(3, 7)), "399072960");               // 21! / (7!)^3
  EXPECT_EQ(sequences_of(rows_in_order(2, 17)), "2333606220");             // 34! / (17!)^2
  EXPECT_EQ(sequences_of(rows_in_order(6, 5)), "88832646059788350720");    // 30! / (5!)^6 > 2^64
  EXPECT_EQ(sequences_of(rows_in_order(5, 7)), "3177459078523411968000");  // 35! / (7!)^5
  // 90! / (30!)^3 > 2^128
  EXPECT_EQ(sequences_of(rows_in_order(3, 30)), "79607789567531236214574346454361782651136");
}

}  // namespace
}  // namespace orasp
