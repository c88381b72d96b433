// find_order() against the oracle on the seeded random problems, from the start and from states in
// the middle.

#include "orasp/planners/feasibility.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "orasp/model/scenario_generators.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

constexpr std::uint64_t kSeeds = 900;

TEST(FindOrder, IsRightAboutEveryProblemAndItsOrderIsLegal) {
  std::size_t infeasible = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const oracle::OracleResult truth = oracle::brute_force(spec);
    const Feasibility found = find_order(spec, Budget{});
    ASSERT_EQ(status_name(found.status), truth.feasible ? "feasible" : "infeasible");
    infeasible += truth.feasible ? 0 : 1;
    if (!truth.feasible) continue;
    std::vector<ConnectionIndex> sequence = found.order;
    if (spec.direction == Direction::Assembly) std::ranges::reverse(sequence);
    ASSERT_TRUE(oracle::replay(spec, sequence).valid);
  }
  EXPECT_GE(infeasible, more_than(100U));
}

TEST(FindOrder, IsRightFromEveryStateThatCanBeReached) {
  std::size_t hopeless = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds / 3); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const oracle::World world(spec);
    if (world.start_infeasible()) continue;
    const std::size_t connections = problem.num_connections();
    for (const auto& [state, value] : oracle::brute_force(spec).best_to_go) {
      const ConnectionSet open = oracle::set_of(state);
      ConnectionSet from = open;
      ConnectionSet to(connections);
      if (spec.direction == Direction::Assembly) {
        from = ConnectionSet::all(connections);
        to = from;
        for_each_connection(open.view(), [&](ConnectionIndex c) { to.erase(c); });
      }
      const Feasibility found = find_order(problem, from, to, Budget{});
      ASSERT_EQ(status_name(found.status),
                std::isfinite(value) || open.empty() ? "feasible" : "infeasible");
      ASSERT_EQ(found.order.size(), found.status == Status::Feasible ? open.size() : 0U);
      hopeless += found.status == Status::Infeasible ? 1 : 0;
    }
  }
  EXPECT_GE(hopeless, more_than(100U));
}

// A chain whose cuts are limited: every order of the 300 connections would do, and none has to be
// undone.
TEST(FindOrder, DoesNotBranchWhereCutsDoNoHarm) {
  ProblemSpec spec = chain(300);
  spec.limits.max_moved_parts = 1;
  const Feasibility found = find_order(spec, Budget{});
  EXPECT_EQ(status_name(found.status), "feasible");
  EXPECT_EQ(found.expanded, 299U);
}

TEST(FindOrder, SaysWhatStoppedIt) {
  Budget budget;
  budget.max_expansions = 1;
  const Feasibility found = find_order(grid(4, 4), budget);
  EXPECT_EQ(status_name(found.status), "unknown");
  EXPECT_EQ(stop_name(found.stop), "expansion limit");
}

}  // namespace
}  // namespace orasp
