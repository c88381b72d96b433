// The integer program of fleets against brute force (tests/fleet_oracle.h) and the published
// values.

#include "orasp/fleet/fleet_mip.h"

#include <set>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/io/scenarios.h"
#include "orasp/mip/mip_solver.h"
#include "orasp/model/error.h"
#include "tests/fleet_oracle.h"
#include "tests/instances.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

class FleetMip : public testing::Test {
 protected:
  void SetUp() override {
    if (!mip_solver_available()) GTEST_SKIP() << "built without CBC";
  }
};

void expect_valid(const FleetProblem& fleet, const Result& result) {
  EXPECT_EQ(result.method, "mip");
  if (!result.has_plan()) return;
  const FleetEvaluation evaluation = evaluate(fleet, result.fleet_plan);
  EXPECT_TRUE(evaluation.valid) << evaluation.violations.front().message;
  const double good = fleet.objective() == FleetObjective::Makespan
                          ? static_cast<double>(evaluation.makespan)
                          : evaluation.travel;
  EXPECT_NEAR(result.reward, 0.0 - good, 1e-9);
}

/// The scenario with axes and a fleet: parts of `shape` along x and y, sites and depot as for the
/// lattice.
ProblemSpec shaped(ProblemSpec spec, const std::vector<std::string>& axes, std::size_t robots) {
  for (std::size_t c = 0; c < axes.size(); ++c) spec.connections[c].axis = axes[c];
  spec.fleet = Fleet{robots, {0, 0}, {{1, 0}, {-1, -2}, {-2, 2}, {2, -2}}};
  spec.objective = Objective::named("makespan");
  return spec;
}

constexpr std::uint64_t kMakespans = 60;
constexpr std::uint64_t kTravels = 25;

TEST_F(FleetMip, AgreesWithBruteForceOnTheFewestSteps) {
  for (std::uint64_t seed = 0; seed < some_of(kMakespans); ++seed) {
    const ProblemSpec spec = fleet_oracle::random_fleet(seed);
    SCOPED_TRACE(spec.name + " " + std::to_string(seed));
    const Problem problem(spec);
    const FleetProblem fleet(problem);
    const fleet_oracle::Truth truth = fleet_oracle::brute_force(spec, 0);
    const Result result = fleet_mip(fleet, {}, {});
    expect_valid(fleet, result);
    EXPECT_EQ(status_name(result.status), truth.makespan ? "optimal" : "infeasible");
    if (truth.makespan) {
      EXPECT_EQ(result.reward, 0.0 - static_cast<double>(*truth.makespan));
    }
    if (HasFailure()) return;
  }
}

TEST_F(FleetMip, AgreesWithBruteForceOnTheLeastTravel) {
  for (std::uint64_t seed = 100; seed < 100 + some_of(kTravels); ++seed) {
    const ProblemSpec spec = fleet_oracle::random_fleet(seed);
    SCOPED_TRACE(spec.name + " " + std::to_string(seed));
    const Problem problem = fleet_oracle::for_travel(Problem(spec));
    const FleetProblem fleet(problem);
    const fleet_oracle::Truth truth = fleet_oracle::brute_force(spec, 3);
    for (std::size_t steps = 1; steps <= 3; ++steps) {
      const Result result = fleet_mip(fleet, {.steps = steps}, {});
      expect_valid(fleet, result);
      const bool possible = truth.travel.at(steps) != fleet_oracle::kNever;
      EXPECT_EQ(status_name(result.status), possible ? "optimal" : "infeasible") << steps;
      if (possible) {
        EXPECT_NEAR(result.reward, 0.0 - truth.travel[steps], 1e-6) << steps;
      }
      if (HasFailure()) return;
    }
  }
}

// Published: 4 steps.
TEST_F(FleetMip, FindsTheFewestStepsForTheLattice) {
  const Problem problem = load_scenario("fleet-lattice");
  const FleetProblem fleet(problem);
  const Result result = fleet_mip(fleet, {}, {});
  expect_valid(fleet, result);
  EXPECT_EQ(status_name(result.status), "optimal");
  EXPECT_EQ(result.reward, -4);
}

TEST_F(FleetMip, ProvesThatTwoRobotsOrOneSiteDoNotDoForTheLattice) {
  ProblemSpec spec = load_scenario("fleet-lattice").spec();
  spec.fleet->sites.resize(1);
  const Problem problem(spec);
  EXPECT_EQ(status_name(fleet_mip(FleetProblem(problem), {}, {}).status), "infeasible");
}

// Four parts in a row: with 4 robots the middle goes first, then both halves: 2 steps. A 2x3 raster
// as the scenario 2x3.
TEST_F(FleetMip, AgreesWithSearchOnTheShapesOfTheSmallScenarios) {
  const ProblemSpec row =
      shaped(instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}}), {"-x", "-x", "-x"}, 4);
  const ProblemSpec raster =
      shaped(instances::assembly(6, {{1, 2}, {2, 3}, {1, 4}, {2, 5}, {3, 6}, {4, 5}, {5, 6}}),
             {"-x", "-x", "+y", "+y", "+y", "-x", "-x"}, 4);
  for (const auto& [spec, objective] :
       {std::pair{row, "makespan"}, {row, "fleet_travel"}, {raster, "makespan"}}) {
    const Problem problem = Problem(spec).with_objective(Objective::named(objective));
    const FleetProblem fleet(problem);
    const Result result = fleet_mip(fleet, {}, {});
    const Result other = solve(problem, "fleet-search");
    expect_valid(fleet, result);
    EXPECT_EQ(status_name(result.status), "optimal");
    EXPECT_NEAR(result.reward, other.reward, 1e-9);
  }
}

// Four pairs at 1, 2, 3 and 4 m from the depot, and two robots, which carry one pair at a time. The
// pair at j goes home by way of all nearer sites, j steps of 1 m for two parts: 2 (1 + 2 + 3 + 4) =
// 20 m^2 in 10 steps, two more than there are parts. In 8 steps it is 28.
TEST_F(FleetMip, TakesMoreStepsThanThereArePartsWhereThatSavesTravel) {
  ProblemSpec spec = instances::assembly(8, {{1, 2}, {3, 4}, {5, 6}, {7, 8}});
  for (Connection& connection : spec.connections) connection.axis = "+x";
  spec.fleet = Fleet{2, {0, 0}, {{1, 0}, {2, 0}, {3, 0}, {4, 0}}};
  spec.objective = Objective::named("makespan");
  const Problem problem = fleet_oracle::for_travel(Problem(spec));
  Task task(problem);
  task.steps = 10;
  for (const char* method : {"mip", "fleet-search"}) {
    const Result result = solve(task, method);
    EXPECT_EQ(status_name(result.status), "optimal") << method;
    EXPECT_NEAR(result.reward, -20, 1e-9) << method;
  }
}

TEST_F(FleetMip, SaysWhatItKnowsWhenItIsStopped) {
  const Problem problem = load_scenario("fleet-lattice");
  const FleetProblem fleet(problem);
  std::stop_source source;
  source.request_stop();
  Budget budget;
  budget.stop = source.get_token();
  const Result result = fleet_mip(fleet, {}, budget);
  EXPECT_EQ(status_name(result.status), "unknown");
  EXPECT_EQ(stop_name(result.stop), "interrupted");
  EXPECT_EQ(result.bound, -3);  // 9 parts, 4 robots
}

// 9 parts: the last state but one holds places for all; names are unique, and the model grows with
// the steps.
TEST(FleetMipModel, NamesEachColumnAndRowOnce) {
  ProblemSpec spec = load_scenario("fleet-lattice").spec();
  spec.precedence = {{"1-2", {"2-3"}, {"4-5", "5-6"}}};
  spec.limits = {.max_subassemblies = 3, .max_moved_parts = 2, .max_moved_mass = 5};
  spec.blocking = Blocking{{"+x", "-x"}, {{"1", "2", {"+x"}}}};
  const Problem problem(spec);
  for (const Problem& asked : {problem, fleet_oracle::for_travel(problem)}) {
    const FleetProblem fleet(asked);
    const MipModel model = fleet_mip_model(fleet, 5);
    std::set<std::string> names;
    for (const MipModel::Column& column : model.columns())
      EXPECT_TRUE(names.insert(column.name).second) << column.name;
    names.clear();
    for (const MipModel::Row& row : model.rows())
      EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_GT(model.num_columns(), fleet_mip_model(fleet, 4).num_columns());
    // Published: 6,432 binary columns for these parts, sites, robots and steps.
    EXPECT_LT(model.num_integers(), 6432U / 4);
  }
}

TEST(FleetMipModel, RefusesWhatCannotBeBuiltWithItsSize) {
  const Problem problem = fleet_oracle::for_travel(load_scenario("fleet-hubble"));
  try {
    (void)fleet_mip_model(FleetProblem(problem), 1000);
    FAIL() << "no error";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("1000 steps"), std::string::npos) << text;
    EXPECT_NE(text.find("at most 500000"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace orasp
