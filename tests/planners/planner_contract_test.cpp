// What every planner of the catalogue must do, whatever its method: each row goes through the same
// checks. A planner added to the table is tested by being there.

#include <algorithm>
#include <chrono>
#include <limits>
#include <stop_token>
#include <string>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/io/formula_parser.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/error.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/model/validate.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

class PlannerContract : public testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override {
    const Problem problem(instances::one_connection());
    if (const auto reason = obstacle(problem, planner().name)) GTEST_SKIP() << *reason;
  }
  [[nodiscard]] const Planner& planner() const { return *one_robot_planners()[GetParam()]; }
  [[nodiscard]] Result run(const Problem& problem, const Budget& budget = {},
                           const Options& options = quick_options()) const {
    return solve(problem, planner().name, options, budget);
  }
  /// Whether the method takes the problem where it has all the time and memory that there are.
  [[nodiscard]] bool takes(const Problem& problem) const {
    return planner().role != Role::Baseline && !obstacle(problem, planner().name, quick_options());
  }
  /// Whether it holds H: then no table of a few bytes is enough for it.
  [[nodiscard]] bool builds_graph() const {
    const Problem problem = load_scenario("hubble");
    Budget budget;
    budget.max_bytes = 64 * 1024;
    const auto reason = obstacle(problem, planner().name, quick_options(), budget);
    return takes(problem) && reason && reason->find("state-action graph") != std::string::npos;
  }
  /// Runs it on a problem small enough for brute force and checks all that must hold of the answer.
  Result run_checked(const ProblemSpec& spec, const Budget& budget = {}) const {
    const Problem problem(spec);
    const Result result = run(problem, budget);
    expect_honest(problem, oracle::brute_force(spec), planner(), result);
    return result;
  }
  /// A plan, if there is one, is legal and worth what it says; for problems too large for brute
  /// force.
  void expect_legal(const Problem& problem, const Result& result) const {
    if (!result.has_plan()) {
      EXPECT_TRUE(result.sequence.empty());
      return;
    }
    const oracle::OracleReplay replay = oracle::replay(problem.spec(), result.sequence);
    EXPECT_TRUE(replay.valid);
    EXPECT_NEAR(replay.reward, result.reward, reward_tolerance(result.reward));
    if (result.bound) {
      EXPECT_GE(*result.bound, result.reward - reward_tolerance(result.reward));
    }
  }
};

// What hubble's best plan earns under `cubesat`.
constexpr double kHubble = -0.9902;

TEST_P(PlannerContract, EmptyAssemblyHasTheEmptyPlan) {
  for (const ProblemSpec& spec :
       {instances::nothing(), instances::one_part(), instances::assembly(3, {})}) {
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      ProblemSpec turned = spec;
      turned.direction = direction;
      const Result result = run_checked(turned);
      EXPECT_EQ(status_name(result.status), "optimal");
      EXPECT_EQ(result.reward, 0);
      EXPECT_TRUE(result.sequence.empty());
    }
  }
}

TEST_P(PlannerContract, SolvesTheTinyAssemblies) {
  EXPECT_NEAR(run_checked(instances::one_connection()).reward, 1, 1e-12);
  EXPECT_NEAR(run_checked(instances::self_connection()).reward, 1, 1e-12);
  EXPECT_NEAR(run_checked(instances::chain_of_three()).reward, 0.7785, 1e-12);
  EXPECT_NEAR(run_checked(instances::two_pieces()).reward, 0.8066, 1e-12);
  EXPECT_NEAR(run_checked(instances::sandwich()).reward, 0.7785, 1e-12);
}

TEST_P(PlannerContract, ExactMethodsSeeThroughTheGreedyTrap) {
  const Result result = run_checked(instances::greedy_trap());
  if (planner().exact) {
    EXPECT_NEAR(result.reward, 0.5570, 1e-12);
  }
}

TEST(Greedy, FallsIntoTheGreedyTrap) {
  EXPECT_NEAR(solve(Problem(instances::greedy_trap()), "greedy").reward, 0.5450, 1e-12);
}

TEST_P(PlannerContract, FindsThePlanBehindADeadEnd) {
  const Result result = run_checked(instances::sandwich());
  EXPECT_EQ(result.sequence, (std::vector<ConnectionIndex>{1, 2, 0}));
}

TEST_P(PlannerContract, ProvesThatABlockedAssemblyHasNoPlan) {
  EXPECT_EQ(status_name(run_checked(instances::boxed_in()).status), "infeasible");
}

TEST_P(PlannerContract, SaysThatTheStartHasTooManySubassemblies) {
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    ProblemSpec spec = instances::two_pieces();
    spec.limits.max_subassemblies = 1;
    spec.direction = direction;
    const Result result = run_checked(spec);
    EXPECT_EQ(status_name(result.status), "infeasible");
    ASSERT_FALSE(result.notes.empty());
    EXPECT_NE(result.notes.front().find("2 subassemblies"), std::string::npos)
        << result.notes.front();
  }
}

TEST_P(PlannerContract, NamesTheCycleOfAPrecedenceThatCannotBeMet) {
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    ProblemSpec spec = instances::locked_ring();
    spec.direction = direction;
    const Result result = run_checked(spec);
    EXPECT_EQ(status_name(result.status), "infeasible");
    ASSERT_FALSE(result.notes.empty());
    for (const char* id : {"1-2", "2-3", "1-3"}) {
      EXPECT_NE(result.notes.front().find(id), std::string::npos) << result.notes.front();
    }
  }
}

TEST_P(PlannerContract, IsRepeatable) {
  const Problem problem = load_scenario("2x3");
  Options options;
  options.seed = 42;
  const Result result = run(problem, {}, options);
  EXPECT_EQ(result.seed, 42U);
  expect_same_answer(result, run(problem, {}, options));
}

// hubble-upc: 243,787 states, enough for layers to be shared between threads.
TEST_P(PlannerContract, ThreadsDoNotChangeTheAnswer) {
  const Problem problem = load_scenario("hubble-upc");
  if (!takes(problem)) return;
  Budget two;
  two.threads = 2;
  expect_same_answer(run(problem), run(problem, two));
}

// A limit that is over before the start. Whoever still finishes must be right; a planner that
// builds or searches all of hubble (12,096 states) cannot have.
TEST_P(PlannerContract, StopsAtATimeLimitOfZero) {
  const Problem problem = load_scenario("hubble");
  if (!takes(problem)) return;
  const auto start = std::chrono::steady_clock::now();
  const Result result = run(problem, Budget::with_time_limit(0));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  expect_legal(problem, result);
  EXPECT_NE(status_name(result.status), "infeasible");
  if (result.status == Status::Optimal) {
    EXPECT_NEAR(result.reward, kHubble, 1e-9);
  }
  if (planner().exact) {
    EXPECT_EQ(stop_name(result.stop), "time limit");
    EXPECT_NE(status_name(result.status), "optimal");
  }
}

TEST_P(PlannerContract, StopsWhenCancelledBeforeTheStart) {
  const Problem problem = load_scenario("hubble");
  if (!takes(problem)) return;
  std::stop_source source;
  source.request_stop();
  Budget budget;
  budget.stop = source.get_token();
  const auto start = std::chrono::steady_clock::now();
  const Result result = run(problem, budget);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  expect_legal(problem, result);
  if (planner().exact) {
    EXPECT_EQ(stop_name(result.stop), "interrupted");
    EXPECT_NE(status_name(result.status), "optimal");
  }
}

// Interrupted from outside while it works, at its third word of progress.
TEST_P(PlannerContract, StopsWhenCancelledOnTheWay) {
  const Problem problem = load_scenario("hubble-free").with_objective(chance_objective());
  if (!takes(problem)) return;
  std::stop_source source;
  int calls = 0;
  Budget budget;
  budget.stop = source.get_token();
  budget.progress = [&](const Progress&) {
    if (++calls == 3) source.request_stop();
  };
  const Result result = run(problem, budget);
  expect_legal(problem, result);
  EXPECT_NE(status_name(result.status), "infeasible");
  if (planner().exact) {
    EXPECT_GE(calls, 3) << "no progress was reported";
    EXPECT_EQ(stop_name(result.stop), "interrupted");
    EXPECT_TRUE(result.has_plan());
    EXPECT_NE(status_name(result.status), "optimal");
  }
}

// Every limit on expansions gives an honest answer; without one the planner says what brute force
// says.
TEST_P(PlannerContract, IsHonestAtEveryExpansionLimit) {
  for (const ProblemSpec& spec :
       {instances::greedy_trap(), instances::sandwich(), instances::boxed_in(),
        instances::assembly(5, {{1, 2}, {2, 3}, {3, 4}, {4, 5}, {1, 5}})}) {
    for (const std::uint64_t limit : {0U, 1U, 2U, 3U, 5U, 8U, 13U, 21U, 34U, 55U, 1000U}) {
      SCOPED_TRACE(limit);
      Budget budget;
      budget.max_expansions = limit;
      run_checked(spec, budget);
    }
  }
}

TEST_P(PlannerContract, StopsAtAnExpansionLimitOnALargerProblem) {
  const Problem problem = load_scenario("hubble").with_objective(chance_objective());
  if (!takes(problem)) return;
  Budget budget;
  budget.max_expansions = 100;
  const Result result = run(problem, budget);
  expect_legal(problem, result);
  EXPECT_NE(status_name(result.status), "infeasible");
  if (result.status == Status::Optimal) {
    EXPECT_NEAR(result.reward, solve(problem, "value-iteration").reward, 1e-9);
  }
  if (planner().exact && !builds_graph()) {
    EXPECT_EQ(stop_name(result.stop), "expansion limit");
  }
}

// 64 KiB do not hold H of hubble: refused in advance, or stopped with what there is.
TEST_P(PlannerContract, KeepsToATinyMemoryLimit) {
  const Problem problem = load_scenario("hubble");
  if (!takes(problem)) return;
  Budget budget;
  budget.max_bytes = 64 * 1024;
  try {
    const Result result = run(problem, budget);
    expect_legal(problem, result);
    EXPECT_FALSE(builds_graph()) << "H cannot have been built";
    if (result.stop == Stop::None) {
      EXPECT_LE(result.statistics.peak_bytes, budget.max_bytes);
    } else {
      EXPECT_EQ(stop_name(result.stop), "memory limit");
      EXPECT_NE(status_name(result.status), "optimal");
      EXPECT_LE(result.statistics.peak_bytes, 16 * budget.max_bytes);
    }
  } catch (const InputError& error) {
    EXPECT_TRUE(builds_graph()) << error.what();
  }
}

// 499 connections: 2^499 states. Who needs H says so at once, with the size and what to use
// instead; the others answer or stop at their limit.
TEST_P(PlannerContract, RefusesOrSurvivesAChainOf500Parts) {
  const Problem problem(chain(500));
  const auto start = std::chrono::steady_clock::now();
  try {
    const Result result = run(problem, Budget::with_time_limit(percent_of_seeds() < 100 ? 2 : 0.3));
    EXPECT_FALSE(builds_graph());
    expect_legal(problem, result);
    EXPECT_NE(status_name(result.status), "infeasible");
    EXPECT_TRUE(result.has_plan());
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text, obstacle(problem, planner().name, quick_options()));
    EXPECT_NE(text.find(planner().name), std::string::npos) << text;
    // What it recommends takes the problem.
    const std::size_t use = text.find("; use ");
    ASSERT_NE(use, std::string::npos) << text;
    std::size_t named = 0;
    for (const Planner* const other : one_robot_planners()) {
      const std::string name(other->name);
      const std::size_t at = text.find(name, use);
      if (at == std::string::npos ||
          (at + name.size() < text.size() && text[at + name.size()] != ',' &&
           text[at + name.size()] != ' '))
        continue;
      ++named;
      EXPECT_FALSE(obstacle(problem, other->name)) << text;
    }
    EXPECT_GE(named, 2U) << text;
  }
  // What ignores its limit takes minutes.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

// 0 / 0 while three connections are present, a number before and after.
TEST_P(PlannerContract, ARewardThatIsNotANumberIsAnInputError) {
  ProblemSpec expression = instances::greedy_trap();
  expression.objective = {"expression", Expression{.formula = "(before - 2) / (before - 2)",
                                                   .constants = {},
                                                   .depot = {},
                                                   .compiler = compile_formula}};
  EXPECT_THROW((void)run(Problem(expression)), InputError);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    ProblemSpec callable = instances::greedy_trap();
    callable.objective = {
        "callable", Callable{.name = "bad",
                             .reward = [bad](const Step& s) { return s.before == 2 ? bad : 0; },
                             .least = -1,
                             .greatest = 1}};
    EXPECT_THROW((void)run(Problem(callable)), InputError);
  }
}

// Several threads may ask a planner at once about one problem; nothing is kept between calls.
TEST_P(PlannerContract, KeepsNothingBetweenCalls) {
  const Problem first(instances::greedy_trap());
  const Problem second(instances::sandwich());
  const Result before = run(first);
  (void)run(second);
  expect_same_answer(before, run(first));
}

INSTANTIATE_TEST_SUITE_P(Catalogue, PlannerContract,
                         testing::Range<std::size_t>(0, one_robot_planners().size()),
                         [](const auto& row) {
                           std::string name(one_robot_planners()[row.param]->name);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(Catalogue, HoldsThePlannersOfTheContractOnce) {
  for (const char* name :
       {"value-iteration", "dijkstra", "bellman-ford", "orasp-search", "exhaustive"}) {
    EXPECT_TRUE(find_planner(name).exact) << name;
  }
  for (const char* name : {"greedy", "random"}) EXPECT_FALSE(find_planner(name).exact) << name;
  for (const Planner& planner : planners()) {
    EXPECT_EQ(&find_planner(planner.name), &planner);
    EXPECT_FALSE(planner.summary.empty());
  }
}

TEST(Catalogue, NamesTheMethodsThereAreForAnUnknownOne) {
  try {
    (void)solve(Problem(instances::one_connection()), "astr");
    FAIL() << "no error";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("unknown method \"astr\""), std::string::npos) << text;
    for (const Planner& planner : planners())
      EXPECT_NE(text.find(planner.name), std::string::npos) << text;
  }
}

// A different seed must be able to give a different sequence: ring of 8 has 8! sequences.
TEST(RandomPlanner, DependsOnTheSeed) {
  const Problem problem(chain(9));
  Options options;
  const Result first = solve(problem, "random", options);
  bool differs = false;
  for (options.seed = 2; options.seed < 6; ++options.seed) {
    differs |= solve(problem, "random", options).sequence != first.sequence;
  }
  EXPECT_TRUE(differs);
}

}  // namespace
}  // namespace orasp
