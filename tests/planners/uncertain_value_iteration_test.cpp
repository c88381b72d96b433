#include "orasp/planners/uncertain_value_iteration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/catalogue.h"
#include "orasp/execution/simulation.h"
#include "orasp/graph/state_graph.h"
#include "orasp/graph/uncertain_graph.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/objectives/retried.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "orasp/planners/value_iteration.h"
#include "tests/checks.h"
#include "tests/fault.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

/// A chain of parts a, b, c, ...; a step earns -1 for itself and -1 for each connection after it.
Problem chain(const std::vector<std::string>& connection_keys, const std::string& more = "") {
  const std::string names = "abcdefgh";
  std::string parts;
  std::string connections;
  for (std::size_t i = 0; i <= connection_keys.size(); ++i) {
    if (i > 0) {
      parts += ", ";
      connections += std::string(i > 1 ? ", " : "") + R"({"parts": [")" + names[i - 1] + R"(", ")" +
                     names[i] + R"("])" + connection_keys[i - 1] + "}";
    }
    parts += std::string(R"({"id": ")") + names[i] + R"("})";
  }
  return parse_problem(R"({"format": "orasp-problem/1", "parts": [)" + parts +
                       R"(], "connections": [)" + connections + "]" + more +
                       R"(, "objective": {"type": "expression", "formula": "0 - 1 - after"}})");
}

/// The same by a dense linear system over all subsets and policy iteration; rules and rewards from
/// the oracle. Nothing of UncertainGraph.
class DenseSolution {
 public:
  explicit DenseSolution(const Problem& problem)
      : problem_(problem), world_(problem.spec()), connections_(problem.num_connections()) {
    const std::size_t subsets = std::size_t{1} << connections_;
    for (std::size_t s = 0; s < subsets; ++s) {
      actions_.push_back(s == 0 ? std::vector<Choice>{} : choices_of(s));
    }
    find_safe(subsets);
    iterate();
  }

  [[nodiscard]] double value(SetView open) const {
    return values_[static_cast<std::size_t>(open[0])];
  }

 private:
  struct Branch {
    double probability;
    double reward;
    std::optional<std::size_t> next;  ///< empty: the job ended
  };
  using Choice = std::vector<Branch>;

  std::vector<Choice> choices_of(std::size_t s) const {
    oracle::State open(connections_);
    for (std::size_t c = 0; c < connections_; ++c) open[c] = (s >> c & 1U) != 0;
    std::vector<Choice> choices;
    for (const oracle::Facts& facts : world_.legal_facts(open)) {
      const Connection& tried = problem_.spec().connections[facts.connection];
      Choice choice = {{tried.success, facts.reward, s & ~(std::size_t{1} << facts.connection)}};
      if (tried.success < 1) {
        const double fails = 1 - tried.success;
        if (tried.on_failure.abort) {
          choice.push_back({fails, *tried.on_failure.abort, std::nullopt});
        } else {
          std::size_t left = s;
          for (const std::string& id : tried.on_failure.breaks)
            left &= ~(std::size_t{1} << problem_.find_connection(id, ""));
          choice.push_back({fails, facts.reward, left});
        }
      }
      choices.push_back(choice);
    }
    return choices;
  }

  /// The greatest set of states in which some choice stays within the set.
  void find_safe(std::size_t subsets) {
    safe_.assign(subsets, true);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t s = 1; s < subsets; ++s) {
        if (!safe_[s] ||
            std::ranges::any_of(actions_[s], [&](const Choice& choice) { return is_safe(choice); }))
          continue;
        safe_[s] = false;
        changed = true;
      }
    }
  }
  bool is_safe(const Choice& choice) const {
    return std::ranges::all_of(
        choice, [&](const Branch& branch) { return !branch.next || safe_[*branch.next]; });
  }
  double worth(const Choice& choice) const {
    double sum = 0;
    for (const Branch& branch : choice)
      sum += branch.probability * (branch.reward + (branch.next ? values_[*branch.next] : 0));
    return sum;
  }

  void iterate() {
    std::vector<const Choice*> policy(safe_.size(), nullptr);
    for (std::size_t s = 1; s < safe_.size(); ++s) {
      if (!safe_[s]) continue;
      for (const Choice& choice : actions_[s]) {
        if (policy[s] == nullptr && is_safe(choice)) policy[s] = &choice;
      }
    }
    for (bool changed = true; changed;) {
      solve_linear(policy);
      changed = false;
      for (std::size_t s = 1; s < safe_.size(); ++s) {
        if (!safe_[s]) continue;
        for (const Choice& choice : actions_[s]) {
          const double now = worth(*policy[s]);
          if (!is_safe(choice) || worth(choice) <= now + 1e-11 * std::max(1.0, std::abs(now)))
            continue;
          policy[s] = &choice;
          changed = true;
        }
      }
    }
  }

  /// (I - P) V = r by Gaussian elimination with row pivoting.
  void solve_linear(const std::vector<const Choice*>& policy) {
    std::vector<std::size_t> row_of(safe_.size(), 0);
    std::vector<std::size_t> states;
    for (std::size_t s = 1; s < safe_.size(); ++s) {
      if (!safe_[s]) continue;
      row_of[s] = states.size();
      states.push_back(s);
    }
    const std::size_t n = states.size();
    std::vector<std::vector<double>> m(n, std::vector<double>(n + 1, 0.0));
    for (std::size_t i = 0; i < n; ++i) {
      m[i][i] += 1;
      for (const Branch& branch : *policy[states[i]]) {
        m[i][n] += branch.probability * branch.reward;
        if (branch.next && *branch.next != 0) m[i][row_of[*branch.next]] -= branch.probability;
      }
    }
    for (std::size_t k = 0; k < n; ++k) {
      std::size_t pivot = k;
      for (std::size_t i = k + 1; i < n; ++i) {
        if (std::abs(m[i][k]) > std::abs(m[pivot][k])) pivot = i;
      }
      std::swap(m[k], m[pivot]);
      for (std::size_t i = k + 1; i < n; ++i) {
        const double factor = m[i][k] / m[k][k];
        if (factor == 0) continue;
        for (std::size_t j = k; j <= n; ++j) m[i][j] -= factor * m[k][j];
      }
    }
    values_.assign(safe_.size(), kNever);
    values_[0] = 0;
    for (std::size_t k = n; k-- > 0;) {
      double sum = m[k][n];
      for (std::size_t j = k + 1; j < n; ++j) sum -= m[k][j] * values_[states[j]];
      values_[states[k]] = sum / m[k][k];
    }
  }

  const Problem& problem_;
  oracle::World world_;
  std::size_t connections_;
  std::vector<std::vector<Choice>> actions_;
  std::vector<bool> safe_;
  std::vector<double> values_;
};

void expect_mean_near(const Simulation& simulation, double expected, const std::string& what) {
  const auto n = static_cast<double>(simulation.rewards.size());
  const double mean =
      std::accumulate(simulation.rewards.begin(), simulation.rewards.end(), 0.0) / n;
  double squares = 0;
  for (const double reward : simulation.rewards) squares += (reward - mean) * (reward - mean);
  const double standard_error = std::sqrt(squares / (n - 1) / n);
  EXPECT_NEAR(mean, expected, 3 * standard_error + reward_tolerance(expected)) << what;
}

TEST(Uncertain, TwoPartsByHand) {
  // One connection, reward -1 an attempt, success 0.25: 4 attempts expected, so -1 / 0.25.
  const Result result = solve(chain({R"(, "success": 0.25)"}), "auto");
  EXPECT_EQ(status_name(result.status), "optimal");
  EXPECT_NEAR(result.reward, -4, 1e-12);
  ASSERT_TRUE(result.expectation);
  EXPECT_NEAR(result.expectation->attempts, 4, 1e-12);
  EXPECT_LE(result.expectation->residual, 1e-14);
  EXPECT_LE(result.expectation->error, 1e-12);
  EXPECT_EQ(result.sequence, std::vector<ConnectionIndex>{0});
}

TEST(Uncertain, ThreePartsWithABreakingFailureByHand) {
  // V({b-c}) = -1 / 0.5 = -2 and V({a-b}) = -1 / 0.8 = -1.25 (b-c is gone: it can only retry).
  // a-b first: -2 + 0.8 (-2) + 0.2 (-1.25) = -3.85. b-c first: -2 / 0.5 - 1.25 = -5.25.
  // Attempts: 1 + 0.8 * 2 + 0.2 * 1.25 = 2.85.
  const Problem problem =
      chain({R"(, "success": 0.8, "on_failure": {"breaks": ["b-c"]})", R"(, "success": 0.5)"});
  const Result result = solve(problem, "value-iteration");
  EXPECT_NEAR(result.reward, -3.85, 1e-12);
  EXPECT_NEAR(result.expectation->attempts, 2.85, 1e-12);
  EXPECT_EQ(result.sequence, (std::vector<ConnectionIndex>{0, 1}));
  ASSERT_EQ(result.expectation->policy.size(), 3U);
  EXPECT_EQ(result.expectation->policy[0].open, ConnectionSet::all(2));
  EXPECT_EQ(result.statistics.states, 4U);

  const TransitionSystem system(problem);
  const UncertainGraph graph = UncertainGraph::build(system, {});
  const UncertainSolution solution = solve_uncertain(graph);
  expect_mean_near(simulate(graph, solution.choice, {}, {.runs = 20'000, .seed = 1}, {}), -3.85,
                   "breaking");
}

TEST(Uncertain, TheMostLikelyCourseCountsFailuresThatChangeTheState) {
  // One connection left is tried until it succeeds, so only the first attempt is open. p = 0.8: it
  // succeeds.
  const Expectation sure =
      *solve(
           chain({R"(, "success": 0.8, "on_failure": {"breaks": ["b-c"]})", R"(, "success": 0.5)"},
                 R"(, "precedence": [{"connection": "b-c", "after": ["a-b"]}])"),
           "auto")
           .expectation;
  EXPECT_NEAR(sure.probability, 0.8, 1e-12);
  EXPECT_EQ(sure.most_likely, (std::vector<AttemptOutcome>{{0, true}, {1, true}}));
  // p = 0.4: it fails, b-c comes off, and a-b is the one that is left.
  const Expectation unsure =
      *solve(chain({R"(, "success": 0.4, "on_failure": {"breaks": ["b-c"]})", ""},
                   R"(, "precedence": [{"connection": "b-c", "after": ["a-b"]}])"),
             "auto")
           .expectation;
  EXPECT_NEAR(unsure.probability, 0.6, 1e-12);
  EXPECT_EQ(unsure.most_likely, (std::vector<AttemptOutcome>{{0, false}, {0, true}}));
  // A job that most likely ends early.
  const Expectation ended =
      *solve(chain({R"(, "success": 0.1, "on_failure": {"abort": -5})"}), "auto").expectation;
  EXPECT_NEAR(ended.probability, 0.9, 1e-12);
  EXPECT_EQ(ended.most_likely, (std::vector<AttemptOutcome>{{0, false}}));
}

TEST(Uncertain, AFailureCanTakeTheAttemptedConnectionAndEmptyTheState) {
  // -2 an attempt; success leaves b-c (-1), failure takes both: -2 + 0.5 (-1) = -2.5.
  const Problem problem =
      chain({R"(, "success": 0.5, "on_failure": {"breaks": ["b-c", "a-b"]})", ""},
            R"(, "precedence": [{"connection": "b-c", "after": ["a-b"]}])");
  EXPECT_NEAR(solve(problem, "auto").reward, -2.5, 1e-12);
}

TEST(Uncertain, AbortByHand) {
  // One attempt, whatever comes of it. A success earns -1 in disassembly, where no connection is
  // left after it, and -2 in assembly, where one is made: 0.75 (-1) + 0.25 (-50) = -13.25; 0.75
  // (-2) + 0.25 (-50) = -14.
  for (const auto& [direction, expected] :
       {std::pair("disassembly", -13.25), std::pair("assembly", -14.0)}) {
    const Problem problem = chain({R"(, "success": 0.75, "on_failure": {"abort": -50})"},
                                  R"(, "direction": ")" + std::string(direction) + "\"");
    const Result result = solve(problem, "auto");
    EXPECT_NEAR(result.reward, expected, 1e-12);
    EXPECT_NEAR(result.expectation->attempts, 1, 1e-12);
    const TransitionSystem system(problem);
    const UncertainGraph graph = UncertainGraph::build(system, {});
    const Simulation simulation =
        simulate(graph, solve_uncertain(graph).choice, {}, {.runs = 20'000, .seed = 2}, {});
    expect_mean_near(simulation, expected, direction);
    EXPECT_NEAR(static_cast<double>(simulation.aborted) / 20'000, 0.25, 0.01);
  }
}

TEST(Uncertain, OnFailureNeverHappensWithSuccessOne) {
  const Problem problem = chain({R"(, "on_failure": {"abort": -50})", ""});
  EXPECT_FALSE(problem.uncertain());
  EXPECT_NEAR(solve(problem, "dijkstra").reward, -3, 1e-12);
  const TransitionSystem system(problem);
  EXPECT_NEAR(uncertain_value_iteration(system, {}, {}).reward, -3, 1e-12);
}

TEST(Uncertain, WhereEveryPolicyMayEndInADeadEndThereIsNone) {
  // Nothing may ever be moved, however often it is tried.
  EXPECT_EQ(
      status_name(
          solve(chain({R"(, "success": 0.5)"}, R"(, "limits": {"max_moved_parts": 0})"), "auto")
              .status),
      "infeasible");
}

TEST(Uncertain, AnAttemptWhoseFailureLeadsToADeadEndIsNotMade) {
  // a-b-c-d-e-f, one subassembly at a time, -1 a step. a-b fails half the time and breaks b-c and
  // d-e: from the start that leaves a-b, c-d, e-f, three subassemblies, and whatever is removed
  // next leaves two. So only e-f can begin: -1. Then a-b: a failure leaves a-b, c-d (-1, and a-b
  // until it succeeds: -3), success b-c, c-d, d-e (-3): -1 - 3 = -4. Or d-e, then a-b: -1 - 1 + 0.5
  // (-2) + 0.5 (-3) = -4.5; or a-b last: -3 - 2 = -5. Best: -1 - 4.
  const auto six = [](const std::string& last) {
    return parse_problem(R"({"format": "orasp-problem/1",
      "parts": [{"id": "a"}, {"id": "b"}, {"id": "c"}, {"id": "d"}, {"id": "e"}, {"id": "f"}],
      "connections": [{"parts": ["a", "b"], "success": 0.5,
                       "on_failure": {"breaks": ["b-c", "d-e"]}},
                      {"parts": ["b", "c"]}, {"parts": ["c", "d"]},
                      {"parts": ["d", "e"]}, {"parts": ["e", "f"])" +
                         last + R"(}],
      "limits": {"max_subassemblies": 1},
      "objective": {"type": "expression", "formula": "0 - 1"}})");
  };
  const Result result = solve(six(""), "auto");
  EXPECT_NEAR(result.reward, -5, 1e-12);
  EXPECT_EQ(result.expectation->policy.front().next, 4U);
  // With e-f as risky as a-b nothing safe can begin, though there is a plan where nothing fails.
  EXPECT_EQ(status_name(
                solve(six(R"(, "success": 0.5, "on_failure": {"breaks": ["b-c", "d-e"]})"), "auto")
                    .status),
            "infeasible");
}

TEST(Uncertain, AgreesWithADenseLinearSolve) {
  int solved = 0;
  int infeasible = 0;
  int beyond_legal_steps = 0;
  for (std::uint64_t seed = 0; seed < some_of(500U); ++seed) {
    const Problem problem(make_uncertain(random_problem(seed), seed));
    if (problem.num_connections() > 6 || !problem.uncertain()) continue;
    const TransitionSystem system(problem);
    if (system.infeasibility()) continue;
    const UncertainGraph graph = UncertainGraph::build(system, {});
    const UncertainSolution solution = solve_uncertain(graph);
    const DenseSolution dense(problem);
    for (UncertainGraph::State s = 0; s < graph.num_states(); ++s) {
      const double expected = dense.value(graph.state(s));
      if (expected == kNever) {
        EXPECT_EQ(solution.values[s], kNever) << seed << " state " << s;
      } else {
        EXPECT_NEAR(solution.values[s], expected, 10 * reward_tolerance(expected))
            << seed << " state " << s;
      }
    }
    const oracle::OracleResult truth = oracle::brute_force(problem.spec());
    if (graph.num_states() > truth.states) ++beyond_legal_steps;

    const Result result = solve(problem, "auto");
    if (dense.value(system.start().view()) == kNever) {
      EXPECT_EQ(status_name(result.status), "infeasible") << seed;
      ++infeasible;
      continue;
    }
    ++solved;
    EXPECT_EQ(status_name(result.status), "optimal") << seed;
    EXPECT_TRUE(evaluate(problem, std::span<const ConnectionIndex>(result.sequence)).valid) << seed;
    EXPECT_LE(result.expectation->error, reward_tolerance(result.reward) * 100) << seed;

    ValueIterationOptions textbook;
    textbook.order = ValueIterationOptions::Order::Textbook;
    textbook.epsilon = 1e-13;
    textbook.initial_value = 3;
    const Result swept = uncertain_value_iteration(graph, textbook, {});
    EXPECT_NEAR(swept.reward, result.reward, 10 * reward_tolerance(result.reward)) << seed;
    textbook.max_sweeps = 2;
    const Result early = uncertain_value_iteration(graph, textbook, {});
    ASSERT_TRUE(early.has_plan());
    EXPECT_LE(early.reward, result.reward + reward_tolerance(result.reward)) << seed;
    EXPECT_GE(*early.bound, result.reward - reward_tolerance(result.reward)) << seed;
  }
  EXPECT_GE(solved, more_than(100));
  EXPECT_GE(infeasible, more_than(5));
  EXPECT_GE(beyond_legal_steps, more_than(20));
}

TEST(Uncertain, SimulationAgreesWithTheExpectationOfPlansAndPolicies) {
  int plans = 0;
  int replanned = 0;
  for (std::uint64_t seed = 0; seed < some_of(60U); ++seed) {
    const ProblemSpec certain = random_problem(seed);
    const Problem problem(make_uncertain(certain, seed));
    const TransitionSystem system(problem);
    const Result result = solve(problem, "auto");
    if (!result.has_plan() || !problem.uncertain()) continue;
    const std::string what = "seed " + std::to_string(seed);

    const UncertainGraph by_policy =
        UncertainGraph::build(system, {}, guide_by_policy(system, result.expectation->policy));
    const UncertainSolution policy = solve_uncertain(by_policy);
    EXPECT_NEAR(policy.values[0], result.reward, reward_tolerance(result.reward)) << what;
    EXPECT_NEAR(policy.attempts[0], result.expectation->attempts, 1e-9) << what;
    if (!problem.only_retries()) {
      EXPECT_LE(by_policy.num_states(), result.statistics.states) << what;
    }
    expect_mean_near(simulate(by_policy, policy.choice, {}, {.runs = 4000, .seed = seed + 1}, {}),
                     result.reward, what + " policy");

    const Result plain = solve(Problem(certain), "greedy");
    if (!plain.has_plan()) continue;
    const UncertainGraph by_plan = UncertainGraph::build(system, {}, guide_by_plan(plain.sequence));
    const UncertainSolution planned = solve_uncertain(by_plan);
    if (planned.values[0] == kNever) continue;
    ++plans;
    EXPECT_LE(planned.values[0], result.reward + reward_tolerance(result.reward)) << what;
    const Simulation simulation =
        simulate(by_plan, planned.choice, plain.sequence, {.runs = 4000, .seed = seed + 1}, {});
    expect_mean_near(simulation, planned.values[0], what + " plan");
    if (simulation.replanned > 0) ++replanned;
  }
  EXPECT_GE(plans, more_than(15));
  EXPECT_GE(replanned, more_than(5));
}

/// The problem with attempts that are made again until they succeed: of every fourth problem all
/// equally likely to.
ProblemSpec make_retrying(ProblemSpec spec, std::uint64_t seed) {
  SplitMix64 random(seed + 77);
  const double alike = 0.25 + 0.5 * random.uniform();
  for (Connection& connection : spec.connections)
    connection.success = seed % 4 == 0 ? alike : 0.2 + 0.8 * random.uniform();
  return spec;
}

/// What the bounds say in every state of H, against what is best there.
void expect_bounds_hold(const TransitionSystem& system, const std::string& what) {
  const StateGraph graph = StateGraph::build(system, {});
  const std::vector<double> values = value_iteration(graph, {}, {}).values;
  Expander expander(system);
  for (const std::string_view name : kBoundNames) {
    const std::unique_ptr<Bound> bound = make_bound(system, bound_called(name));
    if (!bound->known()) continue;
    for (StateId state = 0; state < graph.num_states(); ++state) {
      if (values[state] == kNever) continue;
      const double here = (*bound)(graph.state(state));
      EXPECT_GE(here, values[state] - reward_tolerance(values[state])) << what << ' ' << name;
      for (ActionId a = graph.begin(state); a < graph.end(state); ++a) {
        const double there = (*bound)(graph.state(graph.successor(a)));
        EXPECT_GE(here - there, graph.reward(a) - reward_tolerance(here)) << what << ' ' << name;
      }
    }
  }
}

// A failure that changes nothing makes a step cost what its attempts cost together, so every method
// answers, and those that prove prove what value iteration over attempts finds.
TEST(Uncertain, WhereFailuresChangeNothingEveryMethodAnswers) {
  int solved = 0;
  int infeasible = 0;
  for (std::uint64_t seed = 0; seed < some_of(240U); ++seed) {
    const Problem problem(make_retrying(random_problem(seed), seed));
    if (problem.num_connections() > 7 || !problem.only_retries()) continue;
    const Result truth = solve(problem, "value-iteration");
    const double tolerance = 10 * reward_tolerance(truth.reward);
    for (const Planner* const planner : one_robot_planners()) {
      const std::string what = "seed " + std::to_string(seed) + ' ' + std::string(planner->name);
      const bool slow = planner->role == Role::Learner || planner->name == "mip";
      if (obstacle(problem, planner->name) || (slow && seed % 8 != 0)) continue;
      const Result result = solve(problem, planner->name);
      if (!truth.has_plan()) {
        EXPECT_FALSE(result.has_plan()) << what;
        if (planner->exact) {
          EXPECT_EQ(status_name(result.status), "infeasible") << what;
        }
        continue;
      }
      if (planner->exact) {
        EXPECT_EQ(status_name(result.status), "optimal") << what;
      }
      if (!result.has_plan()) continue;
      EXPECT_LE(result.reward, truth.reward + tolerance) << what;
      if (result.status == Status::Optimal) {
        EXPECT_NEAR(result.reward, truth.reward, tolerance) << what;
      }
      if (result.bound) {
        EXPECT_GE(*result.bound, truth.reward - tolerance) << what;
      }
      ASSERT_TRUE(result.expectation) << what;
      double attempts = 0;
      for (const ConnectionIndex c : result.sequence)
        attempts += 1 / problem.connections()[c].success;
      EXPECT_NEAR(result.expectation->attempts, attempts, 1e-9) << what;
      ASSERT_EQ(result.expectation->policy.size(), result.sequence.size()) << what;
      if (result.sequence.empty()) continue;
      EXPECT_EQ(result.expectation->policy.front().open.size(), problem.num_connections()) << what;
      EXPECT_NEAR(result.expectation->policy.front().reward, result.reward, tolerance) << what;
      EXPECT_GE(result.reward + result.expectation->error, truth.reward - tolerance) << what;
      // Who follows the policy earns that.
      const TransitionSystem system(problem);
      const UncertainGraph followed =
          UncertainGraph::build(system, {}, guide_by_policy(system, result.expectation->policy));
      EXPECT_NEAR(solve_uncertain(followed).values[0], result.reward, tolerance) << what;
    }
    if (truth.has_plan()) {
      ++solved;
      const Problem paid = attempts_paid(problem);
      const TransitionSystem system(paid);
      expect_bounds_hold(system, "seed " + std::to_string(seed));
      if (problem.direction() == Direction::Assembly)
        expect_bounds_hold(system.backwards(), "backwards, seed " + std::to_string(seed));
    } else {
      ++infeasible;
    }
  }
  EXPECT_GE(solved, more_than(60));
  EXPECT_GE(infeasible, more_than(5));
}

TEST(Uncertain, WhatStandsInTheWayIsSaidOfTheObjectiveThatIsStated) {
  const Problem problem =
      chain({R"(, "success": 0.5)", "", ""}).with_objective(unbounded_formula());
  EXPECT_EQ(fault_of([&] { return solve(problem, "a-star"); }),
            "a-star needs a bound on what a step can earn, and none is known for the objective "
            "'expression'; use auto, value-iteration, dijkstra or bellman-ford");
}

TEST(Uncertain, WhatIsLeftOfAJobWithRetriesIsPlannedToo) {
  // a - b - c - d, -1 an attempt and 0 for the last. b-c cannot be handled any more: a-b takes two
  // attempts, and c-d completes whichever comes last, so the one with fewer attempts comes first.
  const Problem problem = chain({R"(, "success": 0.5)", "", R"(, "success": 0.8)"});
  Situation now = Situation::whole(3);
  now.inaccessible.insert(1);
  const Result best = solve(Task(problem, now), "value-iteration");
  const Result result = solve(Task(problem, now), "dijkstra");
  EXPECT_EQ(status_name(result.status), "optimal");
  EXPECT_NEAR(result.reward, best.reward, 1e-12);
  ASSERT_EQ(result.expectation->policy.size(), 2U);
  EXPECT_FALSE(result.expectation->policy.front().open.contains(1));
  EXPECT_EQ(result.sequence, best.sequence);
}

TEST(Uncertain, TheSameSeedGivesTheSameRunsAndLongerSimulationsBeginAlike) {
  const Problem problem = chain({R"(, "success": 0.5)", R"(, "success": 0.3)"});
  const TransitionSystem system(problem);
  const UncertainGraph graph = UncertainGraph::build(system, {});
  const UncertainSolution solution = solve_uncertain(graph);
  const Simulation shorter = simulate(graph, solution.choice, {}, {.runs = 50, .seed = 7}, {});
  const Simulation longer = simulate(graph, solution.choice, {}, {.runs = 80, .seed = 7}, {});
  EXPECT_TRUE(std::equal(shorter.rewards.begin(), shorter.rewards.end(), longer.rewards.begin()));
  EXPECT_EQ(longer.rewards.size(), 80U);
  EXPECT_EQ(shorter.replanned, 0U);
}

TEST(Uncertain, APlanWhoseNextConnectionCameOffIsReplanned) {
  // a-b always breaks b-c when it fails (half the time): then the plan's b-c had come off.
  const Problem problem =
      chain({R"(, "success": 0.5, "on_failure": {"breaks": ["b-c", "a-b"]})", "", ""});
  const TransitionSystem system(problem);
  const std::vector<ConnectionIndex> plan = {0, 1, 2};
  const UncertainGraph graph = UncertainGraph::build(system, {}, guide_by_plan(plan));
  const Simulation simulation =
      simulate(graph, solve_uncertain(graph).choice, plan, {.runs = 1000, .seed = 1}, {});
  EXPECT_GT(simulation.replanned, 400U);
  EXPECT_LT(simulation.replanned, 600U);
}

TEST(Uncertain, OtherMethodsSayThatTheyDoNotApply) {
  const Problem problem = chain({"", R"(, "success": 0.5, "on_failure": {"abort": -9})"});
  for (const Planner* const planner : one_robot_planners()) {
    if (planner->uncertain) continue;
    EXPECT_EQ(fault_of([&] { return solve(problem, planner->name); }),
              std::string(planner->name) +
                  " plans for attempts that always succeed, and an attempt at connection \"b-c\" "
                  "may fail (its success is below 1); use auto or value-iteration");
  }
}

TEST(Uncertain, LimitsStopItWithoutAPlan) {
  const Problem problem = chain(std::vector<std::string>(7, R"(, "success": 0.5)"));
  Budget budget;
  budget.max_bytes = 1;
  const Result result = solve(problem, "value-iteration", {}, budget);
  EXPECT_EQ(status_name(result.status), "unknown");
  EXPECT_EQ(result.stop, Stop::MemoryLimit);
  EXPECT_FALSE(result.expectation);
}

TEST(Uncertain, ASuccessThatIsTooSmallIsRefused) {
  EXPECT_THROW(static_cast<void>(solve(chain({R"(, "success": 1e-320)"}), "auto")), InputError);
}

TEST(Uncertain, APolicyThatDoesNotFitIsRefused) {
  const Problem problem = chain({R"(, "success": 0.5)", ""});
  const TransitionSystem system(problem);
  std::vector<PolicyState> policy = {{.open = system.start(), .next = 0}};
  EXPECT_THROW(
      static_cast<void>(UncertainGraph::build(system, {}, guide_by_policy(system, policy))),
      InputError);
  const Problem ordered = chain({R"(, "success": 0.5)", ""},
                                R"(, "precedence": [{"connection": "a-b", "after": ["b-c"]}])");
  const TransitionSystem other(ordered);
  EXPECT_THROW(static_cast<void>(UncertainGraph::build(other, {}, guide_by_policy(other, policy))),
               InputError);
}

}  // namespace
}  // namespace orasp
