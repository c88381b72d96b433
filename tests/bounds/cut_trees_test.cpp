#include "orasp/bounds/cut_trees.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/objectives/retried.h"
#include "orasp/orasp.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// The problem with attempts that are made again until they succeed.
ProblemSpec with_retries(ProblemSpec spec, std::uint64_t seed) {
  SplitMix64 random(seed);
  spec.objective = Objective::named("cubesat");
  for (Connection& connection : spec.connections) connection.success = 0.5 + 0.5 * random.uniform();
  return spec;
}

/// The parts that hang together through `present`, a number for each part.
std::vector<std::size_t> components(const Problem& problem, const ConnectionSet& present) {
  std::vector<std::size_t> component(problem.num_parts());
  for (std::size_t p = 0; p < component.size(); ++p) component[p] = p;
  for (bool changed = true; changed;) {
    changed = false;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      if (!present.contains(c)) continue;
      const auto [u, v] = problem.ends(c);
      const std::size_t least = std::min(component[u], component[v]);
      changed = changed || component[u] != component[v];
      component[u] = component[v] = least;
    }
  }
  return component;
}

/// The cost of the cheapest set of connections that joins what `present` joins: all sets are tried.
double least_forest(const Problem& problem, const CutTrees& trees, const ConnectionSet& present) {
  const std::vector<std::size_t> joined = components(problem, present);
  double least = std::numeric_limits<double>::infinity();
  for (std::uint64_t chosen = 0; chosen < std::uint64_t{1} << problem.num_connections(); ++chosen) {
    ConnectionSet set(problem.num_connections());
    double cost = 0;
    bool within = true;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      if ((chosen >> static_cast<std::size_t>(c) & 1) == 0) continue;
      within = within && present.contains(c);
      set.insert(c);
      cost += trees.cost(c);
    }
    if (within && components(problem, set) == joined) least = std::min(least, cost);
  }
  return least;
}

TEST(CutTrees, AreTheLeastSpanningForestsAndTellWhatTakingAConnectionAwayChanges) {
  std::size_t looked_at = 0;
  for (std::uint64_t seed = 0; seed < some_of(120U); ++seed) {
    const Problem stated(with_retries(random_problem(seed), seed));
    if (!stated.only_retries()) continue;
    const Problem problem = attempts_paid(stated);
    const TransitionSystem system(problem);
    CutTrees trees(system);
    if (!trees.any()) continue;
    SplitMix64 random(seed + 1);
    for (int i = 0; i < 5; ++i) {
      ConnectionSet present(problem.num_connections());
      for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
        if (random.uniform() < 0.8) present.insert(c);
      }
      const double here = least_forest(problem, trees, present);
      ASSERT_NEAR(trees.of(present.view()), here, 1e-12) << "seed " << seed;
      trees.measure_changes(present.view());
      for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
        if (!present.contains(c)) continue;
        ConnectionSet next = present;
        next.erase(c);
        EXPECT_NEAR(trees.change(c), least_forest(problem, trees, next) - here, 1e-12)
            << "seed " << seed << ", connection " << static_cast<std::size_t>(c);
        ++looked_at;
      }
    }
    std::vector<PartIndex> all;
    for (PartIndex part = 0; part < problem.num_parts(); ++part) all.push_back(part);
    EXPECT_NEAR(trees.of_parts(all), trees.of(ConnectionSet::all(problem.num_connections()).view()),
                1e-12);
  }
  EXPECT_GE(looked_at, least_of(500U));
}

// What attempts cost that are alike costs nothing beside the bounds.
TEST(CutTrees, CostNothingWhereConnectionsAreAlike) {
  ProblemSpec spec = load_scenario("lattice").spec();
  for (Connection& connection : spec.connections) connection.success = 0.5;
  const Problem problem = attempts_paid(Problem(spec));
  EXPECT_FALSE(CutTrees(TransitionSystem(problem)).any());
}

}  // namespace
}  // namespace orasp
