// Numbers of optimal sequences and the best plans, against all sequences by the oracle.

#include "orasp/explain/alternatives.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/graph/graph_size.h"
#include "orasp/io/scenarios.h"
#include "orasp/planners/value_iteration.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using Sequence = std::vector<ConnectionIndex>;

/// Every plan with its reward, one after another.
std::map<Sequence, double> all_plans(const ProblemSpec& spec) {
  const oracle::World world(spec);
  std::map<Sequence, double> plans;
  if (world.start_infeasible()) return plans;
  std::map<oracle::State, std::vector<oracle::Facts>> legal;
  Sequence sequence;
  const std::function<void(oracle::State&, double)> extend = [&](oracle::State& state,
                                                                 double reward) {
    if (sequence.size() == state.size()) {
      plans[sequence] = reward;
      return;
    }
    auto found = legal.find(state);
    if (found == legal.end()) found = legal.emplace(state, world.legal_facts(state)).first;
    for (const oracle::Facts& facts : found->second) {
      state[facts.connection] = false;
      sequence.push_back(static_cast<ConnectionIndex>(facts.connection));
      extend(state, reward + facts.reward);
      sequence.pop_back();
      state[facts.connection] = true;
    }
  };
  oracle::State start = world.start();
  extend(start, 0);
  return plans;
}

TEST(Alternatives, AreAllPlansInOrderOfRewardAndTheOptimalOnesAreCounted) {
  std::size_t problems = 0, without_plan = 0, ties = 0, several_rewards = 0;
  for (std::uint64_t seed = 0; seed < some_of(900U); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const oracle::OracleResult truth = oracle::brute_force(spec);
    if (truth.sequences > 2000) continue;
    ++problems;
    const std::map<Sequence, double> plans = all_plans(spec);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const Alternatives found = find_alternatives(system, true, plans.size() + 3, Budget{});
    ASSERT_EQ(found.stop, Stop::None);
    ASSERT_TRUE(found.optimal_sequences && found.plans);
    const double tolerance = 1e-9 * std::max(1.0, truth.feasible ? std::abs(truth.best) : 1.0);
    const auto optimal = std::ranges::count_if(
        plans, [&](const auto& plan) { return plan.second >= truth.best - tolerance; });
    EXPECT_EQ(*found.optimal_sequences, std::to_string(optimal));
    without_plan += plans.empty() ? 1 : 0;
    ties += optimal > 1 ? 1 : 0;
    several_rewards += static_cast<std::size_t>(optimal) < plans.size() ? 1 : 0;

    ASSERT_EQ(found.plans->size(), plans.size());
    std::set<Sequence> distinct;
    for (std::size_t i = 0; i < found.plans->size(); ++i) {
      const Alternative& plan = (*found.plans)[i];
      ASSERT_TRUE(plans.contains(plan.sequence));
      EXPECT_NEAR(plan.reward, plans.at(plan.sequence), reward_tolerance(plan.reward));
      EXPECT_TRUE(distinct.insert(plan.sequence).second);
      if (i > 0) {
        EXPECT_LE(plan.reward, (*found.plans)[i - 1].reward + tolerance);
      }
    }
    // Fewer are the first of them, though only as many departures are kept.
    for (const std::uint64_t most : {1U, 2U, 7U}) {
      const Alternatives few = find_alternatives(system, false, most, Budget{});
      EXPECT_FALSE(few.optimal_sequences);
      ASSERT_EQ(few.plans->size(), std::min<std::size_t>(most, plans.size()));
      for (std::size_t i = 0; i < few.plans->size(); ++i)
        EXPECT_EQ((*few.plans)[i].sequence, (*found.plans)[i].sequence);
    }
    if (truth.feasible) {
      EXPECT_EQ(found.plans->front().sequence, value_iteration(system, {}, Budget{}).sequence);
    }
    if (HasFailure()) return;
  }
  EXPECT_GE(problems, more_than(600U));
  EXPECT_GE(without_plan, more_than(50U));
  EXPECT_GE(ties, more_than(200U));
  EXPECT_GE(several_rewards, more_than(200U));
}

// Where all rewards are equal every sequence is optimal.
TEST(Alternatives, AreCountedBeyondEveryMachineWord) {
  for (const char* name : {"lattice", "hubble", "hubble-upc", "hubble-free"}) {
    SCOPED_TRACE(name);
    CompletionObjective nothing{.join = 0, .step = 0, .bonus = 0};
    const Problem problem = load_scenario(name).with_objective(Objective("completion", nothing));
    const TransitionSystem system(problem);
    const StateGraph graph = StateGraph::build(system, Budget{});
    const std::vector<double> values = value_iteration(graph, {}, Budget{}).values;
    EXPECT_EQ(count_optimal(graph, values), graph_size(graph).sequences);
  }
  // Connections of a part to itself in groups, one group after the other: (size!)^groups, past 64
  // bits, and with 40 connections past what is counted in 128.
  struct Case {
    int groups;
    int size;
    const char* sequences;
  };
  for (const Case& groups :
       {Case{3, 11, "63601470092869632000000"}, Case{5, 8, "106562062388507443200000"}}) {
    ProblemSpec spec = instances::assembly(1, {});
    for (int i = 0; i < groups.groups * groups.size; ++i) {
      Connection connection;
      connection.id = "c" + std::to_string(i);
      connection.parts = {"1", "1"};
      spec.connections.push_back(connection);
      Precedence entry{connection.id, {}, {}};
      for (int c = i / groups.size * groups.size - groups.size;
           c >= 0 && c < i / groups.size * groups.size; ++c)
        entry.after.push_back("c" + std::to_string(c));
      if (!entry.after.empty()) spec.precedence.push_back(entry);
    }
    const Problem problem(spec);
    EXPECT_EQ(find_alternatives(TransitionSystem(problem), true, 0, Budget{}).optimal_sequences,
              groups.sequences);
  }
}

//   1 - 2 - 3 - 4: the middle first, then either end, 0.5570; the four that begin at an end,
//   0.5450.
TEST(Alternatives, OfARowOfFour) {
  const Problem problem(instances::greedy_trap());
  const Alternatives found = find_alternatives(TransitionSystem(problem), true, 10, Budget{});
  EXPECT_EQ(found.optimal_sequences, "2");
  ASSERT_EQ(found.plans->size(), 6U);
  EXPECT_EQ((*found.plans)[0].sequence, (Sequence{1, 0, 2}));
  EXPECT_EQ((*found.plans)[1].sequence, (Sequence{1, 2, 0}));
  EXPECT_NEAR((*found.plans)[1].reward, 0.5570, 1e-12);
  for (std::size_t i = 2; i < 6; ++i) EXPECT_NEAR((*found.plans)[i].reward, 0.5450, 1e-12);
}

// Rewards of a billion, whose sums differ in their last digits only: rounding is no difference. A
// thousandth is one.
TEST(Alternatives, TellRoundingFromLosses) {
  ProblemSpec spec = instances::assembly(6, {{1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 6}});
  for (std::size_t i = 0; i < 5; ++i)
    spec.connections[i].duration = 1e9 / 3 + static_cast<double>(i) * 0.1;
  spec.objective = Objective("time", TimeObjective{.depot = {0, 0, 0}, .speed = 1, .transfer = 0});
  const Problem problem(spec);
  EXPECT_EQ(find_alternatives(TransitionSystem(problem), true, 0, Budget{}).optimal_sequences,
            "120");
}

TEST(Alternatives, OfTheEmptyProblemIsTheEmptyPlan) {
  const Problem problem(instances::nothing());
  const Alternatives found = find_alternatives(TransitionSystem(problem), true, 5, Budget{});
  EXPECT_EQ(found.optimal_sequences, "1");
  ASSERT_EQ(found.plans->size(), 1U);
  EXPECT_TRUE(found.plans->front().sequence.empty());
}

TEST(Alternatives, SayWhatStoppedThem) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  Budget stopped;
  std::stop_source source;
  stopped.stop = source.get_token();
  source.request_stop();
  const Alternatives nothing = find_alternatives(system, true, 5, stopped);
  EXPECT_EQ(stop_name(nothing.stop), "interrupted");
  EXPECT_FALSE(nothing.optimal_sequences);
  EXPECT_FALSE(nothing.plans);

  const StateGraph graph = StateGraph::build(system, Budget{});
  const std::vector<double> values = value_iteration(graph, {}, Budget{}).values;
  Budget little;
  little.max_bytes = graph.bytes() + 50'000;
  const Alternatives some = best_plans(graph, values, 100'000, little);
  EXPECT_EQ(stop_name(some.stop), "memory limit");
  EXPECT_GT(some.plans->size(), 1U);
  EXPECT_LT(some.plans->size(), 100'000U);
  const Alternatives many = best_plans(graph, values, 100'000, Budget{});
  EXPECT_EQ(many.plans->size(), 100'000U);
}

}  // namespace
}  // namespace orasp
