#include "orasp/planners/uncertain_search.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/graph/uncertain_graph.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/random.h"
#include "orasp/planners/uncertain_value_iteration.h"
#include "tests/checks.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

// The search finds what listing all states that attempts lead to finds; stopped anywhere before,
// its bound is not below that and its policy earns no more.
TEST(UncertainSearch, AgreesWithValueIterationAndHoldsWhereverItIsStopped) {
  int solved = 0;
  int infeasible = 0;
  int stopped = 0;
  for (std::uint64_t seed = 0; seed < some_of(3000U); ++seed) {
    const Problem problem(make_uncertain(random_problem(seed), seed));
    if (!problem.uncertain() || problem.num_connections() > 8) continue;
    const TransitionSystem system(problem);
    if (system.wide() || uncertain_search_obstacle(system)) continue;
    const std::string what = "seed " + std::to_string(seed);
    const Result truth = uncertain_value_iteration(system, {}, {});
    const Result found = uncertain_search(system, {});
    if (!truth.has_plan()) {
      EXPECT_EQ(found.status, Status::Infeasible) << what;
      ++infeasible;
      continue;
    }
    const double tolerance = 10 * reward_tolerance(truth.reward);
    EXPECT_EQ(found.status, Status::Optimal) << what;
    EXPECT_NEAR(found.reward, truth.reward, tolerance) << what;
    ++solved;
    for (const std::uint64_t expansions : {1, 3, 10}) {
      Budget budget;
      budget.max_expansions = expansions;
      const Result part = uncertain_search(system, budget);
      if (part.bound) {
        EXPECT_GE(*part.bound, truth.reward - tolerance) << what << ", " << expansions;
      }
      if (!part.has_plan()) continue;
      if (part.status != Status::Optimal) ++stopped;
      EXPECT_LE(part.reward, truth.reward + tolerance) << what << ", " << expansions;
      if (part.status == Status::Optimal) {
        EXPECT_NEAR(part.reward, truth.reward, tolerance) << what << ", " << expansions;
      }
    }
  }
  EXPECT_GE(solved, more_than(1000));
  EXPECT_GE(infeasible, more_than(50));
  EXPECT_GE(stopped, more_than(500));
}

/// A built-in problem whose attempts succeed nine times in ten, every tenth breaking a neighbour.
Problem with_breaking_neighbours(const std::string& name, std::uint64_t seed) {
  ProblemSpec spec = load_scenario(name).spec();
  const Problem plain(spec);
  SplitMix64 random(seed);
  for (std::size_t c = 0; c < spec.connections.size(); ++c) spec.connections[c].success = 0.9;
  for (std::size_t c = 0; c < spec.connections.size(); c += 10) {
    const auto [u, v] = plain.ends(static_cast<ConnectionIndex>(c));
    for (std::size_t d = 0; d < spec.connections.size(); ++d) {
      const auto& ends = plain.ends(static_cast<ConnectionIndex>(d));
      const bool near = ends[0] == u || ends[0] == v || ends[1] == u || ends[1] == v;
      if (d != c && near && spec.connections[c].on_failure.breaks.empty() && random.uniform() < 0.7)
        spec.connections[c].on_failure.breaks = {
            plain.connection_id(static_cast<ConnectionIndex>(d))};
    }
  }
  return Problem(spec);
}

TEST(UncertainSearch, ProvesTheTelescopeLikeValueIteration) {
  const Problem problem = with_breaking_neighbours("hubble-upc", 1);
  const TransitionSystem system(problem);
  const Result truth = uncertain_value_iteration(system, {}, {});
  const Result found = uncertain_search(system, {});
  ASSERT_EQ(found.status, Status::Optimal);
  EXPECT_NEAR(found.reward, truth.reward, 1e-9);
  EXPECT_LT(found.statistics.expanded, truth.statistics.expanded / 4);
}

}  // namespace
}  // namespace orasp
