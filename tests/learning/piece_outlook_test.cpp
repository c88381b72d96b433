// What becomes of a product piece by piece, and what actions lose, against all plans of small
// problems.

#include "orasp/learning/piece_outlook.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/objective_json.h"
#include "orasp/learning/imitation.h"
#include "orasp/model/random.h"
#include "orasp/planners/value_iteration.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// The most that can still be earned, from all states; -infinity where there is no plan.
double rest_of(const TransitionSystem& system, const ConnectionSet& open) {
  if (open.empty()) return 0;
  Situation here = system.situation();
  here.open = open;
  const TransitionSystem rest(system.problem(), here);
  const Result result = value_iteration(rest, {}, {});
  return result.status == Status::Optimal ? result.reward : -kInfinity;
}

/// By definition.
std::vector<double> losses_of(const TransitionSystem& system, const ConnectionSet& open,
                              const std::vector<Action>& actions) {
  std::vector<double> values;
  for (const Action& action : actions) {
    ConnectionSet after = open;
    after.erase(action.connection);
    values.push_back(action.reward + rest_of(system, after));
  }
  const double best = std::ranges::max(values);
  for (double& value : values)
    value = best == -kInfinity ? 0 : std::isfinite(value) ? best - value : kInfinity;
  return values;
}

/// Calls visit(open, actions, losses) for the states of a random walk that has a plan from each.
template <class Visit>
void for_each_state(const TransitionSystem& system, std::uint64_t seed, Visit&& visit) {
  SplitMix64 random(seed);
  Expander expander(system);
  for (ConnectionSet open = system.start(); !open.empty();) {
    const auto legal = expander.legal_actions(open.view());
    const std::vector<Action> actions(legal.begin(), legal.end());
    if (actions.empty() || rest_of(system, open) == -kInfinity) return;
    visit(open, actions, losses_of(system, open, actions));
    open.erase(actions[random.below(actions.size())].connection);
  }
}

// All pieces have at most kExact parts, and only blocking and max_moved_parts forbid cuts: then
// what the outlook says is exact.
TEST(PieceOutlook, IsExactOfSmallPieces) {
  int lose = 0;
  int dead = 0;
  for (std::uint64_t seed = 0; seed < some_of(std::uint64_t{600}); ++seed) {
    ProblemSpec spec = random_problem(seed);
    spec.direction = Direction::Disassembly;
    spec.precedence.clear();
    spec.base.clear();
    const auto moved = spec.limits.max_moved_parts;
    spec.limits = {};
    spec.limits.max_moved_parts = moved;
    // The second pays for small pieces, as cubesat does, but not apart for the last step.
    spec.objective = parse_objective(
        seed % 2 == 0 ? "{\"type\":\"expression\",\"formula\":"
                        "\"-separates*(moved_parts*kept_parts-moved_parts)\"}"
                      : "{\"type\":\"expression\",\"formula\":"
                        "\"-separates*(0.7*(moved_parts==1)+0.7*(kept_parts==1)+"
                        "0.9*(moved_parts==2)+0.9*(kept_parts==2)+(kept_parts==3))\"}",
        "");
    const Problem problem(std::move(spec));
    const TransitionSystem system(problem);
    PieceOutlook outlook(system);
    if (!outlook.known()) continue;
    for_each_state(system, seed,
                   [&](const ConnectionSet& open, const std::vector<Action>& actions,
                       const std::vector<double>& losses) {
                     const auto steps = outlook.look(open.view(), actions);
                     for (std::size_t i = 0; i < actions.size(); ++i) {
                       ASSERT_TRUE(steps[i].known);
                       if (std::isfinite(losses[i])) {
                         EXPECT_NEAR(steps[i].loss, losses[i], 1e-9) << seed;
                       } else {
                         EXPECT_EQ(steps[i].loss, kInfinity) << seed;
                         ++dead;
                       }
                       if (steps[i].at_bound) {
                         EXPECT_NEAR(losses[i], 0, 1e-9) << seed;
                       }
                       if (losses[i] > 1e-6) ++lose;
                     }
                   });
  }
  EXPECT_GT(lose, more_than(300));
  EXPECT_GE(dead, least_of(1));
}

TEST(ActionLosses, AreThoseOfAllPlans) {
  int lose = 0;
  int none = 0;
  for (std::uint64_t seed = 0; seed < some_of(std::uint64_t{300}); ++seed) {
    const Problem problem(random_problem(seed));
    const TransitionSystem system(problem);
    if (system.wide() || problem.uncertain()) continue;
    for_each_state(system, seed,
                   [&](const ConnectionSet& open, const std::vector<Action>& actions,
                       const std::vector<double>& losses) {
                     const auto told = action_losses(system, open, actions, {});
                     ASSERT_TRUE(told) << seed;
                     for (std::size_t i = 0; i < actions.size(); ++i) {
                       const double slack = 1e-6;
                       EXPECT_EQ((*told)[i] > slack, losses[i] > slack) << seed;
                       // By a bound it may be told that more is lost than that.
                       EXPECT_LE((*told)[i], losses[i] + slack) << seed;
                       ++(losses[i] > slack ? lose : none);
                     }
                   });
  }
  EXPECT_GT(lose, more_than(300));
  EXPECT_GT(none, more_than(300));
}

}  // namespace
}  // namespace orasp
