#include "orasp/planners/and_or.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"
#include "orasp/orasp.h"
#include "tests/checks.h"
#include "tests/fault.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// A cut costs as many as the piece has parts: the cheapest plan halves.
Objective sizes_of_pieces() {
  return {"expression", Expression{.formula = "-separates*(moved_parts+kept_parts)",
                                   .constants = {},
                                   .depot = {},
                                   .compiler = compile_formula}};
}

Result run(const Problem& problem, const Budget& budget = {}) {
  const TransitionSystem system(problem);
  return and_or(system, {}, budget);
}

void expect_optimum(const Problem& problem, double reward, double tolerance = 1e-9) {
  const Result result = run(problem);
  EXPECT_EQ(status_name(result.status), "optimal");
  EXPECT_NEAR(result.reward, reward, tolerance);
  const Evaluation replay = evaluate(problem, result.sequence);
  EXPECT_TRUE(replay.valid);
  EXPECT_NEAR(replay.reward, reward, tolerance);
}

// Sums of losses are rounded in another order than limits are: neither may end a search early or
// lose its plan.
TEST(AndOr, ProvesManyTreesAndGraphsWhereHalvingIsBest) {
  for (int seed = 1; seed <= 12; ++seed) {
    for (const std::string& name :
         {"tree:150:" + std::to_string(seed), "random:40:60:" + std::to_string(seed)}) {
      SCOPED_TRACE(name);
      const Problem problem = load_scenario(name).with_objective(sizes_of_pieces());
      const Result result = run(problem);
      EXPECT_EQ(status_name(result.status), "optimal");
      EXPECT_EQ(result.reward, evaluate(problem, result.sequence).reward);
    }
  }
}

// A star can only be taken apart arm by arm: n + (n - 1) + ... + 2, which the bound by arms knows
// and sizes do not.
TEST(PieceGains, KnowsWhatAHubCosts) {
  std::vector<std::pair<int, int>> arms;
  for (int arm = 2; arm <= 12; ++arm) arms.emplace_back(1, arm);
  const Problem problem = Problem(instances::assembly(12, arms)).with_objective(sizes_of_pieces());
  const TransitionSystem system(problem);
  const PieceGains gains(system);
  EXPECT_EQ(gains.by_arms(12, 11), -(12 * 13 / 2 - 1));
  EXPECT_GT(gains.by_size(12), gains.by_arms(12, 11));
  expect_optimum(problem, -(12 * 13 / 2 - 1));
}

// At most three parts move at a time: what they cost is shared among them by prices, and the plan
// peels along them.
TEST(AndOr, ComesWithinAPercentOfTheBoundWhereGroupsOfThreeMove) {
  Limits limits;
  limits.max_moved_parts = 3;
  limits.max_subassemblies = 4;
  ProblemSpec spec = grid(7, 7);
  SplitMix64 random(11);
  for (Part& part : spec.parts) part.mass = 1 + static_cast<double>(random.below(90)) / 10;
  spec.limits = limits;
  spec.objective = Objective::named("time");
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const Result result = and_or(system, {.rounds = 2}, Budget{});
  ASSERT_TRUE(result.has_plan());
  ASSERT_TRUE(result.bound.has_value());
  EXPECT_TRUE(evaluate(problem, result.sequence).valid);
  EXPECT_LE(*result.bound - result.reward, 0.01 * std::abs(result.reward));
  PieceBound parts(system, PieceBound::Kind::Parts);
  EXPECT_GE(parts(system.start().view()), result.reward);
}

TEST(AndOr, ProvesTheKnownValues) {
  const std::pair<const char*, double> known[] = {
      {"3piece", 0.7785},  {"4brick", 0.5570},       {"4piece", 0.5570},     {"2x3", 0.3636},
      {"lattice", 0.0735}, {"hubble-free", -0.9902}, {"iss", -2.1506},       {"iss-upc", -2.1506},
      {"jwst", -16.7118},  {"jwst-upc", -16.7118},   {"hubble-upc", -0.9902}};
  for (const auto& [name, reward] : known) {
    SCOPED_TRACE(name);
    expect_optimum(load_scenario(name), reward);
  }
}

// The best rewards of the scenarios under other objectives, to six decimals, found by exhaustive
// search on the whole state-action graph. `indexed` is left out, since it sees more than the piece.
TEST(AndOr, ProvesTheKnownValuesOfOtherObjectives) {
  struct Row {
    const char* scenario;
    double cubesat_zone, custom, time, fuel, completion;
  };
  for (const Row& row : {Row{"3piece", 0.831100, -1.7, -5, -0.400746, 1197},
                         Row{"4brick", 0.691000, -4.2, -6, -0.601120, 1297},
                         Row{"4piece", 0.691000, -4.3, -7, -0.601120, 1296},
                         Row{"2x3", 0.497600, -6.6, -12, -1.001866, 1493},
                         Row{"lattice", 0.207500, -10.1, -20, -1.602985, 1788},
                         Row{"hubble", -0.856200, -21.8, -38, -3.807090, 2881}}) {
    const std::pair<const char*, double> bests[] = {{"cubesat_zone", row.cubesat_zone},
                                                    {"custom", row.custom},
                                                    {"time", row.time},
                                                    {"fuel", row.fuel},
                                                    {"completion", row.completion}};
    for (const auto& [type, best] : bests) {
      SCOPED_TRACE(std::string(row.scenario) + ", " + type);
      const Problem problem = load_scenario(row.scenario).with_objective(Objective::named(type));
      const Result result = run(problem);
      ASSERT_TRUE(result.bound.has_value());
      EXPECT_GE(*result.bound, best - 5.1e-7);
      EXPECT_LE(result.reward, best + 5.1e-7);
      // Precedence across pieces may leave it without a proof.
      if (problem.precedence().empty()) {
        EXPECT_EQ(status_name(result.status), "optimal");
      }
      if (result.status == Status::Optimal) {
        EXPECT_NEAR(result.reward, best, 5.1e-7);
      }
    }
  }
}

// By hand: a chain of n parts is best halved, so f(n) = n + f(floor(n/2)) + f(ceil(n/2)), f(1) = 0,
// less the last step's 2. Against a dynamic program written here, and the measured values.
TEST(AndOr, HalvesWhereACutCostsAsMuchAsThePieceHasParts) {
  std::vector<double> cost(101, 0);
  for (std::size_t n = 2; n <= 100; ++n)
    cost[n] = static_cast<double>(n) + cost[n / 2] + cost[n - n / 2];
  for (const std::size_t n : {2U, 3U, 7U, 16U, 50U, 100U}) {
    SCOPED_TRACE(n);
    expect_optimum(Problem(chain(n)).with_objective(sizes_of_pieces()), -cost[n]);
  }
  EXPECT_EQ(cost[100], 672);
  expect_optimum(load_scenario("hubble-free").with_objective(sizes_of_pieces()), -93);
  expect_optimum(load_scenario("iss").with_objective(sizes_of_pieces()), -164);
}

// Against value iteration. The bound is never below the truth; a claim of optimality or
// infeasibility is true; without precedence the pieces are independent, and the method must come to
// an end by itself.
TEST(AndOr, NeverClaimsMoreThanIsTrue) {
  std::size_t taken = 0;
  std::size_t optimal = 0;
  std::size_t infeasible = 0;
  std::size_t with_precedence = 0;
  std::size_t with_limits = 0;
  std::size_t with_blocking = 0;
  for (std::uint64_t seed = 0; seed < some_of(900U); ++seed) {
    const ProblemSpec spec = larger_random_problem(1000 + seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    if (and_or_obstacle(system)) {
      // Where no plan can exist (a cycle of precedence, too many subassemblies) even that is not
      // asked.
      if (!system.infeasibility()) {
        EXPECT_THROW((void)run(problem), InputError);
      }
      continue;
    }
    ++taken;
    if (!spec.precedence.empty()) ++with_precedence;
    if (spec.limits.max_subassemblies || spec.limits.max_moved_mass) ++with_limits;
    if (spec.blocking) ++with_blocking;
    const Result truth = solve(problem, "value-iteration");
    const Result result = run(problem);
    if (truth.has_plan()) {
      ASSERT_TRUE(result.has_plan()) << status_name(result.status);
      // No bound only where none on pieces is known.
      EXPECT_TRUE(result.bound || !PieceBound(system, PieceBound::Kind::Both).known());
      EXPECT_GE(result.bound.value_or(truth.reward), truth.reward - reward_tolerance(truth.reward));
      EXPECT_LE(result.reward, truth.reward + reward_tolerance(truth.reward));
      const Evaluation replay = evaluate(problem, result.sequence);
      EXPECT_TRUE(replay.valid);
      EXPECT_NEAR(replay.reward, result.reward, reward_tolerance(truth.reward));
    } else {
      EXPECT_EQ(status_name(result.status), "infeasible");
      ++infeasible;
    }
    if (result.status == Status::Optimal) {
      ++optimal;
      EXPECT_NEAR(result.reward, truth.reward, reward_tolerance(truth.reward));
    } else if (spec.precedence.empty() && truth.has_plan() && result.bound) {
      // What is left out then: pieces that wait for each other at the start, and connections
      // removed early.
      EXPECT_TRUE(spec.limits.max_subassemblies.has_value() || spec.blocking.has_value());
    }
    if (HasFailure()) return;
  }
  EXPECT_GE(taken, least_of(300U));
  EXPECT_GE(optimal, least_of(150U));
  EXPECT_GE(infeasible, least_of(30U));
  EXPECT_GE(with_precedence, least_of(100U));
  EXPECT_GE(with_limits, least_of(100U));
  EXPECT_GE(with_blocking, least_of(60U));
}

TEST(AndOr, SaysWhatItDoesNotTake) {
  ProblemSpec indexed = instances::greedy_trap();
  indexed.objective = Objective::named("indexed");
  ProblemSpec many = chain(kAndOrMostParts + 1);
  for (const ProblemSpec& spec : {indexed, many}) {
    const Problem problem(spec);
    EXPECT_EQ(fault_of([&] { return run(problem); }),
              "and-or takes whole problems of at most 1024 parts, whose objective sees nothing but "
              "the piece that is cut or put together");
    EXPECT_NE(fault_of([&] { return solve(problem, "and-or"); }).find("; use auto"),
              std::string::npos);
  }
  EXPECT_TRUE(run(Problem(chain(kAndOrMostParts))).has_plan());
}

// Stopped anywhere, the bound is above the optimum and the plan, if any, below it.
TEST(AndOr, GivesATrueBoundWhereverItIsStopped) {
  const Problem problem = load_scenario("grid:5x5").with_objective(sizes_of_pieces());
  const double best = solve(problem, "auto").reward;
  std::size_t stopped = 0;
  for (std::uint64_t limit = 1; limit < 100'000; limit *= 3) {
    SCOPED_TRACE(limit);
    Budget budget;
    budget.max_expansions = limit;
    const Result result = run(problem, budget);
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_GE(*result.bound, best - 1e-6);
    if (result.stop != Stop::None) ++stopped;
    if (result.has_plan()) {
      EXPECT_LE(result.reward, best + 1e-6);
      EXPECT_TRUE(evaluate(problem, result.sequence).valid);
    }
  }
  EXPECT_GE(stopped, 1U);
}

TEST(AndOr, ThreadsDoNotChangeTheAnswer) {
  for (const char* name : {"grid:5x5", "grid:7x7", "jwst-upc"}) {
    const Problem problem = load_scenario(name).with_objective(sizes_of_pieces());
    Budget budget;
    budget.max_expansions = 1'500;
    const Result one = run(problem, budget);
    for (const unsigned threads : {2U, 3U}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(threads));
      budget.threads = threads;
      expect_same_answer(one, run(problem, budget));
    }
  }
}

}  // namespace
}  // namespace orasp
