#include "tests/wide_oracle.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/problem.h"
#include "tests/oracle.h"
#include "tests/wide_problems.h"

namespace orasp::oracle {
namespace {

/// Whether the other brute force knows all that the objective needs.
bool is_plain(const Objective& objective) {
  if (objective.type == "sum") {
    const auto& terms = std::get<WeightedSum>(objective.parameters).terms;
    return std::all_of(terms.begin(), terms.end(),
                       [](const WeightedObjective& term) { return is_plain(term.objective); });
  }
  return objective.type != "changeover" && objective.type != "route" &&
         objective.type != "expression";
}

TEST(WideOracle, AgreesWithTheOtherOneWhereThatKnowsAllKeys) {
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    ProblemSpec spec = wide_random_problem(seed);
    spec.base.clear();
    spec.limits.grounded = false;
    spec.goal.reset();
    spec.action = StepKind::Connection;
    if (!is_plain(spec.objective)) spec.objective = Objective::named("indexed");
    const OracleResult expected = brute_force(spec);
    const WideResult found = wide_brute_force(spec);
    ASSERT_EQ(found.best.has_value(), expected.feasible) << spec.name;
    if (!expected.feasible) continue;
    EXPECT_NEAR(*found.best, expected.best, 1e-9) << spec.name;
    EXPECT_EQ(found.plans, expected.sequences) << spec.name;
    for (const auto& [open, best] : expected.best_to_go) {
      const auto here = found.best_to_go.find({open, WideContext{}});
      ASSERT_NE(here, found.best_to_go.end()) << spec.name;
      if (std::isfinite(best)) {
        EXPECT_NEAR(here->second, best, 1e-9) << spec.name;
      } else {
        EXPECT_EQ(here->second, best) << spec.name;
      }
    }
  }
}

TEST(WideOracle, AssemblyIsTheSameGraphTheOtherWay) {
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    ProblemSpec spec = wide_random_problem(seed);
    spec.goal.reset();
    spec.objective = Objective::named("time");  // what a step earns is its own affair
    spec.direction = Direction::Disassembly;
    const WideResult apart = wide_brute_force(spec);
    spec.direction = Direction::Assembly;
    const WideResult together = wide_brute_force(spec);
    EXPECT_EQ(together.plans, apart.plans) << spec.name;
    ASSERT_EQ(together.best.has_value(), apart.best.has_value()) << spec.name;
    if (!apart.best) continue;
    EXPECT_NEAR(*together.best, *apart.best, 1e-9) << spec.name;
    std::vector<WideStep> turned = apart.best_plan;
    std::reverse(turned.begin(), turned.end());
    const auto reward = wide_reward_of(spec, turned);
    ASSERT_TRUE(reward.has_value()) << spec.name;
    EXPECT_NEAR(*reward, *apart.best, 1e-9) << spec.name;
  }
}

/// All plans, one by one, nothing remembered.
struct EveryPlan {
  const ProblemSpec& spec;
  std::optional<double> best{};
  std::set<std::vector<std::vector<std::size_t>>> orders{};

  void go_on(const State& open, std::vector<WideStep>& plan) {
    if (const auto reward = wide_reward_of(spec, plan)) {
      best = std::max(best.value_or(*reward), *reward);
      std::vector<std::vector<std::size_t>> order;
      for (const WideStep& step : plan) order.push_back(step.connections);
      orders.insert(order);
    }
    for (const WideChoice& choice : wide_choices(spec, open)) {
      State next = open;
      for (const std::size_t c : choice.connections) next[c] = false;
      std::vector<std::string> directions = choice.free_directions;
      if (directions.empty()) directions.emplace_back();
      for (const std::string& direction : directions) {
        plan.push_back({choice.connections, direction});
        go_on(next, plan);
        plan.pop_back();
      }
    }
  }
};

TEST(WideOracle, AgreesWithGoingThroughEveryPlan) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    const ProblemSpec spec = wide_random_problem(seed);
    if (spec.connections.size() > 3) continue;
    ++compared;
    const WideResult found = wide_brute_force(spec);
    EveryPlan every{spec};
    std::vector<WideStep> plan;
    every.go_on(State(spec.connections.size(), true), plan);
    EXPECT_EQ(found.plans, every.orders.size()) << spec.name;
    ASSERT_EQ(found.best.has_value(), every.best.has_value()) << spec.name;
    if (!found.best) continue;
    EXPECT_NEAR(*found.best, *every.best, 1e-9) << spec.name;
  }
  EXPECT_GT(compared, 100);
}

/// What each of the problems holds, counted.
void count_keys(const Objective& objective, std::map<std::string, int>& counts) {
  if (objective.type == "sum") {
    for (const WeightedObjective& term : std::get<WeightedSum>(objective.parameters).terms)
      count_keys(term.objective, counts);
  }
  ++counts[objective.type];
  if (objective.type == "changeover" &&
      std::get<Changeover>(objective.parameters).attribute == "direction")
    ++counts["direction"];
}

TEST(WideOracle, RandomProblemsAreValidAndUseEveryKey) {
  std::map<std::string, int> counts;
  const int problems = 1000;
  for (std::uint64_t seed = 0; seed < problems; ++seed) {
    const ProblemSpec spec = wide_random_problem(seed);
    ASSERT_NO_THROW(static_cast<void>(Problem(spec))) << spec.name;
    const WideResult result = wide_brute_force(spec);
    counts["no plan"] += result.best ? 0 : 1;
    counts["base"] += spec.base.empty() ? 0 : 1;
    counts["grounded"] += spec.limits.grounded ? 1 : 0;
    counts["goal"] += spec.goal ? 1 : 0;
    counts["part"] += spec.action == StepKind::Part ? 1 : 0;
    counts["assembly"] += spec.direction == Direction::Assembly ? 1 : 0;
    counts["blocking"] += spec.blocking ? 1 : 0;
    if (spec.goal && spec.goal->stop == Goal::Stop::Best) ++counts["best"];
    for (const Precedence& entry : spec.precedence) {
      counts["made_after"] += entry.made_after.empty() ? 0 : 1;
      counts["made_after_any"] += entry.made_after_any.empty() ? 0 : 1;
    }
    count_keys(spec.objective, counts);
    if (!result.best) continue;
    const auto replayed = wide_reward_of(spec, result.best_plan);
    ASSERT_TRUE(replayed.has_value()) << spec.name;
    EXPECT_NEAR(*replayed, *result.best, 1e-9) << spec.name;
  }
  EXPECT_GT(counts["no plan"], problems / 10);
  EXPECT_LT(counts["no plan"], problems / 5);
  for (const char* const key : {"base", "goal", "part", "assembly", "blocking", "made_after_any",
                                "made_after", "expression", "changeover", "route"}) {
    EXPECT_GT(counts[key], problems / 10) << key;
  }
  for (const char* const key :
       {"grounded", "best", "direction", "piece_cost", "cubesat", "cubesat_zone", "custom",
        "indexed", "time", "travel", "fuel", "completion", "sum"}) {
    EXPECT_GT(counts[key], problems / 50) << key;
  }
}

}  // namespace
}  // namespace orasp::oracle
