#include "orasp/bounds/place_bound.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/formula_parser.h"
#include "orasp/orasp.h"
#include "orasp/planners/detail/order_search.h"
#include "orasp/planners/detail/step_in_front.h"
#include "orasp/planners/planner_support.h"
#include "tests/checks.h"
#include "tests/instances.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

constexpr std::uint64_t kWhenSeeds = 900;

/// Formulas whose value depends on when a step comes: along lines, along none, and mixed with what
/// is not known of a step.
const std::vector<std::string>& formulas() {
  static const std::vector<std::string> kFormulas = {
      "-a*duration*before",
      "duration*after",
      "-duration*elapsed",
      "a*duration*elapsed - before",
      "-(1 + index)*elapsed",
      "-value*elapsed - duration",
      "value*before",
      "-value*value*after - separates",
      "-before*before/(1 + index)",
      "min(before, 3)*value",
      "before > 2 ? value : -duration*elapsed",
      "-moved_mass*before",
      "-moved_parts*duration*elapsed/(1 + after)",
      "-subassemblies*duration",
      "subassemblies - kept_value*after",
      "exp(-0.1*elapsed)*value",
      "completes*elapsed - duration*before",
      "-distance*elapsed",
      "abs(before - index)*(1 - 2*separates)",
      "-sqrt(1 + elapsed)*before",
      "(elapsed - 2*duration)*(value - 1)",
  };
  return kFormulas;
}

Objective when_objective(std::uint64_t seed, SplitMix64& random) {
  const auto plain = [&](std::uint64_t which) -> Objective {
    if (which % (formulas().size() + 1) == formulas().size()) return Objective::named("indexed");
    return {"expression", Expression{.formula = formulas()[which % (formulas().size() + 1)],
                                     .constants = {{"a", 0.05}},
                                     .depot = {1, 2, 0},
                                     .compiler = compile_formula}};
  };
  const Objective first = plain(seed);
  if (random.below(3) != 0) return first;
  WeightedSum sum;
  sum.terms.push_back({random.below(3) == 0 ? -0.5 : 2.0, first});
  if (random.below(2) == 0) sum.terms.push_back({1, plain(random.below(100))});
  const char* const others[] = {"cubesat", "time", "fuel", "completion", "cubesat_zone"};
  sum.terms.push_back(
      {random.below(4) == 0 ? -1.0 : 1.0, Objective::named(others[random.below(5)])});
  return {"sum", std::move(sum)};
}

/// A random problem whose rewards depend on when steps come; now and then with a base, or with
/// steps that may have to be tried again.
ProblemSpec when_problem(std::uint64_t seed) {
  SplitMix64 random(mixed(seed + 77));
  ProblemSpec spec = random_problem(seed);
  for (std::uint64_t next = seed + 10'000; spec.connections.empty(); next += 10'000)
    spec = random_problem(next);
  spec.objective = when_objective(seed, random);
  spec.direction = random.below(2) == 0 ? Direction::Assembly : Direction::Disassembly;
  const std::vector<double> durations = {0, 1, 2.5, 4, 7};
  for (Connection& connection : spec.connections) {
    connection.duration = durations[random.below(durations.size())];
    connection.numbers["value"] = static_cast<double>(random.below(7)) - 2;
    if (random.below(6) == 0) connection.success = 0.5;
  }
  for (Part& part : spec.parts) {
    part.numbers["value"] = static_cast<double>(random.below(5)) - 1;
    if (random.below(8) == 0) spec.base.push_back(part.id);
  }
  return spec;
}

Problem paid_problem(const ProblemSpec& spec) {
  const Problem problem(spec);
  return problem.uncertain() ? attempts_paid(problem) : problem;
}

Situation some_situation(const Problem& problem, SplitMix64& random) {
  Situation now = Situation::whole(problem.num_connections());
  // Some of a legal order is done.
  const TransitionSystem whole(problem);
  Expander expander(whole);
  ConnectionSet state = whole.start();
  for (std::uint64_t steps = random.below(problem.num_connections() + 1); steps > 0; --steps) {
    const auto legal = expander.legal_actions(state.view());
    if (legal.empty()) break;
    const ConnectionIndex c = legal[random.below(legal.size())].connection;
    state.erase(c);
    now.open.erase(c);
  }
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    if (random.below(5) == 0) now.inaccessible.insert(c);
    if (random.below(8) == 0) now.not_next.insert(c);
    if (random.below(8) == 0) now.late.insert(c);
  }
  return now;
}

struct Seen {
  std::size_t known = 0;
  std::size_t states = 0;
  std::size_t tight = 0;  ///< starts whose bound is the truth
};

void expect_bounds(const TransitionSystem& system, Seen& seen) {
  if (system.wide() || system.infeasibility()) return;
  const StateGraph graph = StateGraph::build(system, {});
  const std::vector<double> values = value_iteration(graph, {}, {}).values;
  std::vector<std::unique_ptr<Bound>> bounds;
  bounds.push_back(make_bound(system, BoundKind::Best));
  bounds.push_back(std::make_unique<PlaceBound>(system, PlacePrices::Terms::All));
  for (const std::unique_ptr<Bound>& bound : bounds) {
    if (!bound->known()) continue;
    ++seen.known;
    const StartByPlaces by_places = start_by_places(*bound);
    EXPECT_GE(by_places.most, values[0] - reward_tolerance(by_places.most));
    if (std::min(by_places.most, (*bound)(system.start().view())) <= values[0] + 1e-9) ++seen.tight;
    for (StateId s = 0; s < graph.num_states(); ++s) {
      ++seen.states;
      const double here = (*bound)(graph.state(s));
      ASSERT_TRUE(std::isfinite(here) || values[s] == -kInfinity) << here;
      ASSERT_GE(here, values[s] - reward_tolerance(here)) << "state " << s;
      std::vector<Action> actions;
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a)
        actions.push_back({graph.connection(a), graph.reward(a)});
      if (!std::isfinite(here)) continue;  // from here no plan ends
      std::vector<double> told(actions.size());
      bound->of_successors(graph.state(s), here, actions, told);
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
        const double next = (*bound)(graph.state(graph.successor(a)));
        ASSERT_GE(here, graph.reward(a) + next - reward_tolerance(here))
            << "state " << s << ": not consistent";
        if (std::isfinite(next)) {
          ASSERT_NEAR(told[a - graph.begin(s)], next, reward_tolerance(here));
        }
      }
    }
  }
}

TEST(PlaceBound, IsNeverBelowATrueValueAndConsistent) {
  Seen seen;
  for (std::uint64_t seed = 0; seed < some_of(kWhenSeeds); ++seed) {
    const ProblemSpec spec = when_problem(seed);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + problem_text(Problem(spec)));
    const Problem problem = paid_problem(spec);
    const TransitionSystem system(problem);
    expect_bounds(system, seen);
    if (!system.takes_apart()) expect_bounds(system.backwards(), seen);
    if (HasFatalFailure()) return;
    SplitMix64 random(seed);
    const Situation now = some_situation(problem, random);
    const TransitionSystem rest(problem, now);
    expect_bounds(rest, seen);
    if (!rest.takes_apart() && !rest.ordered()) expect_bounds(rest.backwards(), seen);
    if (HasFatalFailure()) return;
  }
  EXPECT_GE(seen.known, least_of(3000U));
  EXPECT_GE(seen.states, least_of(20'000U));
  EXPECT_GE(seen.tight, least_of(1000U));
}

// All that prove, prove the best of all sequences.
TEST(PlaceBound, EveryMethodThatProvesEarnsTheSame) {
  for (std::uint64_t seed = 0; seed < some_of(kWhenSeeds / 3); ++seed) {
    ProblemSpec spec = when_problem(seed);
    for (Connection& connection : spec.connections) connection.success = 1;
    const Problem problem(spec);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + problem_text(problem));
    const Result truth = solve(problem, "exhaustive");
    const double best = truth.reward;
    for (const char* const method : {"auto", "beam", "a-star", "orasp-search", "value-iteration"}) {
      if (obstacle(problem, method)) continue;
      SCOPED_TRACE(method);
      const Result result = solve(problem, method);
      if (!truth.has_plan()) {
        EXPECT_EQ(result.status, Status::Infeasible);
        continue;
      }
      EXPECT_EQ(result.status, Status::Optimal);
      EXPECT_NEAR(result.reward, best, reward_tolerance(best));
    }
    // What is claimed by those that are stopped.
    for (const char* const method : {"beam", "a-star", "orasp-search"}) {
      if (obstacle(problem, method) || !truth.has_plan()) continue;
      Budget few;
      few.max_expansions = 3;
      const Result result = solve(problem, method, {}, few);
      EXPECT_LE(result.reward, best + reward_tolerance(best)) << method;
      if (result.bound) {
        EXPECT_GE(*result.bound, best - reward_tolerance(best)) << method;
      }
      if (result.status == Status::Optimal) {
        EXPECT_NEAR(result.reward, best, reward_tolerance(best)) << method;
      }
    }
  }
}

// A star of `parts` arms, each of a duration of its own, under that formula.
Problem star(const std::vector<double>& durations, const std::string& formula) {
  std::vector<std::pair<int, int>> arms;
  for (std::size_t i = 0; i < durations.size(); ++i) arms.emplace_back(1, static_cast<int>(i) + 2);
  ProblemSpec spec = instances::assembly(durations.size() + 1, arms);
  for (std::size_t i = 0; i < durations.size(); ++i) spec.connections[i].duration = durations[i];
  spec.objective = {"expression", Expression{.formula = formula, .compiler = compile_formula}};
  return Problem(spec);
}

// Without precedence Smith's rule is exact: the shortest first, 3 * 0 + 2 * 1 + 5 * 3 ... by hand.
TEST(PlaceBound, IsExactByRuleOfSmith) {
  const Problem seconds = star({3, 1, 2}, "-elapsed");
  const TransitionSystem by_seconds(seconds);
  PlaceBound bound(by_seconds, PlacePrices::Terms::All);
  ASSERT_TRUE(bound.known());
  EXPECT_NEAR(bound(by_seconds.start().view()), -(0 + 1 + 3), 1e-12);
  // The longest last, when the fewest are present: 1 * 3 + 2 * 2 + 3 * 1.
  const Problem places = star({3, 1, 2}, "-duration*before");
  const TransitionSystem by_place(places);
  PlaceBound other(by_place, PlacePrices::Terms::All);
  EXPECT_NEAR(other(by_place.start().view()), -(3 + 4 + 3), 1e-12);
}

// Along no line: a table of places. The best of three takes the second place: 0 + 9 + 0.
TEST(PlaceBound, IsExactByAssignment) {
  const Problem problem = star({3, 1, 2}, "before == 2 ? duration*duration : 0");
  const TransitionSystem system(problem);
  PlaceBound bound(system, PlacePrices::Terms::All);
  ASSERT_TRUE(bound.known());
  EXPECT_TRUE(bound.prices()->places().used);
  EXPECT_NEAR(bound(system.start().view()), 9, 1e-12);
}

TEST(PlaceBound, SaysNothingOfAFunctionWithoutARange) {
  Callable callable;
  callable.reward = [](const Step& step) { return static_cast<double>(step.before); };
  ProblemSpec spec = instances::chain_of_three();
  spec.objective = {"callable", callable};
  const Problem problem(spec);
  EXPECT_FALSE(PlaceBound(TransitionSystem(problem), PlacePrices::Terms::All).known());
}

// The order of the prices, and what comes of moving steps about, are legal plans that earn more.
TEST(OrderSearch, NeverMakesAPlanWorse) {
  std::size_t better = 0;
  for (std::uint64_t seed = 0; seed < some_of(kWhenSeeds / 3); ++seed) {
    const ProblemSpec spec = when_problem(seed);
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Problem problem = paid_problem(spec);
    const TransitionSystem system(problem);
    if (system.infeasibility()) continue;
    const std::unique_ptr<Bound> bound = make_bound(system, BoundKind::Best);
    const StartByPlaces by_places = start_by_places(*bound);
    if (!by_places.prices) continue;
    Result plan = random_sequence(system, {.seed = seed}, {});
    if (!plan.has_plan()) continue;
    const double before = plan.reward;
    detail::OrderSearch orders(system, by_places.prices);
    const bool improved = orders.improve({}, 10, plan);
    EXPECT_EQ(improved, plan.reward > before);
    EXPECT_GE(plan.reward, before);
    EXPECT_NEAR(detail::reward_of(system, plan.sequence), plan.reward,
                reward_tolerance(plan.reward));
    EXPECT_TRUE(evaluate(system, plan).valid);
    if (improved) ++better;
  }
  EXPECT_GE(better, least_of(30U));
}

// Where one step alone is named, the best plan that begins with it earns as much as any, as long as
// that is more than what is known.
TEST(StepInFront, KeepsABestPlan) {
  std::size_t named = 0;
  for (std::uint64_t seed = 0; seed < some_of(4 * kWhenSeeds); ++seed) {
    SplitMix64 random(mixed(seed));
    ProblemSpec spec = when_problem(seed);
    if (random.below(2) == 0) {
      spec.objective = Objective::named("indexed");
    } else {
      spec.objective = {"expression", Expression{.formula = random.below(2) == 0
                                                                ? "max(0, value*(before - index))"
                                                                : "before > 2 ? value : -duration",
                                                 .compiler = compile_formula}};
    }
    if (random.below(2) == 0) spec.precedence.clear();
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + problem_text(Problem(spec)));
    const Problem problem = paid_problem(spec);
    const TransitionSystem forwards(problem);
    std::unique_ptr<const TransitionSystem> backwards;
    if (!forwards.takes_apart()) backwards.reset(new TransitionSystem(forwards.backwards()));
    const TransitionSystem& system = backwards ? *backwards : forwards;
    const auto prices = std::make_shared<const PlacePrices>(system, PlacePrices::Terms::All);
    if (system.infeasibility() || !detail::StepInFront::applies(system, *prices)) continue;
    detail::StepInFront in_front(system, prices);
    const StateGraph graph = StateGraph::build(system, {});
    const std::vector<double> values = value_iteration(graph, {}, {}).values;
    PlaceBound bound(system, prices);
    for (StateId s = 0; s < graph.num_states(); ++s) {
      if (values[s] == -kInfinity) continue;
      std::vector<Action> legal;
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a)
        legal.push_back({graph.connection(a), graph.reward(a)});
      // A plan is known that earns a little less than the best, and one that earns much less.
      for (const double less : {1e-6, 3.0, 100.0}) {
        const double known = values[s] - less;
        const auto alone = in_front.find(graph.state(s), legal, bound(graph.state(s)) - known);
        if (!alone) continue;
        ++named;
        for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
          if (graph.connection(a) != *alone) continue;
          ASSERT_NEAR(graph.reward(a) + values[graph.successor(a)], values[s],
                      reward_tolerance(values[s]))
              << "state " << s;
        }
      }
    }
  }
  EXPECT_GE(named, least_of(2000U));
}

}  // namespace
}  // namespace orasp
