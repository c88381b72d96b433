// Objectives that are functions of the user: of one step (StateGraph's and the oracle's tests use
// them all over), and of many steps at once.

#include "orasp/model/objectives/callable.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

double of_one(const Step& step) {
  return -3.0 * static_cast<double>(step.before) - (step.separates ? 0.5 : 0) +
         (step.completes ? 7 : 0) - 0.25 * static_cast<double>(step.moved().size()) -
         0.125 * static_cast<double>(step.subassemblies) - 0.01 * step.connection;
}

const std::vector<double>& column(const StepTable& steps, const std::string& name) {
  for (std::size_t i = 0; i < steps.names.size(); ++i) {
    if (steps.names[i] == name) return steps.columns[i];
  }
  throw std::logic_error("no column " + name);
}

void of_many(const StepTable& steps, std::span<double> rewards) {
  for (std::size_t i = 0; i < rewards.size(); ++i) {
    rewards[i] = -3.0 * column(steps, "before")[i] - 0.5 * column(steps, "separates")[i] +
                 7 * column(steps, "completes")[i] - 0.25 * column(steps, "moved_parts")[i] -
                 0.125 * column(steps, "subassemblies")[i] - 0.01 * column(steps, "index")[i];
  }
}

Objective one() {
  return {"callable", Callable{.name = "score", .reward = of_one}};
}
Objective many() {
  return {"callable", Callable{.name = "score", .rewards = of_many}};
}

/// Problems whose moved piece is told by its size alone, since `moved_parts` counts a piece that
/// has no side to move as none.
bool takes_single_connections(const ProblemSpec& spec) {
  return spec.base.empty() && spec.action == StepKind::Connection && !spec.fleet;
}

TEST(Callable, OfManyStepsEarnsInHWhatOneOfOneStepEarns) {
  for (std::uint64_t seed = 0; seed < some_of(std::uint64_t{300}); ++seed) {
    ProblemSpec spec = random_problem(seed);
    if (!takes_single_connections(spec)) continue;
    spec.objective = one();
    const Problem by_one(spec);
    spec.objective = many();
    const Problem by_many(spec);
    const TransitionSystem one_system(by_one);
    const TransitionSystem many_system(by_many);
    for (const unsigned threads : {1U, 3U}) {
      Budget budget;
      budget.threads = threads;
      const StateGraph expected = StateGraph::build(one_system, budget);
      const StateGraph found = StateGraph::build(many_system, budget);
      ASSERT_EQ(found.num_actions(), expected.num_actions()) << seed;
      for (ActionId a = 0; a < found.num_actions(); ++a)
        ASSERT_DOUBLE_EQ(found.reward(a), expected.reward(a)) << seed;
    }
    Expander one_expander(one_system);
    Expander many_expander(many_system);
    const SetView start = one_system.start_state();
    const auto expected = one_expander.legal_actions(start);
    const auto found = many_expander.legal_actions(start);
    ASSERT_EQ(found.size(), expected.size()) << seed;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].connection, expected[i].connection);
      EXPECT_DOUBLE_EQ(found[i].reward, expected[i].reward);
      if (!one_system.wide()) {
        EXPECT_DOUBLE_EQ(many_expander.step(start, found[i].connection).reward, found[i].reward);
      }
    }
  }
}

TEST(Callable, OfManyStepsServesEveryMethodForOneRobot) {
  const Problem problem = load_scenario("lattice").with_objective(many());
  const double best = solve(problem, "value-iteration").reward;
  for (const char* method : {"dijkstra", "bellman-ford", "auto"})
    EXPECT_DOUBLE_EQ(solve(problem, method).reward, best) << method;
  for (const char* method : {"greedy", "random", "beam"}) {
    if (!obstacle(problem, method)) {
      EXPECT_LE(solve(problem, method).reward, best + 1e-9) << method;
    }
  }
}

TEST(Callable, OfManyStepsIsAskedAboutThousandsAtOnce) {
  std::atomic<std::size_t> calls = 0;
  std::atomic<std::size_t> steps = 0;
  Callable counting{.rewards = [&](const StepTable& table, std::span<double> rewards) {
    ++calls;
    steps += table.num_steps();
    EXPECT_EQ(table.num_steps(), rewards.size());
    of_many(table, rewards);
  }};
  const Problem problem = load_scenario("lattice").with_objective({"callable", counting});
  const TransitionSystem system(problem);
  const StateGraph graph = StateGraph::build(system, {});
  EXPECT_EQ(steps, graph.num_actions());
  EXPECT_LE(calls, graph.num_layers());  // a call for each layer, all of which have below 4,096
}

TEST(Callable, OfManyStepsSeesTheUsersNumbers) {
  ProblemSpec spec;
  spec.parts = {{.id = "a", .numbers = {{"price", 2}}}, {.id = "b", .numbers = {{"price", 5}}}};
  spec.connections = {{.parts = {"a", "b"}, .duration = 4, .numbers = {{"price", 100}}}};
  std::vector<double> seen;
  spec.objective = {"callable",
                    Callable{.rewards = [&](const StepTable& table, std::span<double> rewards) {
                      seen = {column(table, "price")[0], column(table, "moved_price")[0],
                              column(table, "kept_price")[0], column(table, "duration")[0]};
                      rewards[0] = 1;
                    }}};
  const Problem problem(spec);
  EXPECT_EQ(solve(problem, "greedy").reward, 1);
  // Of two pieces of one part and one mass the one that moves does not hold the first part.
  EXPECT_EQ(seen, (std::vector<double>{100, 5, 2, 4}));
}

TEST(Callable, OfManyStepsIsRefusedWhatIsNoReward) {
  const auto fault = [](double value) -> std::string {
    const Problem problem = load_scenario("lattice").with_objective(
        {"callable", Callable{.rewards = [value](const StepTable&, std::span<double> rewards) {
           std::ranges::fill(rewards, value);
         }}});
    try {
      (void)solve(problem, "value-iteration");
    } catch (const InputError& error) {
      return error.what();
    }
    return "no fault";
  };
  EXPECT_EQ(fault(std::nan("")).find("objective: the reward of removing \"1-2\" with 12 "), 0U)
      << fault(std::nan(""));
  EXPECT_NE(fault(std::numeric_limits<double>::infinity()).find("is infinite"), std::string::npos);
  EXPECT_NE(fault(1e308).find("sums of rewards must be finite"), std::string::npos);
  EXPECT_EQ(fault(-1), "no fault");
}

TEST(Callable, IsOfOneStepOrOfMany) {
  Callable both{.reward = of_one, .rewards = of_many};
  try {
    check_objective({"callable", both}, "objective");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "objective.rewards: the callable holds a function of one step and one of many");
  }
}

TEST(Callable, OfManyStepsMayThrow) {
  const Problem problem = load_scenario("lattice").with_objective(
      {"callable", Callable{.rewards = [](const StepTable&, std::span<double>) {
         throw std::out_of_range("mine");
       }}});
  Budget budget;
  for (const unsigned threads : {1U, 4U}) {
    budget.threads = threads;
    EXPECT_THROW((void)solve(problem, "value-iteration", {}, budget), std::out_of_range);
  }
}

}  // namespace
}  // namespace orasp
