// find_order() against the oracle on the seeded random problems, from the start and from states in
// the middle.

#include "orasp/planners/feasibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/explain/explain_problem.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/random.h"
#include "orasp/model/scenario_generators.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"
#include "tests/wide_oracle.h"
#include "tests/wide_problems.h"

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
/// The same problem where two of its parts block each other in every direction, if it has two.
ProblemSpec with_locked_parts(ProblemSpec spec, std::uint64_t seed) {
  if (spec.parts.size() < 2) return spec;
  if (!spec.blocking) spec.blocking = Blocking{{{"+x"}, {"-x"}}, {}};
  std::vector<std::string> all;
  for (const BlockingDirection& direction : spec.blocking->directions) {
    all.push_back(direction.id);
    if (direction.vector) all.push_back("-" + direction.id);
  }
  SplitMix64 random(seed);
  const std::size_t a = random.below(spec.parts.size());
  const std::size_t b = (a + 1 + random.below(spec.parts.size() - 1)) % spec.parts.size();
  const std::string& one = spec.parts[a].id;
  const std::string& other = spec.parts[b].id;
  spec.blocking->blocked.push_back({one, other, all});
  spec.blocking->blocked.push_back({other, one, all});
  return spec;
}

std::optional<std::array<PartIndex, 2>> locked_pair_of(const ProblemSpec& spec) {
  const Problem problem(spec);
  return TransitionSystem(problem).locked_pair();
}

// Brute force knows nothing of pairs.
TEST(LockedPair, IsNamedOnlyWhereNoPlanExists) {
  std::size_t locked = 0;
  std::size_t harmless = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    const ProblemSpec spec = with_locked_parts(random_problem(seed), seed);
    SCOPED_TRACE(spec.name);
    const bool feasible = oracle::brute_force(spec).feasible;
    const bool named = locked_pair_of(spec).has_value();
    ASSERT_FALSE(named && feasible);
    ASSERT_EQ(status_name(find_order(spec, Budget{}).status), feasible ? "feasible" : "infeasible");
    locked += named ? 1 : 0;
    harmless += feasible ? 1 : 0;
  }
  EXPECT_GE(locked, more_than(300U));
  EXPECT_GE(harmless, more_than(100U));
}

TEST(LockedPair, IsNamedOnlyWhereNoPlanExistsInTheWiderWorldEither) {
  std::size_t locked = 0;
  std::size_t harmless = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(600); ++seed) {
    const ProblemSpec spec = with_locked_parts(wide_random_problem(seed), seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const bool feasible = oracle::wide_brute_force(spec).best.has_value();
    const bool named = TransitionSystem(problem).locked_pair().has_value();
    ASSERT_FALSE(named && feasible);
    ASSERT_EQ(solve(problem, "greedy").has_plan(), feasible);
    locked += named ? 1 : 0;
    harmless += feasible ? 1 : 0;
  }
  EXPECT_GE(locked, more_than(100U));
  EXPECT_GE(harmless, more_than(100U));
}

// A hub that is taken off leaves the parts around it apart, with nothing of theirs moved.
TEST(LockedPair, OfNeighboursOfAHubIsNoneWhereTheHubIsTakenOff) {
  ProblemSpec spec;
  spec.parts = {{.id = "hub"}, {.id = "a"}, {.id = "b"}};
  spec.connections = {{.parts = {"hub", "a"}}, {.parts = {"hub", "b"}}};
  spec.blocking = Blocking{{{"+x"}, {"-x"}}, {{"a", "b", {"+x", "-x"}}}};
  EXPECT_EQ(locked_pair_of(spec), (std::array{PartIndex{1}, PartIndex{2}}));
  EXPECT_EQ(solve(Problem(spec), "auto").status, Status::Infeasible);
  spec.action = StepKind::Part;
  EXPECT_FALSE(locked_pair_of(spec).has_value());
  EXPECT_EQ(solve(Problem(spec), "auto").status, Status::Optimal);
  spec.connections.push_back({.parts = {"a", "b"}});
  EXPECT_TRUE(locked_pair_of(spec).has_value());
  EXPECT_EQ(solve(Problem(spec), "auto").status, Status::Infeasible);
}

// Hundreds of states would have to be searched to find out without the pair.
TEST(LockedPair, AnswersALargeProblemBeforeAnySearch) {
  ProblemSpec spec = with_locked_parts(load_scenario("grid:9x9").spec(), 7);
  const Problem problem(spec);
  const Result result = solve(problem, "auto");
  EXPECT_EQ(result.status, Status::Infeasible);
  EXPECT_EQ(result.statistics.expanded, 0U);
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_NE(result.notes[0].find("block each other in every direction of blocking.directions"),
            std::string::npos);
  const ProblemExplanation explanation = explain_problem(problem, Budget{});
  EXPECT_TRUE(explanation.minimal);
  for (const ConflictItem& item : explanation.conflict)
    EXPECT_EQ(item.constraint, Constraint::Blocking);
}

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
