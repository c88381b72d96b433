#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/bounds/wide_bound.h"
#include "orasp/catalogue.h"
#include "orasp/graph/graph_size.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/value_iteration.h"
#include "tests/seeds.h"
#include "tests/wide_oracle.h"
#include "tests/wide_problems.h"

namespace orasp {
namespace {

/// The steps of a result as the oracle takes them.
std::vector<oracle::WideStep> oracle_steps(const Problem& problem, const Result& result) {
  const TransitionSystem system(problem);
  std::vector<oracle::WideStep> steps;
  for (const Step& step : evaluate(system, result).steps) {
    oracle::WideStep& one = steps.emplace_back();
    for (const ConnectionIndex c : step.connections) one.connections.push_back(c);
    if (step.direction) one.direction = problem.direction_name(*step.direction);
  }
  return steps;
}

bool near(double a, double b) {
  return std::abs(a - b) <= 1e-7 * std::max({1.0, std::abs(a), std::abs(b)});
}

bool looks_at_directions(const Objective& objective) {
  if (const auto* const change = std::get_if<Changeover>(&objective.parameters))
    return change->attribute == kDirectionAttribute;
  const auto* const sum = std::get_if<WeightedSum>(&objective.parameters);
  return sum != nullptr && std::ranges::any_of(sum->terms, [](const WeightedObjective& term) {
           return looks_at_directions(term.objective);
         });
}

/// Connections of the largest problem that a learner is asked for.
constexpr std::size_t kMostForLearners = 4;

class WideAgreement : public testing::TestWithParam<std::uint64_t> {};

TEST_P(WideAgreement, EveryExactMethodEqualsBruteForce) {
  const std::uint64_t block = GetParam();
  std::size_t solved = 0;
  for (std::uint64_t seed = block * 60; seed < block * 60 + some_of<std::uint64_t>(60); ++seed) {
    const ProblemSpec spec = wide_random_problem(seed);
    const Problem problem(spec);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + problem_text(problem));
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    for (const Planner& planner : planners()) {
      if (!planner.one_robot || (!planner.exact && planner.role != Role::Chooser)) continue;
      if (planner.role == Role::Baseline) continue;  // it takes minutes
      // It must try everything often where nothing bounds what is left.
      if (planner.role == Role::Learner && problem.num_connections() > kMostForLearners) continue;
      if (obstacle(problem, planner.name)) continue;
      SCOPED_TRACE(planner.name);
      const Result result = solve(problem, planner.name);
      ++solved;
      if (!truth.best) {
        EXPECT_EQ(result.status, Status::Infeasible);
        continue;
      }
      ASSERT_EQ(result.status, Status::Optimal);
      EXPECT_TRUE(near(result.reward, *truth.best)) << result.reward << " " << *truth.best;
      const auto replayed = oracle::wide_reward_of(spec, oracle_steps(problem, result));
      ASSERT_TRUE(replayed.has_value());
      EXPECT_TRUE(near(*replayed, *truth.best)) << *replayed << " " << *truth.best;
    }
    // What the others claim is true.
    for (const Planner& planner : planners()) {
      if (!planner.one_robot || planner.exact || planner.role != Role::Search) continue;
      if (obstacle(problem, planner.name)) continue;
      SCOPED_TRACE(planner.name);
      const Result result = solve(problem, planner.name);
      if (!truth.best) {
        EXPECT_FALSE(result.has_plan());
        continue;
      }
      EXPECT_NE(result.status, Status::Infeasible);
      const double slack = 1e-7 * std::max(1.0, std::abs(*truth.best));
      if (result.status == Status::Optimal) {
        EXPECT_NEAR(result.reward, *truth.best, slack);
      }
      if (result.bound) {
        EXPECT_GE(*result.bound, *truth.best - slack);
      }
    }
    for (const char* const method : {"greedy", "random"}) {
      const Result result = solve(problem, method);
      EXPECT_EQ(result.has_plan(), truth.best.has_value()) << method;
      if (!result.has_plan()) continue;
      const auto replayed = oracle::wide_reward_of(spec, oracle_steps(problem, result));
      ASSERT_TRUE(replayed.has_value()) << method;
      EXPECT_TRUE(near(*replayed, result.reward)) << method;
    }
  }
  EXPECT_GT(solved, 0U);
}

TEST_P(WideAgreement, TheStateActionGraphHasAllPlansAndBoundsAreNeverBelowTheTruth) {
  const std::uint64_t block = GetParam();
  for (std::uint64_t seed = block * 60; seed < block * 60 + some_of<std::uint64_t>(60); ++seed) {
    const ProblemSpec spec = wide_random_problem(seed);
    const Problem problem(spec);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + problem_text(problem));
    const TransitionSystem system(problem);
    if (system.infeasibility()) continue;
    const StateGraph graph = StateGraph::build(system, {});
    const Result result = value_iteration(graph, {}, {});
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    if (!looks_at_directions(problem.objective())) {
      EXPECT_EQ(graph_size(graph).sequences, std::to_string(truth.plans));
    }
    if (!system.wide()) continue;
    WideBound bound(system);
    if (!bound.known()) continue;
    for (StateId s = 0; s < graph.num_states(); ++s) {
      if (result.values[s] == -kInfinity) continue;
      const double most = bound(graph.key(s));
      EXPECT_GE(most, result.values[s] - 1e-9 * std::max(1.0, std::abs(most))) << "state " << s;
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
        const double next = bound(graph.key(graph.successor(a)));
        EXPECT_GE(most, graph.reward(a) + next - 1e-9 * std::max(1.0, std::abs(most)))
            << "state " << s << ": the bound is not consistent";
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, WideAgreement, testing::Range<std::uint64_t>(0, 10));

}  // namespace
}  // namespace orasp
