// Parts that leave together: what is said of them against all plans of small problems, and what is
// proved with it.

#include "orasp/bounds/companion_bound.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/bounds/departures.h"
#include "orasp/bounds/piece_bound.h"
#include "orasp/model/random.h"
#include "orasp/orasp.h"
#include "orasp/planners/detail/companion_plan.h"
#include "orasp/planners/planner_support.h"
#include "tests/instances.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// 4 to 7 parts of random masses in each other's way, with up to 10 connections; some with a base,
/// limits, two fuels; both directions.
ProblemSpec blocked_problem(std::uint64_t seed) {
  SplitMix64 random(seed);
  const auto below = [&random](std::uint64_t number) { return random.below(number); };
  const std::size_t parts = 4 + below(4);
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t p = 2; p <= parts; ++p)
    pairs.emplace_back(static_cast<int>(1 + below(p - 1)), static_cast<int>(p));
  for (std::uint64_t more = below(4); more > 0; --more) {
    const int a = static_cast<int>(1 + below(parts));
    const int b = static_cast<int>(1 + below(parts));
    if (a != b) pairs.emplace_back(std::min(a, b), std::max(a, b));
  }
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  ProblemSpec spec = instances::assembly(parts, pairs);
  spec.name = "blocked " + std::to_string(seed);
  for (Part& part : spec.parts) part.mass = 0.1 * static_cast<double>(1 + below(20));
  spec.blocking = Blocking{};
  spec.blocking->directions = {"+x", "-x", "+y", "-y"};
  if (below(3) == 0) spec.blocking->directions.resize(2);
  const std::uint64_t density = 1 + below(4);
  for (const Part& part : spec.parts) {
    for (const Part& by : spec.parts) {
      if (part.id == by.id || below(10) >= 2 * density) continue;
      const BlockingDirection& direction =
          spec.blocking->directions[below(spec.blocking->directions.size())];
      spec.blocking->blocked.push_back({part.id, by.id, {direction.id}});
    }
  }
  spec.objective = Objective::named("fuel");
  if (below(4) == 0) {
    WeightedSum sum;
    sum.terms.push_back({2, Objective("fuel", Fuel{.dry_mass = 1, .delta_v = 300, .isp = 100})});
    sum.terms.push_back({0.5, Objective::named("fuel")});
    spec.objective = Objective{"sum", sum};
  }
  if (below(3) == 0) {
    spec.base.push_back(spec.parts[below(parts)].id);
    if (below(3) == 0) {
      const std::string& second = spec.parts[below(parts)].id;
      if (second != spec.base.front()) spec.base.push_back(second);
    }
  }
  if (below(6) == 0) spec.limits.max_moved_parts = 2;
  if (below(6) == 0) spec.limits.max_moved_mass = 2;
  if (below(2) == 0) spec.direction = Direction::Assembly;
  return spec;
}

/// One in three is a random problem with every key, under `fuel`.
Problem some_problem(std::uint64_t seed) {
  if (seed % 3 != 0) return Problem(blocked_problem(seed));
  ProblemSpec spec = random_problem(seed);
  spec.objective = Objective::named("fuel");
  return Problem(std::move(spec));
}

/// That of a system that takes apart, or of the same work backwards.
template <class Look>
void look_from_the_end(const TransitionSystem& system, Look&& look) {
  if (system.takes_apart()) return look(system);
  const TransitionSystem backwards = system.backwards();
  look(backwards);
}

TEST(CompanionBound, IsNeverBelowTheBestPlan) {
  std::size_t known = 0;
  std::size_t lower = 0;
  std::size_t exact = 0;
  std::size_t plans = 0;
  std::size_t assemblies = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(8'000); ++seed) {
    const Problem problem = some_problem(seed);
    SCOPED_TRACE(problem.spec().name);
    if (problem.uncertain()) continue;
    // From the start, and from somewhere in the middle of the best plan.
    Situation now = Situation::whole(problem.num_connections());
    for (int part = 0; part < 2; ++part) {
      const TransitionSystem system(problem, now);
      if (system.infeasibility()) break;
      const Result best = value_iteration(system, {}, {});
      look_from_the_end(system, [&](const TransitionSystem& from) {
        const CompanionBound bound(from);
        if (!bound.known() || !best.has_plan()) return;
        ++known;
        ASSERT_GE(bound.most(), best.reward - 1e-9);
        PieceBound pieces(from, PieceBound::Kind::Both);
        const bool is_lower = bound.most() < pieces(from.start().view()) - 1e-9;
        lower += is_lower ? 1 : 0;
        exact += is_lower && detail::meets(best.reward, bound.most()) ? 1 : 0;
        assemblies += problem.direction() == Direction::Assembly ? 1 : 0;
        const Result plan = detail::companion_plan(from, bound, {});
        if (!plan.has_plan()) return;
        EXPECT_TRUE(detail::meets(best.reward, plan.reward)) << plan.reward;
        // Less, where the side that stays is the smaller one and moves.
        plans += detail::meets(plan.reward, best.reward) ? 1 : 0;
      });
      if (!best.has_plan()) break;
      for (std::size_t i = 0; i < best.sequence.size() / 3; ++i) now.open.erase(best.sequence[i]);
    }
  }
  EXPECT_GE(known, least_of(5'000U));
  EXPECT_GE(lower, least_of(200U));
  EXPECT_GE(exact, least_of(200U));
  EXPECT_GE(plans, least_of(4'000U));
  EXPECT_GE(assemblies, least_of(1'500U));
  RecordProperty("known", static_cast<int>(known));
  RecordProperty("lower", static_cast<int>(lower));
  RecordProperty("exact", static_cast<int>(exact));
  RecordProperty("plans", static_cast<int>(plans));
}

// Every cut of every plan, seen from each part of the side that stays.
TEST(Departures, SayOfNothingThatComesOffThatItCannot) {
  std::size_t cuts = 0;
  std::size_t refused = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    ProblemSpec spec = blocked_problem(seed);
    spec.direction = Direction::Disassembly;
    spec.limits = {};
    spec.base.clear();
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const auto world = std::make_shared<const Departures::World>(system);
    std::vector<PartIndex> all(problem.num_parts());
    std::iota(all.begin(), all.end(), PartIndex{0});
    std::vector<Departures> departures;
    for (const PartIndex stays : all) departures.emplace_back(world, all, stays);
    Expander expander(system);
    // Whether each state, by its connections as bits, leads to the end.
    std::map<std::uint64_t, bool> leads;
    const std::function<bool(std::uint64_t)> visit = [&](std::uint64_t state) {
      if (state == 0) return true;
      const auto [known, is_new] = leads.try_emplace(state, false);
      if (!is_new) return known->second;
      const SetView open(&state, 1);
      const auto span = expander.legal_actions(open);
      const std::vector<Action> actions(span.begin(), span.end());
      bool any = false;
      for (const Action& action : actions) {
        if (!visit(state & ~(std::uint64_t{1} << action.connection))) continue;
        any = true;
        const Step step = expander.step(open, action.connection);
        const std::size_t there = step.a.size() + step.b.size();
        for (const auto& [group, rest] : {std::pair(step.a, step.b), std::pair(step.b, step.a)}) {
          for (const PartIndex stays : rest) {
            ++cuts;
            EXPECT_TRUE(departures[stays].possible());
            EXPECT_TRUE(departures[stays].may_leave_more(group, there - 1));
          }
        }
      }
      return leads[state] = any;
    };
    static_cast<void>(visit(system.start().view().front()));
    for (const PartIndex stays : all) {
      if (!departures[stays].possible()) continue;
      for (const PartIndex other : all)
        refused += other != stays && !departures[stays].may_leave_more({&other, 1}, 2) ? 1 : 0;
    }
  }
  EXPECT_GT(cuts, 10'000U);
  EXPECT_GT(refused, 50U);
}

// A bearing pressed into a wheel between two forks: neither leaves without the other.
//
//     fork - bearing - wheel,   the wheel around the bearing, both between the arms of the fork
TEST(CompanionBound, CountsWhatIsMovedTwice) {
  ProblemSpec spec = instances::assembly(3, {{1, 2}, {2, 3}});
  spec.base = {"1"};  // else it moves, as the one part of two
  spec.parts[1].mass = 0.25;
  spec.parts[2].mass = 1;
  spec.blocking = Blocking{};
  spec.blocking->directions = {"+x", "-x", "+y", "-y"};
  // The fork closes x to both, and along y the bearing is stuck in the wheel.
  spec.blocking->blocked = {
      {"2", "1", {"+x", "-x"}}, {"3", "1", {"+x", "-x"}}, {"2", "3", {"+y", "-y"}}};
  spec.objective = Objective("fuel", Fuel{.dry_mass = 0, .delta_v = 30, .isp = 200});
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const CompanionBound bound(system);
  ASSERT_TRUE(bound.known());
  const double per_kg = std::expm1(30 / (200 * 9.80665));
  // Both go along y, then one of them goes off the other along x.
  EXPECT_NEAR(bound.most(), -per_kg * (1 + 0.25 + 0.25), 1e-12);
  const Result plan = detail::companion_plan(system, bound, {});
  ASSERT_TRUE(plan.has_plan());
  EXPECT_NEAR(plan.reward, bound.most(), 1e-12);

  const CompanionBound::Best best = bound.of_piece(std::vector<PartIndex>{0, 1, 2});
  ASSERT_TRUE(best.departures);
  EXPECT_EQ(best.departures->stays(), 0U);
  EXPECT_EQ(best.departures->groups(), (std::vector<std::vector<PartIndex>>{{1, 2}}));
}

TEST(CompanionBound, SaysNothingWhereOtherThingsCost) {
  for (const char* type : {"cubesat", "time", "indexed"}) {
    const Problem problem = Problem(blocked_problem(3)).with_objective(Objective::named(type));
    EXPECT_FALSE(CompanionBound(TransitionSystem(problem)).known()) << type;
  }
}

}  // namespace
}  // namespace orasp
