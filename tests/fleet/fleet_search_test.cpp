#include "orasp/fleet/fleet_search.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/io/scenarios.h"
#include "tests/fault.h"
#include "tests/fleet_oracle.h"
#include "tests/instances.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

constexpr double kNever = fleet_oracle::kNever;

Problem lattice(std::size_t robots, std::size_t sites) {
  ProblemSpec spec = load_scenario("fleet-lattice").spec();
  spec.fleet->robots = robots;
  spec.fleet->sites.resize(sites);
  return Problem(std::move(spec));
}

/// What must hold of any answer: a plan keeps the rules and is worth what it says, and its bound is
/// true.
void expect_honest(const FleetProblem& fleet, const Result& result) {
  if (!result.has_plan()) {
    EXPECT_TRUE(result.fleet_plan.steps.empty());
    return;
  }
  const FleetEvaluation evaluation = evaluate(fleet, result.fleet_plan);
  for (const FleetViolation& violation : evaluation.violations)
    ADD_FAILURE() << "step " << violation.step << ": " << violation.message;
  EXPECT_NEAR(evaluation.travel, result.fleet_plan.travel(), 1e-9);
  EXPECT_NEAR(result.reward,
              fleet.objective() == FleetObjective::Makespan
                  ? -static_cast<double>(evaluation.makespan)
                  : -evaluation.travel,
              1e-9);
  if (result.bound) {
    EXPECT_GE(*result.bound, result.reward - 1e-9);
  }
  if (result.status == Status::Optimal) {
    EXPECT_EQ(result.bound, result.reward);
  }
}

Result run(const Problem& problem, const FleetOptions& options, const Budget& budget = {}) {
  const FleetProblem fleet(problem);
  Result result = fleet_search(fleet, options, budget);
  expect_honest(fleet, result);
  return result;
}

Result fewest_steps(const Problem& problem) {
  return run(problem, {});
}
Result least_travel(const Problem& problem, std::optional<std::size_t> steps = {}) {
  return run(fleet_oracle::for_travel(problem), {.steps = steps});
}

TEST(FleetSearch, FindsThePublishedFewestStepsOfTheLattice) {
  const Result result = fewest_steps(lattice(4, 4));
  EXPECT_EQ(result.status, Status::Optimal);
  EXPECT_EQ(result.fleet_plan.makespan(), 4U);
  EXPECT_EQ(result.reward, -4);
}

TEST(FleetSearch, FindsThePublishedLeastTravelOfTheLattice) {
  for (const auto& [steps, travel] :
       std::vector<std::pair<std::size_t, double>>{{4, 81}, {5, 58}, {6, 54}, {7, 54}, {12, 54}}) {
    const Result result = least_travel(lattice(4, 4), steps);
    EXPECT_EQ(result.status, Status::Optimal) << steps;
    EXPECT_EQ(result.fleet_plan.travel(), travel) << steps;
    EXPECT_LE(result.fleet_plan.makespan(), steps);
  }
  EXPECT_EQ(least_travel(lattice(4, 4)).fleet_plan.travel(),
            81);  // in the fewest steps, which are 4
  EXPECT_EQ(least_travel(lattice(4, 4)).steps_allowed, 4U);
  EXPECT_EQ(least_travel(lattice(4, 4), 3).status, Status::Infeasible);
}

TEST(FleetSearch, AgreesWithThePublishedTableOfRobotsAndSites) {
  constexpr std::size_t kNoPlan = 0;
  struct Row {
    std::size_t robots, sites, steps;
  };
  for (const auto& [robots, sites, steps] :
       {Row{3, 1, kNoPlan}, Row{3, 2, 5}, Row{3, 4, 5}, Row{4, 1, kNoPlan}, Row{4, 2, 5},
        Row{4, 3, 4}, Row{2, 4, kNoPlan}, Row{2, 1, kNoPlan}, Row{1, 4, kNoPlan}}) {
    const Result result = fewest_steps(lattice(robots, sites));
    EXPECT_EQ(result.status, steps == kNoPlan ? Status::Infeasible : Status::Optimal)
        << robots << " robots, " << sites << " sites";
    EXPECT_EQ(result.fleet_plan.makespan(), steps) << robots << " robots, " << sites << " sites";
    EXPECT_EQ(result.notes.empty(), steps != kNoPlan);
  }
}

// 20 parts and 4 robots: 5 steps at least; 32 parts and 6 robots: 6. Both are reached, and without
// moving a subassembly, so that every part pays the 1 m^2 from the nearest site.
TEST(FleetSearch, MeetsTheBoundOfPartsByRobotsOnHubbleAndTheStation) {
  EXPECT_EQ(fewest_steps(load_scenario("fleet-hubble")).reward, -5);
  EXPECT_EQ(least_travel(load_scenario("fleet-hubble")).reward, -20);
  EXPECT_EQ(fewest_steps(load_scenario("fleet-iss")).reward, -6);
  EXPECT_EQ(least_travel(load_scenario("fleet-iss"), 7).reward, -32);
}

/// Whether the connections of the product have a cycle.
bool has_cycle(const Problem& problem) {
  std::vector<PartIndex> piece(problem.num_parts());
  std::iota(piece.begin(), piece.end(), PartIndex{0});
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const PartIndex a = piece[problem.ends(c)[0]];
    const PartIndex b = piece[problem.ends(c)[1]];
    if (a == b) return true;
    std::ranges::replace(piece, a, b);
  }
  return false;
}

class FleetAgreement : public testing::TestWithParam<std::uint64_t> {};

TEST_P(FleetAgreement, EveryMethodIsRightAboutEveryRandomProblem) {
  constexpr std::uint64_t kSeeds = 60;
  constexpr std::size_t kSteps = 5;
  for (std::uint64_t i = 0; i < some_of(kSeeds); ++i) {
    const std::uint64_t seed = GetParam() * kSeeds + i;
    const ProblemSpec spec = fleet_oracle::random_fleet(seed);
    SCOPED_TRACE(spec.name);
    const fleet_oracle::Truth truth = fleet_oracle::brute_force(spec, kSteps);
    const Problem problem(spec);
    const Problem travelling = fleet_oracle::for_travel(problem);
    const FleetProblem fleet(problem);
    for (const Planner& planner : planners()) {
      // The integer program takes seconds where others take a millisecond: fleet_mip_test.cpp
      // compares it.
      if (planner.role == Role::Baseline) continue;
      SCOPED_TRACE(std::string(planner.name));
      if (const auto reason = obstacle(problem, planner.name)) {
        EXPECT_EQ(fault_of([&] { return solve(problem, planner.name); }), *reason);
        EXPECT_TRUE(!planner.fleets || has_cycle(problem)) << *reason;
        continue;
      }
      const Result fewest = solve(problem, planner.name);
      expect_honest(fleet, fewest);
      if (!truth.makespan) {
        EXPECT_FALSE(fewest.has_plan());
      }
      if (fewest.status == Status::Infeasible) {
        EXPECT_FALSE(truth.makespan);
      }
      if (fewest.status == Status::Optimal) {
        EXPECT_EQ(fewest.fleet_plan.makespan(), truth.makespan);
      }
      if (fewest.bound && truth.makespan) {
        EXPECT_GE(*fewest.bound, -static_cast<double>(*truth.makespan));
      }
      const bool settles = planner.exact || planner.role == Role::Chooser;
      if (settles) {
        EXPECT_EQ(fewest.status, truth.makespan ? Status::Optimal : Status::Infeasible);
      }
      for (std::size_t steps = 0; steps <= kSteps; ++steps) {
        Task task(travelling);
        if (steps > 0) task.steps = steps;
        const Result least = solve(task, planner.name);
        expect_honest(FleetProblem(travelling), least);
        const std::size_t within = steps == 0 ? truth.makespan.value_or(0) : steps;
        const double travel = steps == 0 && !truth.makespan ? kNever : truth.travel[within];
        if (least.has_plan()) {
          EXPECT_TRUE(steps == 0 || least.fleet_plan.makespan() <= steps);
        }
        if (least.status == Status::Optimal) {
          EXPECT_NEAR(least.fleet_plan.travel(), travel, 1e-9) << steps;
        }
        if (least.status == Status::Infeasible) {
          EXPECT_EQ(travel, kNever) << steps;
        }
        if (settles) {
          EXPECT_EQ(least.status, travel < kNever ? Status::Optimal : Status::Infeasible) << steps;
        }
      }
    }
    if (testing::Test::HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, FleetAgreement, testing::Range<std::uint64_t>(0, 8));

// The search counts them, which agrees with brute force.
TEST(FleetRandomProblems, AreOfEveryKind) {
  std::size_t feasible = 0;
  std::size_t infeasible = 0;
  std::size_t many_steps = 0;
  std::size_t longer_is_cheaper = 0;
  for (std::uint64_t seed = 0; seed < some_of(480U); ++seed) {
    const Problem problem(fleet_oracle::random_fleet(seed));
    const Result result = fewest_steps(problem);
    ++(result.has_plan() ? feasible : infeasible);
    if (!result.has_plan()) continue;
    const std::size_t steps = result.fleet_plan.makespan();
    many_steps += steps >= 3 ? 1 : 0;
    longer_is_cheaper +=
        least_travel(problem, steps + 2).reward > least_travel(problem, steps).reward ? 1 : 0;
  }
  EXPECT_GE(feasible, least_of(200U));
  EXPECT_GE(infeasible, least_of(100U));
  EXPECT_GE(many_steps, least_of(100U));
  EXPECT_GE(longer_is_cheaper, least_of(20U));
}

TEST(FleetSearch, HasAnEmptyPlanWhereNothingIsJoined) {
  ProblemSpec spec = instances::assembly(3, {});
  spec.fleet = Fleet{.robots = 1, .depot = {}, .sites = {{1, 0}}};
  spec.objective = Objective::named("makespan");
  EXPECT_EQ(fewest_steps(Problem(spec)).status, Status::Optimal);
  EXPECT_EQ(fewest_steps(Problem(spec)).reward, 0);
  EXPECT_EQ(least_travel(Problem(spec)).reward, 0);
}

TEST(FleetSearch, IsStoppedWithABoundAndAPlanIfThereIsOne) {
  const Problem problem = lattice(3, 4);
  for (std::uint64_t expansions = 0; expansions < 200; expansions += 7) {
    Budget budget;
    budget.max_expansions = expansions;
    const Result result = run(problem, {}, budget);
    EXPECT_TRUE(result.status == Status::Optimal || result.stop == Stop::ExpansionLimit);
    if (result.bound) {
      EXPECT_GE(*result.bound, -5);
    }
    const Result travel = run(fleet_oracle::for_travel(problem), {.steps = 6}, budget);
    EXPECT_TRUE(travel.status == Status::Optimal || travel.stop == Stop::ExpansionLimit);
  }
  std::stop_source source;
  source.request_stop();
  Budget cancelled;
  cancelled.stop = source.get_token();
  EXPECT_EQ(run(problem, {}, cancelled).stop, Stop::Cancelled);
}

TEST(FleetSearch, AnswersTheSameTwice) {
  const Problem problem = load_scenario("fleet-hubble");
  EXPECT_EQ(fewest_steps(problem).fleet_plan, fewest_steps(problem).fleet_plan);
  const Problem small = lattice(4, 3);
  EXPECT_EQ(least_travel(small).fleet_plan, least_travel(small).fleet_plan);
}

/// A row of parts, each off the next along x, whose ids say nothing about where they are.
ProblemSpec scrambled_row(std::size_t parts, std::size_t robots) {
  std::vector<std::pair<int, int>> joined;
  const auto place = [parts](std::size_t i) { return static_cast<int>(i * 7 % parts) + 1; };
  for (std::size_t i = 0; i + 1 < parts; ++i) joined.emplace_back(place(i), place(i + 1));
  ProblemSpec spec = instances::assembly(parts, joined);
  for (Connection& connection : spec.connections) connection.axis = "-x";
  spec.fleet = Fleet{.robots = robots, .depot = {}, .sites = {{1, 0}, {2, 0}, {3, 1}}};
  spec.objective = Objective::named("makespan");
  return spec;
}

// Rows of any names are of one shape, so that the search meets one state a length; the plan names
// the parts again, which the check of plans confirms.
TEST(FleetSearch, KnowsPiecesOfTheSameShape) {
  const Result result = fewest_steps(Problem(scrambled_row(30, 6)));
  EXPECT_EQ(result.status, Status::Optimal);
  EXPECT_LT(result.statistics.states, 20'000U);
}

// One word, then two, four and sixteen. A row on one site is freed at both ends.
TEST(FleetSearch, TakesMorePartsThanAWordHasBits) {
  for (const std::size_t parts : {60U, 66U, 130U, 258U}) {
    ProblemSpec spec = scrambled_row(parts, 2);
    spec.fleet->sites.resize(1);
    const Result result = fewest_steps(Problem(spec));
    EXPECT_EQ(result.status, Status::Optimal) << parts;
    EXPECT_EQ(result.reward, -static_cast<double>(parts / 2)) << parts;
  }
}

TEST(FleetSearch, SaysHowManyPartsItTakes) {
  ProblemSpec spec = instances::assembly(1025, {{1, 2}});
  spec.connections[0].axis = "+x";
  spec.fleet = Fleet{.robots = 2, .depot = {}, .sites = {{1, 0}}};
  spec.objective = Objective::named("makespan");
  const Problem problem(spec);
  EXPECT_EQ(fault_of([&] { return fleet_search(FleetProblem(problem), {}, {}); }),
            "fleet-search takes at most 1024 parts; this problem has 1025");
}

}  // namespace
}  // namespace orasp
