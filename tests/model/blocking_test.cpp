#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/problem.h"
#include "orasp/model/random.h"
#include "orasp/model/transition_system.h"
#include "orasp/model/validate.h"
#include "tests/fault.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

std::vector<ConnectionIndex> shuffled_connections(const Problem& problem, SplitMix64& random) {
  std::vector<ConnectionIndex> order;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) order.push_back(c);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

// An axis with a name of its own, or there many times over, forbids what it forbade.
TEST(NamedDirections, ForbidWhatTheAxisForbids) {
  std::size_t compared = 0;
  std::size_t blocked = 0;
  for (std::uint64_t seed = 0; seed < some_of(1200U); ++seed) {
    ProblemSpec spec = random_problem(seed);
    if (!spec.blocking || spec.blocking->directions.back().vector) continue;
    const Problem plain(spec);
    const TransitionSystem plain_system(plain);
    Expander plain_expander(plain_system);
    SplitMix64 random(seed);
    for (const std::size_t copies :
         {std::size_t{1}, std::size_t{13}, std::size_t{14}, std::size_t{80}}) {
      const Problem named(with_named_directions(spec, copies));
      EXPECT_EQ(named.has_direction_masks(), copies <= 13);
      const TransitionSystem system(named);
      Expander expander(system);
      ConnectionSet open = system.start();
      const auto order = shuffled_connections(named, random);
      for (const ConnectionIndex next : order) {
        const auto expected = plain_expander.legal_actions(open.view());
        const auto found = expander.legal_actions(open.view());
        ASSERT_TRUE(
            std::ranges::equal(expected, found, {}, &Action::connection, &Action::connection))
            << seed << ", " << copies;
        for_each_connection(open.view(), [&](ConnectionIndex c) {
          const auto why = plain_expander.violations(open.view(), c);
          const auto same = expander.violations(open.view(), c);
          ASSERT_EQ(why.size(), same.size());
          for (std::size_t i = 0; i < why.size(); ++i) {
            EXPECT_EQ(why[i].message, same[i].message);
            if (why[i].constraint == Constraint::Blocking) ++blocked;
          }
        });
        ++compared;
        open.erase(next);
      }
      const Evaluation expected = evaluate(plain, std::span<const ConnectionIndex>(order));
      const Evaluation found = evaluate(named, std::span<const ConnectionIndex>(order));
      ASSERT_EQ(expected.violations.size(), found.violations.size()) << seed << ", " << copies;
      for (std::size_t i = 0; i < found.violations.size(); ++i)
        EXPECT_EQ(expected.violations[i].step, found.violations[i].step);
    }
  }
  EXPECT_GE(compared, more_than(3000));
  EXPECT_GE(blocked, more_than(1000));
}

std::vector<std::string> names_of(const Problem& problem, std::span<const DirectionIndex> list) {
  std::vector<std::string> names;
  for (const DirectionIndex d : list) names.push_back(problem.direction_name(d));
  return names;
}

// Worked out from the ProblemSpec alone, by the planners' rules, and by the check of plans.
TEST(FreeDirections, AreThoseInWhichNothingIsInTheWay) {
  std::size_t some = 0;
  std::size_t none = 0;
  std::size_t wide = 0;
  for (std::uint64_t seed = 0; seed < some_of(1500U); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    const oracle::World world(spec);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    Expander expander(system);
    SplitMix64 random(seed);
    const auto order = shuffled_connections(problem, random);
    const Evaluation evaluation = evaluate(problem, std::span<const ConnectionIndex>(order));
    ASSERT_EQ(evaluation.steps.size(), order.size());
    ConnectionSet open = system.start();
    for (std::size_t i = 0; i < order.size(); ++i) {
      const auto open_now = oracle::state_of(open.view(), problem.num_connections());
      const std::set<std::string> truth = world.facts(open_now, order[i]).free_directions;
      const auto& listed = evaluation.steps[i].free_directions;
      const auto names = names_of(problem, listed);
      EXPECT_EQ(std::set<std::string>(names.begin(), names.end()), truth) << seed;
      EXPECT_EQ(truth.size(), names.size());
      EXPECT_EQ(expander.free_directions(open.view(), order[i]), listed) << seed;
      EXPECT_EQ(expander.step(open.view(), order[i]).free_directions, listed) << seed;
      // In the order of the file.
      std::size_t at = 0;
      for (const DirectionIndex d : problem.directions())
        at += at < listed.size() && listed[at] == d;
      EXPECT_EQ(at, listed.size());
      if (evaluation.steps[i].separates && spec.blocking) ++(truth.empty() ? none : some);
      if (!problem.has_direction_masks()) ++wide;
      open.erase(order[i]);
    }
  }
  EXPECT_GE(some, more_than(800));
  EXPECT_GE(none, more_than(200));
  EXPECT_GE(wide, more_than(100));
}

TEST(NamedDirections, AreNotForFleets) {
  ProblemSpec spec;
  spec.parts = {{.id = "1"}, {.id = "2"}};
  spec.connections = {{.parts = {"1", "2"}, .axis = "+x"}};
  spec.fleet = Fleet{.robots = 1, .depot = {}, .sites = {{1, 0}}};
  spec.objective = Objective::named("makespan");
  spec.blocking = Blocking{{"+x", "-x", {"slant", Vector3{1, 0, 1}}}, {}};
  EXPECT_EQ(fault_of([&] { return Problem(spec); }),
            "blocking.directions[2]: robots of a fleet move along the axes, and \"slant\" is a "
            "direction of its own");
}

}  // namespace
}  // namespace orasp
