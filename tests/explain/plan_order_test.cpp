// The partial order of a plan: every order of the steps that keeps its pairs must be legal, by the
// oracle.

#include "orasp/explain/plan_order.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/random.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/planners/random_sequence.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using Sequence = std::vector<ConnectionIndex>;
using Pairs = std::vector<OrderedPair>;

/// Calls visit(positions) for every order of 0 .. steps - 1 that keeps the pairs, up to `most`;
/// returns how many.
std::size_t for_each_extension(const Pairs& pairs, std::size_t steps, std::size_t most,
                               const std::function<void(const std::vector<std::size_t>&)>& visit) {
  std::vector<std::size_t> waits(steps, 0);
  for (const auto& pair : pairs) ++waits[pair.second];
  std::vector<std::size_t> chosen;
  std::vector<bool> used(steps, false);
  std::size_t visited = 0;
  const std::function<void()> extend = [&] {
    if (visited >= most) return;
    if (chosen.size() == steps) {
      ++visited;
      visit(chosen);
      return;
    }
    for (std::size_t s = 0; s < steps; ++s) {
      if (used[s] || waits[s] != 0) continue;
      used[s] = true;
      chosen.push_back(s);
      for (const auto& [early, late] : pairs) waits[late] -= early == s ? 1 : 0;
      extend();
      for (const auto& [early, late] : pairs) waits[late] += early == s ? 1 : 0;
      chosen.pop_back();
      used[s] = false;
    }
  };
  extend();
  return visited;
}

/// A random order that keeps the pairs.
std::vector<std::size_t> random_extension(const Pairs& pairs, std::size_t steps,
                                          SplitMix64& random) {
  std::vector<std::size_t> waits(steps, 0);
  std::vector<std::vector<std::size_t>> later(steps);
  for (const auto& [early, late] : pairs) {
    ++waits[late];
    later[early].push_back(late);
  }
  std::vector<std::size_t> ready;
  for (std::size_t s = 0; s < steps; ++s) {
    if (waits[s] == 0) ready.push_back(s);
  }
  std::vector<std::size_t> order;
  while (!ready.empty()) {
    std::swap(ready[random.below(ready.size())], ready.back());
    order.push_back(ready.back());
    ready.pop_back();
    for (const std::size_t s : later[order.back()]) {
      if (--waits[s] == 0) ready.push_back(s);
    }
  }
  return order;
}

Sequence arranged(const Sequence& plan, const std::vector<std::size_t>& positions) {
  Sequence sequence;
  for (const std::size_t p : positions) sequence.push_back(plan[p]);
  return sequence;
}

/// No pair follows from the others, each goes forward, and they are sorted.
void expect_reduced(const Pairs& pairs, std::size_t steps) {
  EXPECT_TRUE(std::ranges::is_sorted(pairs));
  std::vector<std::vector<bool>> reach(steps, std::vector<bool>(steps, false));
  for (std::size_t early = steps; early-- > 0;) {
    for (const auto& pair : pairs) {
      ASSERT_LT(pair.first, pair.second);
      ASSERT_LT(pair.second, steps);
      if (pair.first != early) continue;
      reach[early][pair.second] = true;
      for (std::size_t s = 0; s < steps; ++s)
        if (reach[pair.second][s]) reach[early][s] = true;
    }
  }
  for (const auto& [early, late] : pairs) {
    for (std::size_t s = 0; s < steps; ++s)
      EXPECT_FALSE(reach[early][s] && reach[s][late]) << early << " " << s << " " << late;
  }
}

TEST(PlanOrder, EveryOrderThatKeepsItIsLegal) {
  std::size_t plans = 0, orders = 0, judged = 0, several = 0;
  for (std::uint64_t seed = 0; seed < some_of(900U); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    for (std::uint64_t draw = 1; draw <= 3; ++draw) {
      const Result result = random_sequence(system, {.seed = draw}, Budget{});
      if (!result.has_plan()) break;
      ++plans;
      const Pairs pairs = plan_order(problem, result.sequence);
      expect_reduced(pairs, result.sequence.size());
      const std::size_t found =
          for_each_extension(pairs, result.sequence.size(), 60, [&](const auto& positions) {
            ASSERT_TRUE(oracle::replay(spec, arranged(result.sequence, positions)).valid);
          });
      SplitMix64 random(seed * 3 + draw);
      for (int i = 0; i < 10; ++i) {
        const auto positions = random_extension(pairs, result.sequence.size(), random);
        ASSERT_EQ(positions.size(), result.sequence.size());
        ASSERT_TRUE(oracle::replay(spec, arranged(result.sequence, positions)).valid);
      }
      ASSERT_GE(found, 1U);
      orders += found;
      const bool limited = spec.limits.max_subassemblies || spec.limits.max_moved_parts ||
                           spec.limits.max_moved_mass || spec.blocking;
      judged += limited ? 1 : 0;
      several += limited && found > 1 ? 1 : 0;
      if (HasFailure()) return;
    }
  }
  EXPECT_GE(plans, more_than(1000U));
  EXPECT_GE(orders, more_than(10'000U));
  EXPECT_GE(judged, more_than(500U));
  EXPECT_GE(several, more_than(250U));
}

// All orders that keep the pairs, where nothing but precedence holds: exactly the legal ones that
// take the same way out of an `after_any`.
TEST(PlanOrder, ByPrecedenceAloneForbidsNothingElse) {
  ProblemSpec spec = instances::assembly(6, {{1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 6}});
  spec.precedence = {{"1-2", {"2-3", "4-5"}, {}}, {"2-3", {"4-5"}, {}}};
  const Problem problem(spec);
  const Sequence plan = {3, 1, 0, 2, 4};
  const Pairs pairs = plan_order(problem, plan);
  EXPECT_EQ(pairs, (Pairs{{0, 1}, {1, 2}}));  // 4-5, 2-3, 1-2; that 4-5 precedes 1-2 follows
  EXPECT_EQ(for_each_extension(pairs, 5, 1000, [](const auto&) {}),
            oracle::brute_force(spec).sequences);
}

TEST(PlanOrder, OfAnAlternativeTheEarliestIsKept) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.precedence = {{"1-2", {}, {"2-3", "3-4"}}};
  EXPECT_EQ(plan_order(Problem(spec), Sequence{2, 1, 0}), (Pairs{{0, 2}}));
  EXPECT_EQ(plan_order(Problem(spec), Sequence{1, 2, 0}), (Pairs{{0, 2}}));
  EXPECT_EQ(plan_order(Problem(spec), Sequence{2, 0, 1}), (Pairs{{0, 1}}));
  spec.direction = Direction::Assembly;
  EXPECT_EQ(plan_order(Problem(spec), Sequence{0, 1, 2}), (Pairs{{0, 2}}));
  EXPECT_EQ(plan_order(Problem(spec), Sequence{1, 0, 2}), (Pairs{{1, 2}}));
}

//   1 - 2        1-2 and 3-4 first (the second one cuts), then 1-3 and 2-4 in any order.
//   |   |
//   3 - 4
TEST(PlanOrder, KeepsTheCutTreeWhereCutsAreJudged) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {3, 4}, {1, 3}, {2, 4}});
  EXPECT_EQ(plan_order(Problem(spec), Sequence{0, 1, 2, 3}), Pairs{});
  spec.limits.max_moved_parts = 2;
  EXPECT_EQ(plan_order(Problem(spec), Sequence{0, 1, 2, 3}), (Pairs{{0, 1}, {1, 2}, {1, 3}}));
  spec.direction = Direction::Assembly;
  EXPECT_EQ(plan_order(Problem(spec), Sequence{3, 2, 1, 0}), (Pairs{{0, 2}, {1, 2}, {2, 3}}));
}

//   1 - 2 - 3 - 4 - 5 - 6 - 7 - 8, cut in the middle, then each half in its middle: three
//   subassemblies after 6-7 and before 1-2 goes are too many if two are allowed.
TEST(PlanOrder, KeepsTheNumberOfSubassemblies) {
  std::vector<std::pair<int, int>> row;
  for (int p = 1; p < 8; ++p) row.emplace_back(p, p + 1);
  ProblemSpec spec = instances::assembly(8, row);
  spec.limits.max_subassemblies = 3;
  const Sequence plan = {3, 1, 0, 2, 5, 4, 6};
  ASSERT_TRUE(oracle::replay(spec, plan).valid);
  const Pairs total = plan_order(Problem(spec), plan);
  EXPECT_EQ(total, (Pairs{{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 6}}));
  spec.limits.max_subassemblies = 4;
  EXPECT_EQ(plan_order(Problem(spec), plan),
            (Pairs{{0, 1}, {0, 4}, {1, 2}, {1, 3}, {4, 5}, {4, 6}}));
}

TEST(PlanOrder, OfNothingIsEmpty) {
  EXPECT_TRUE(plan_order(Problem(instances::nothing()), {}).empty());
  ProblemSpec spec = instances::self_connection();
  spec.limits.max_moved_parts = 1;
  EXPECT_TRUE(plan_order(Problem(spec), Sequence{0}).empty());
}

// Largest problem that loads, every limit in force; the limit allows for slow machines.
TEST(PlanOrder, IsQuickForTheLargestProblems) {
  ProblemSpec spec = random_graph(9000, kMaxConnections, 5);
  spec.limits.max_moved_parts = 9000;
  spec.limits.max_subassemblies = 1;
  Sequence plan(kMaxConnections);
  std::iota(plan.begin(), plan.end(), 0U);
  for (int i = 0; i + 1 < 16'000; i += 2) spec.precedence.push_back({"", {}, {}});
  const Problem names(random_graph(9000, kMaxConnections, 5));
  for (std::size_t i = 0; i < spec.precedence.size(); ++i) {
    spec.precedence[i].connection = names.connection_id(static_cast<ConnectionIndex>(2 * i + 1));
    spec.precedence[i].after = {names.connection_id(static_cast<ConnectionIndex>(2 * i))};
  }
  const Problem problem(spec);
  const auto begin = std::chrono::steady_clock::now();
  const Pairs pairs = plan_order(problem, plan);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  EXPECT_GT(pairs.size(), 9000U);
}

// The built-in problems: random orders that keep the pairs of a greedy plan.
TEST(PlanOrder, HoldsOnLargerProblems) {
  for (const char* name : {"lattice", "hubble-upc", "iss-upc", "jwst-upc"}) {
    SCOPED_TRACE(name);
    const Problem problem = load_scenario(name);
    const Result result = solve(problem, "greedy");
    ASSERT_TRUE(result.has_plan());
    const Pairs pairs = plan_order(problem, result.sequence);
    EXPECT_FALSE(pairs.empty());
    SplitMix64 random(7);
    for (int i = 0; i < 3; ++i) {
      const auto positions = random_extension(pairs, result.sequence.size(), random);
      EXPECT_TRUE(oracle::replay(problem.spec(), arranged(result.sequence, positions)).valid);
    }
  }
}

}  // namespace
}  // namespace orasp
