#include "orasp/model/plan_check.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/model/transition_system.h"
#include "orasp/model/validate.h"
#include "tests/checks.h"
#include "tests/fault.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using Sequence = std::vector<ConnectionIndex>;

PlanCheck checked(const Problem& problem, const Sequence& sequence) {
  return check_plan(problem, Situation::whole(problem.num_connections()), sequence);
}
PlanCheck checked(const ProblemSpec& spec, const Sequence& sequence) {
  return checked(Problem(spec), sequence);
}

// ---- Against brute force and the planners' own rules --------------------------------------------

/// The rules that each step breaks, by step from 1, and the sum of rewards, from the sentences of
/// docs/format.md and model/situation.h. Step 0 is the start.
struct Truth {
  std::map<std::size_t, std::set<Constraint>> broken;
  double reward = 0;
};

Constraint constraint_of(oracle::Rule rule) {
  switch (rule) {
    case oracle::Rule::Precedence: return Constraint::Precedence;
    case oracle::Rule::PrecedenceAny: return Constraint::PrecedenceAny;
    case oracle::Rule::PrecedenceMadeAny: return Constraint::PrecedenceMadeAny;
    case oracle::Rule::MaxSubassemblies: return Constraint::MaxSubassemblies;
    case oracle::Rule::MaxMovedParts: return Constraint::MaxMovedParts;
    case oracle::Rule::MaxMovedMass: return Constraint::MaxMovedMass;
    case oracle::Rule::Blocking: return Constraint::Blocking;
  }
  return Constraint::NotOpen;
}

bool may_shut_out(const ProblemSpec& spec) {
  const Limits& limits = spec.limits;
  const auto any = [&](auto&& list) {
    return std::ranges::any_of(spec.precedence,
                               [&](const Precedence& entry) { return !list(entry).empty(); });
  };
  return limits.max_subassemblies || limits.max_moved_parts || limits.max_moved_mass ||
         (spec.blocking && !spec.blocking->blocked.empty()) ||
         (any([](const Precedence& entry) { return entry.after_any; }) &&
          any([](const Precedence& entry) { return entry.made_after_any; }));
}

Truth truth_of(const ProblemSpec& spec, const Situation& now, const Sequence& sequence) {
  oracle::World world(spec);
  const std::size_t connections = world.num_connections();
  const oracle::State start = oracle::state_of(now.open.view(), connections);
  oracle::State open = start;
  std::size_t kept = 0;
  oracle::State never(connections, false);
  for (ConnectionIndex c = 0; c < connections; ++c) {
    never[c] = now.open.contains(c) && now.inaccessible.contains(c);
    if (never[c]) ++kept;
  }
  world.give_up(never);
  Truth truth;
  oracle::State product = start;
  if (spec.direction == Direction::Assembly) {
    for (ConnectionIndex c = 0; c < connections; ++c)
      product[c] = !(start[c] && now.inaccessible.contains(c));
  }
  if (now.open.size() > kept && spec.limits.max_subassemblies &&
      world.subassemblies(product) > *spec.limits.max_subassemblies)
    truth.broken[0].insert(Constraint::MaxSubassemblies);
  // Where some rule of precedence is broken, all that are broken at the start are named too.
  std::set<oracle::Rule> at_start;
  if (now.open.size() > kept) at_start = world.broken_at_start(start);
  for (const oracle::Rule rule : at_start) truth.broken[0].insert(constraint_of(rule));
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const ConnectionIndex c = sequence[i];
    std::set<Constraint> broken;
    if (c < connections && open[c] && now.inaccessible.contains(c)) {
      broken.insert(Constraint::Inaccessible);
    } else if (c >= connections || !open[c]) {
      broken.insert(Constraint::NotOpen);
    } else {
      const oracle::Facts facts = world.facts(open, c, kept);
      for (const oracle::Rule rule : facts.broken) {
        if (!facts.too_late.contains(rule)) broken.insert(constraint_of(rule));
      }
      if (open == start && now.not_next.contains(c)) broken.insert(Constraint::NotNext);
      // Where steps may shut something out, when a late one may come takes a search to say.
      const bool late = now.late.contains(c) && !may_shut_out(spec);
      for (ConnectionIndex other = 0; late && other < connections; ++other) {
        if (open[other] && !now.inaccessible.contains(other) && !now.late.contains(other) &&
            !(open == start && now.not_next.contains(other)) &&
            world.facts(open, other, kept).legal())
          broken.insert(Constraint::Late);
      }
      truth.reward += facts.reward;
      open[c] = false;
    }
    if (!broken.empty()) truth.broken[i + 1] = broken;
  }
  for (ConnectionIndex c = 0; c < connections; ++c) {
    if (open[c] && !now.inaccessible.contains(c))
      truth.broken[sequence.size() + 1].insert(Constraint::NotOpen);
  }
  return truth;
}

/// Each connection with a chance of one in `in`.
ConnectionSet drawn(std::size_t connections, std::uint64_t in, SplitMix64& random) {
  ConnectionSet set(connections);
  for (std::size_t c = 0; c < connections; ++c) {
    if (random.below(in) == 0) set.insert(static_cast<ConnectionIndex>(c));
  }
  return set;
}

Situation drawn_situation(const Problem& problem, SplitMix64& random) {
  const std::size_t n = problem.num_connections();
  Situation now = Situation::whole(n);
  if (random.below(3) == 0) return now;
  if (random.below(2) == 0) {
    now.open = drawn(n, 2, random);
    for (ConnectionIndex c = 0; c < n; ++c) {
      if (random.below(2) == 0) now.open.insert(c);
    }
  }
  if (random.below(2) == 0) now.inaccessible = drawn(n, 5, random);
  if (random.below(2) == 0) now.not_next = drawn(n, 3, random);
  if (random.below(2) == 0) now.late = drawn(n, 3, random);
  return now;
}

/// Steps that are legal as long as there are any, then the rest in any order.
Sequence mostly_legal(const TransitionSystem& system, SplitMix64& random) {
  Expander expander(system);
  ConnectionSet open = system.start();
  Sequence sequence;
  while (!open.empty()) {
    const auto legal = expander.legal_actions(open.view());
    if (legal.empty()) {
      for_each_connection(open.view(), [&](ConnectionIndex c) { sequence.push_back(c); });
      break;
    }
    sequence.push_back(legal[random.below(legal.size())].connection);
    open.erase(sequence.back());
  }
  return sequence;
}

void shuffle(Sequence& sequence, SplitMix64& random) {
  for (std::size_t i = sequence.size(); i > 1; --i)
    std::swap(sequence[i - 1], sequence[random.below(i)]);
}

/// One mistake at random, or none.
void make_a_mistake(Sequence& sequence, std::size_t connections, SplitMix64& random) {
  if (sequence.empty()) return;
  const std::size_t at = random.below(sequence.size());
  switch (random.below(6)) {
    case 0: sequence.erase(sequence.begin() + static_cast<std::ptrdiff_t>(at)); break;
    case 1: sequence.push_back(sequence[at]); break;
    case 2: std::swap(sequence[at], sequence[random.below(sequence.size())]); break;
    case 3: sequence[at] = static_cast<ConnectionIndex>(random.below(connections)); break;
    case 4: shuffle(sequence, random); break;
    default: break;
  }
}

TEST(PlanCheck, AgreesWithBruteForceOnAnyPlanOfAnyProblemInAnySituation) {
  std::map<Constraint, int> met;
  int legal = 0;
  for (std::uint64_t seed = 0; seed < some_of(700U); ++seed) {
    const ProblemSpec spec = random_problem(seed + 20'000);
    const Problem problem(spec);
    SplitMix64 random(seed);
    for (int round = 0; round < 5; ++round) {
      const Situation now = drawn_situation(problem, random);
      const TransitionSystem system(problem, now);
      Sequence sequence = mostly_legal(system, random);
      make_a_mistake(sequence, problem.num_connections(), random);
      SCOPED_TRACE(spec.name + ", round " + std::to_string(round));
      const Truth truth = truth_of(spec, now, sequence);
      const PlanCheck check = check_plan(problem, now, sequence);
      ASSERT_EQ(check.legal, truth.broken.empty()) << check.fault;
      ASSERT_EQ(check.fault.empty(), check.legal);
      ASSERT_TRUE(same_reward(truth.reward, check)) << truth.reward << " " << check.reward;
      ASSERT_LE(check.tolerance, 1e-6);
      if (!check.legal) {
        ASSERT_EQ(check.step, truth.broken.begin()->first) << check.fault;
      }
      if (check.legal) ++legal;
      // evaluate() names the same rules at the same steps, in the words of the planners' rules.
      const Evaluation evaluation = evaluate(system, std::span<const ConnectionIndex>(sequence));
      std::map<std::size_t, std::set<Constraint>> named;
      for (const StepViolation& violation : evaluation.violations) {
        named[violation.step].insert(violation.violation.constraint);
        ++met[violation.violation.constraint];
      }
      ASSERT_EQ(named, truth.broken);
      ASSERT_EQ(evaluation.valid, check.legal);
    }
  }
  EXPECT_GE(legal, more_than(500));
  for (const Constraint constraint :
       {Constraint::Precedence, Constraint::PrecedenceAny, Constraint::PrecedenceMadeAny,
        Constraint::MaxSubassemblies, Constraint::MaxMovedParts, Constraint::MaxMovedMass,
        Constraint::Blocking, Constraint::NotOpen, Constraint::Inaccessible, Constraint::NotNext,
        Constraint::Late})
    EXPECT_GE(met[constraint], more_than(20)) << constraint_name(constraint);
}

// The facts that evaluate() gives are those of Expander::step, to the last bit.
TEST(PlanCheck, TheStepsOfAnEvaluationAreThoseOfThePlannersRules) {
  for (std::uint64_t seed = 0; seed < some_of(400U); ++seed) {
    const ProblemSpec spec = seed % 4 == 0 ? larger_random_problem(seed) : random_problem(seed);
    const Problem problem(spec);
    SplitMix64 random(seed);
    const TransitionSystem system(problem, drawn_situation(problem, random));
    Sequence sequence = mostly_legal(system, random);
    if (seed % 2 == 0) shuffle(sequence, random);
    SCOPED_TRACE(spec.name);
    const Evaluation evaluation = evaluate(system, std::span<const ConnectionIndex>(sequence));
    ASSERT_EQ(evaluation.steps.size(), sequence.size());
    Expander expander(system);
    ConnectionSet open = system.start();
    double reward = 0;
    for (const Step& step : evaluation.steps) {
      const Step other = expander.step(open.view(), step.connection);
      ASSERT_EQ(step.before, other.before);
      ASSERT_EQ(step.after, other.after);
      ASSERT_EQ(step.separates, other.separates);
      ASSERT_EQ(step.completes, other.completes);
      ASSERT_EQ(step.a_moves, other.a_moves);
      ASSERT_EQ(step.a, other.a);
      ASSERT_EQ(step.b, other.b);
      ASSERT_EQ(step.moved_mass, other.moved_mass);
      ASSERT_EQ(step.kept_mass, other.kept_mass);
      ASSERT_EQ(step.subassemblies, other.subassemblies);
      ASSERT_EQ(step.reward, other.reward);
      reward += other.reward;
      open.erase(step.connection);
    }
    ASSERT_EQ(evaluation.reward, reward);
  }
}

// ---- Rewards worked out by hand -----------------------------------------------------------------

/// The chain 1 - 2 - 3 - 4 with masses 1, 2, 4, 8 kg, parts at x = 0, 1, 2, 4 m and durations of
/// 10, 20, 30 s. Removing 2-3 first cuts 1 2 (3 kg, centroid x = 0.5) from 3 4 (12 kg); removing
/// 1-2 first cuts 1 from 2 3 4.
ProblemSpec weighted_chain(Objective objective, Direction direction = Direction::Disassembly) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  const std::vector<double> places = {0, 1, 2, 4};
  for (std::size_t p = 0; p < 4; ++p) {
    spec.parts[p].mass = static_cast<double>(1U << p);
    spec.parts[p].position = Vector3{places[p], 0, 0};
  }
  for (std::size_t c = 0; c < 3; ++c)
    spec.connections[c].duration = 10.0 * static_cast<double>(c + 1);
  spec.objective = std::move(objective);
  spec.direction = direction;
  return spec;
}

/// What the plan that cuts 2-3, 1-2, 3-4 earns, and the one that cuts 1-2, 2-3, 3-4.
void expect_rewards(const Objective& objective, double middle_first, double in_order) {
  SCOPED_TRACE(objective.type);
  const ProblemSpec spec = weighted_chain(objective);
  const PlanCheck one = checked(spec, {1, 0, 2});
  EXPECT_TRUE(one.legal) << one.fault;
  EXPECT_NEAR(one.reward, middle_first, 1e-9);
  EXPECT_TRUE(same_reward(middle_first, one));
  EXPECT_FALSE(same_reward(middle_first + 1e-5, one));
  const PlanCheck other = checked(spec, {0, 1, 2});
  EXPECT_NEAR(other.reward, in_order, 1e-9);
  EXPECT_FALSE(same_reward(in_order - 1e-5, other));
}

TEST(PlanCheck, RewardsByHandOfObjectivesThatCount) {
  // Sizes (2, 2), (1, 1), then the last; and (1, 3), (1, 2), then the last.
  expect_rewards(Objective::named("cubesat"), -2 * 0.1248 - 2 * 0.0967 + 1,
                 -(0.0967 + 0.1368) - (0.0967 + 0.1248) + 1);
  expect_rewards(Objective::named("custom"), -(0.1 + 3) - (0.1 + 2) + 1,
                 -(0.1 + 2.75) - (0.1 + 2.5) + 1);
  // A single part out of four is far, out of two near; out of three near too.
  expect_rewards(Objective::named("cubesat_zone"), -2 * 0.0722 - 2 * 0.0823 + 1,
                 -(0.0967 + 0.0782) - (0.0823 + 0.0722) + 1);
  expect_rewards({"piece_cost", PieceCost{0.25, {{1, 2.0}, {3, 7.0}}, 5}}, -0.25 - (0.25 + 4) + 5,
                 -(0.25 + 9) - (0.25 + 2) + 5);
  // n connections, index i: n - i if i < n - 1, else -1. n = 3: i = 1 earns 2; n = 2: i = 0 earns
  // 2; n = 1: -1. And 3, then n = 2, i = 1: -1, then -1.
  expect_rewards({"indexed", Indexed{}}, 2 + 2 - 1, 3 - 1 - 1);
  expect_rewards({"completion", CompletionObjective{100, 1, 1000}}, 3 * 99 + 1000, 3 * 99 + 1000);
  expect_rewards({"completion", CompletionObjective{-2, 0.5, 7}}, 3 * -2.5 + 7, 3 * -2.5 + 7);
}

TEST(PlanCheck, RewardsByHandOfObjectivesThatLookInside) {
  // Moved: 1 2 (centroid 0.5), then 1 of 1 2 (the lighter; at 0), then 3 of 3 4 (at 2). In order:
  // 1 (at 0), 2 of 2 3 4 (at 1), 3 of 3 4 (at 2). The depot lies at x = 4, so 3.5, 4, 2 m and 4, 3,
  // 2 m.
  expect_rewards({"time", TimeObjective{{4, 0, 0}, 2, 1}}, -60 - (3.5 + 4 + 2), -60 - (4 + 3 + 2));
  expect_rewards({"time", TimeObjective{{4, 3, 0}, 1, 1}},
                 -60 - 2 * (std::sqrt(21.25) + 5 + std::sqrt(13.0)),
                 -60 - 2 * (5 + std::sqrt(18.0) + std::sqrt(13.0)));
  expect_rewards({"travel", Travel{{4, 0, 0}}}, -(2 * 12.25 + 16 + 4), -(16 + 9 + 4));
  expect_rewards({"travel", Travel{{0, 0, 1}}}, -(2 * 1.25 + 1 + 5), -(1 + 2 + 5));
  // Moved masses 3, 1, 4 kg and 1, 2, 4 kg. With delta v = g Isp ln 2 a mass m burns m.
  const double doubling = 200 * 9.80665 * std::log(2.0);
  expect_rewards({"fuel", Fuel{6, doubling, 200}}, -(15 + 13 + 16), -(13 + 14 + 16));
  expect_rewards({"fuel", Fuel{1, 2 * doubling, 200}}, -3 * (5 + 3 + 6), -3 * (3 + 4 + 6));
}

TEST(PlanCheck, RewardsByHandOfFormulasFunctionsAndSums) {
  const auto expression = [](const std::string& formula) {
    return Objective{"expression", Expression{formula, {{"alpha", 2}}, {4, 0, 0}, compile_formula}};
  };
  expect_rewards(expression("alpha*moved_mass - kept_mass"), (6 - 12) + (2 - 2) + (8 - 8),
                 (2 - 14) + (4 - 12) + (8 - 8));
  expect_rewards(expression("distance + duration*index"), 3.5 + 4 + 2 + 20 + 60,
                 4 + 3 + 2 + 20 + 60);
  // Pieces of two or more parts after the step: 2, 1, 0 and 1, 1, 0.
  expect_rewards(expression("100*subassemblies + 10*before + after"), 300 + 60 + 3, 200 + 60 + 3);
  expect_rewards(expression("separates*moved_parts - kept_parts + 50*completes"), 0 + 0 + 0 + 50,
                 -2 - 1 - 0 + 50);
  Callable callable;
  callable.reward = [](const Step& step) {
    return static_cast<double>(step.moved().front() + 10 * step.kept().back()) + step.moved_mass;
  };
  // Moved and kept, parts from 0: 0 1 | 2 3; 0 | 1; 2 | 3; and 0 | 1 2 3; 1 | 2 3; 2 | 3.
  expect_rewards({"callable", callable}, 30 + 3 + 10 + 1 + 32 + 4, 30 + 1 + 31 + 2 + 32 + 4);
  WeightedSum inner{{{2, {"completion", CompletionObjective{1, 0, 0}}}}};
  WeightedSum outer{{{0.5, {"sum", inner}}, {-1, {"indexed", Indexed{}}}}};
  expect_rewards({"sum", outer}, 3 - 3, 3 - 1);
}

// In assembly the same formulas hold for the step that makes the connection: connections are there
// before it, and subassemblies after it.
TEST(PlanCheck, RewardsByHandInAssembly) {
  const auto reward = [](const Objective& objective, const Sequence& sequence) {
    return checked(weighted_chain(objective, Direction::Assembly), sequence).reward;
  };
  EXPECT_NEAR(reward(Objective::named("cubesat"), {0, 2, 1}), -4 * 0.0967 + 1, 1e-12);
  EXPECT_NEAR(reward(Objective::named("cubesat"), {0, 1, 2}), -3 * 0.0967 - 0.1248 + 1, 1e-12);
  // n = 0: i = 0 earns -1; n = 1, i = 2: -1; n = 2, i = 1: -1.
  EXPECT_NEAR(reward({"indexed", Indexed{}}, {0, 2, 1}), -3, 1e-12);
  const Objective counts = {
      "expression", Expression{"100*subassemblies + 10*before + after", {}, {}, compile_formula}};
  EXPECT_NEAR(reward(counts, {0, 2, 1}), 100 * (1 + 2 + 1) + 10 * 3 + 6, 1e-12);
  EXPECT_NEAR(reward({"time", TimeObjective{{4, 0, 0}, 2, 1}}, {0, 2, 1}), -60 - (4 + 2 + 3.5),
              1e-12);
}

TEST(PlanCheck, AMoveWithoutAPositionTakesTheTransferTime) {
  ProblemSpec spec = weighted_chain({"time", TimeObjective{{4, 0, 0}, 2, 100}});
  spec.parts[0].position.reset();
  EXPECT_NEAR(checked(spec, {1, 0, 2}).reward, -60 - 100 - 100 - 2, 1e-12);
  spec.objective = {"expression", Expression{"distance", {}, {4, 0, 0}, compile_formula}};
  EXPECT_NEAR(checked(spec, {1, 0, 2}).reward, 2, 1e-12);
}

// The zone's price of a single part: out of a whole starting piece of three it is the far one.
TEST(PlanCheck, AWholeStartingPieceIsFar) {
  ProblemSpec spec = instances::assembly(3, {{1, 2}, {2, 3}});
  spec.objective = Objective::named("cubesat_zone");
  EXPECT_NEAR(checked(spec, {0, 1}).reward, -(0.0967 + 0.0722) + 1, 1e-12);
  // The starting piece is that of the whole product, also in the middle of the work.
  spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.objective = Objective::named("cubesat_zone");
  Situation now = Situation::whole(3);
  now.open.erase(2);
  EXPECT_NEAR(check_plan(Problem(spec), now, Sequence{0, 1}).reward, -(0.0823 + 0.0722) + 1, 1e-12);
}

// Ties: equal sizes and masses, so the side without the earliest listed part moves; masses of 0.3
// and 0.1 + 0.2 are the same.
TEST(PlanCheck, WhichSideMovesOnATie) {
  ProblemSpec spec = instances::assembly(2, {{1, 2}});
  spec.parts[0].position = Vector3{1, 0, 0};
  spec.parts[1].position = Vector3{5, 0, 0};
  spec.objective = {"expression", Expression{"distance", {}, {}, compile_formula}};
  EXPECT_EQ(checked(spec, {0}).reward, 5);
  spec.parts[0].mass = 0.1 + 0.2;
  spec.parts[1].mass = 0.3;
  EXPECT_EQ(checked(spec, {0}).reward, 5);
  spec.parts[1].mass = 0.4;
  EXPECT_EQ(checked(spec, {0}).reward, 1);
}

// ---- Every kind of fault ------------------------------------------------------------------------

void expect_fault(const PlanCheck& check, std::size_t step, const std::string& sentence) {
  EXPECT_FALSE(check.legal);
  EXPECT_EQ(check.step, step);
  EXPECT_EQ(check.fault, sentence);
}

TEST(PlanCheck, FindsStepsThatAreNoneOfThePlan) {
  const ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  EXPECT_TRUE(checked(spec, {0, 1, 2}).legal);
  expect_fault(checked(spec, {0, 1, 1, 2}), 3, "step 3 removes \"2-3\", which was removed before");
  expect_fault(checked(spec, {0, 2}), 3, "the plan ends and \"2-3\" is missing");
  expect_fault(checked(spec, {}), 1, "the plan ends and \"1-2\" is missing");
  expect_fault(checked(spec, {0, 7, 1, 2}), 2,
               "step 2 handles connection number 7, counted from 0; the problem has 3");
  ProblemSpec assembly = spec;
  assembly.direction = Direction::Assembly;
  expect_fault(checked(assembly, {0, 0, 1, 2}), 2, "step 2 makes \"1-2\", which was made before");
}

TEST(PlanCheck, FindsStepsAgainstPrecedence) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.precedence = {{"2-3", {"1-2"}, {}}};
  EXPECT_TRUE(checked(spec, {0, 1, 2}).legal);
  expect_fault(checked(spec, {1, 0, 2}), 1,
               "step 1 removes \"2-3\" before \"1-2\", against precedence[0]");
  spec.direction = Direction::Assembly;
  EXPECT_TRUE(checked(spec, {1, 0, 2}).legal);
  expect_fault(checked(spec, {2, 0, 1}), 2,
               "step 2 makes \"1-2\" before \"2-3\", against precedence[0]");
  spec.precedence = {{"1-2", {}, {}}, {"2-3", {}, {"1-2", "3-4"}}};
  EXPECT_TRUE(checked(spec, {2, 1, 0}).legal);
  expect_fault(checked(spec, {2, 0, 1}), 2,
               "step 2 makes \"1-2\", after which \"2-3\" could no longer be made, against "
               "precedence[1]");
  spec.direction = Direction::Disassembly;
  EXPECT_TRUE(checked(spec, {2, 1, 0}).legal);
  expect_fault(checked(spec, {1, 0, 2}), 1,
               "step 1 removes \"2-3\" while all of after_any are there, against precedence[1]");
  spec.precedence = {{"3-4", {"3-4"}, {}}};
  expect_fault(checked(spec, {0, 1, 2}), 3,
               "step 3 removes \"3-4\", which by precedence[0] waits for itself");
  spec.precedence = {{.connection = "1-2", .made_after_any = {"2-3", "3-4"}}};
  EXPECT_TRUE(checked(spec, {1, 0, 2}).legal);
  expect_fault(checked(spec, {1, 2, 0}), 2,
               "step 2 removes \"3-4\", after which \"1-2\" would lack what it needs, against "
               "precedence[0]");
  spec.direction = Direction::Assembly;
  EXPECT_TRUE(checked(spec, {2, 0, 1}).legal);
  expect_fault(checked(spec, {0, 1, 2}), 1,
               "step 1 makes \"1-2\" while none of made_after_any is there, against precedence[0]");
}

TEST(PlanCheck, FindsStepsBeyondALimit) {
  ProblemSpec spec = weighted_chain(Objective());
  spec.limits.max_subassemblies = 1;
  EXPECT_TRUE(checked(spec, {0, 1, 2}).legal);
  expect_fault(checked(spec, {1, 0, 2}), 1,
               "step 1, which removes \"2-3\", leaves 2 subassemblies; limits.max_subassemblies "
               "allows at most 1");
  spec.limits = {};
  spec.limits.max_moved_parts = 1;
  EXPECT_TRUE(checked(spec, {0, 1, 2}).legal);
  expect_fault(checked(spec, {1, 0, 2}), 1,
               "step 1, which removes \"2-3\", moves 2 parts; limits.max_moved_parts allows at "
               "most 1");
  spec.limits = {};
  spec.limits.max_moved_mass = 4;
  EXPECT_TRUE(checked(spec, {0, 1, 2}).legal);
  spec.limits.max_moved_mass = 3.5;
  expect_fault(checked(spec, {0, 1, 2}), 3,
               "step 3, which removes \"3-4\", moves 4 kg; limits.max_moved_mass allows at most "
               "3.5 kg");
  // To the last digits 4 kg are 4 kg.
  spec.limits.max_moved_mass = 4 - 1e-10;
  EXPECT_TRUE(checked(spec, {0, 1, 2}).legal);

  spec = instances::two_pieces();
  spec.limits.max_subassemblies = 1;
  expect_fault(checked(spec, {0, 1}), 0,
               "the product at the start is 2 subassemblies; limits.max_subassemblies allows at "
               "most 1");
  spec.direction = Direction::Assembly;
  expect_fault(checked(spec, {0, 1}), 0,
               "the finished product is 2 subassemblies; limits.max_subassemblies allows at most "
               "1");
}

TEST(PlanCheck, FindsBlockedSteps) {
  EXPECT_TRUE(checked(instances::sandwich(), {1, 2, 0}).legal);
  expect_fault(checked(instances::sandwich(), {0, 1, 2}), 2,
               "step 2 removes \"1-2\", but blocking leaves no direction free for it");
}

TEST(PlanCheck, FindsWhatTheSituationForbids) {
  const Problem problem(instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}}));
  Situation now = Situation::whole(3);
  now.inaccessible.insert(1);
  EXPECT_TRUE(check_plan(problem, now, Sequence{0, 2}).legal);
  expect_fault(check_plan(problem, now, Sequence{0, 1, 2}), 2,
               "step 2 removes \"2-3\", which is inaccessible");
  now = Situation::whole(3);
  now.open.erase(1);
  EXPECT_TRUE(check_plan(problem, now, Sequence{0, 2}).legal);
  expect_fault(check_plan(problem, now, Sequence{1, 0, 2}), 1,
               "step 1 removes \"2-3\", which was removed before");
  now = Situation::whole(3);
  now.not_next.insert(1);
  EXPECT_TRUE(check_plan(problem, now, Sequence{0, 1, 2}).legal);
  expect_fault(check_plan(problem, now, Sequence{1, 0, 2}), 1,
               "step 1 removes \"2-3\", which cannot be the next step");
  now = Situation::whole(3);
  now.late.insert(0);
  EXPECT_TRUE(check_plan(problem, now, Sequence{1, 2, 0}).legal);
  expect_fault(check_plan(problem, now, Sequence{1, 0, 2}), 2,
               "step 2 removes \"1-2\", which is late, while \"3-4\" can be removed");
  // Not late where nothing else can be handled: 2-3 waits for it, and 3-4 cannot be next.
  ProblemSpec waits = problem.spec();
  waits.precedence = {{"2-3", {"1-2"}, {}}};
  now.not_next.insert(2);
  EXPECT_TRUE(check_plan(Problem(waits), now, Sequence{0, 1, 2}).legal);
}

// ---- Edges --------------------------------------------------------------------------------------

TEST(PlanCheck, TheSmallestProblems) {
  EXPECT_TRUE(checked(instances::nothing(), {}).legal);
  EXPECT_EQ(checked(instances::nothing(), {}).reward, 0);
  EXPECT_FALSE(checked(instances::nothing(), {0}).legal);
  EXPECT_TRUE(checked(instances::one_part(), {}).legal);
  EXPECT_TRUE(checked(instances::self_connection(), {0}).legal);
  EXPECT_EQ(checked(instances::self_connection(), {0}).reward, 1);
  ProblemSpec none = instances::assembly(3, {});
  none.limits.max_subassemblies = 0;
  EXPECT_TRUE(checked(none, {}).legal);
  // Parallel connections: the second one separates.
  ProblemSpec parallel = instances::assembly(2, {{1, 2}, {1, 2}});
  parallel.connections[1].id = "again";
  parallel.objective = {"completion", CompletionObjective{10, 1, 100}};
  EXPECT_EQ(checked(parallel, {1, 0}).reward, -1 + 10 - 1 + 100);
  EXPECT_NEAR(checked(instances::two_pieces(), {1, 0}).reward, 0.8066, 1e-12);
}

TEST(PlanCheck, TheLargestProblems) {
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    ProblemSpec spec = chain(kMaxParts);
    spec.direction = direction;
    spec.limits.max_moved_parts = 1;
    spec.objective = {"completion", CompletionObjective{100, 1, 1000}};
    const Problem problem(spec);
    Sequence sequence(problem.num_connections());
    std::iota(sequence.begin(), sequence.end(), ConnectionIndex{0});
    const PlanCheck check = checked(problem, sequence);
    EXPECT_TRUE(check.legal) << check.fault;
    EXPECT_EQ(check.reward, 99.0 * static_cast<double>(sequence.size()) + 1000);
    std::swap(sequence[7000], sequence[9000]);
    EXPECT_EQ(checked(problem, sequence).step, direction == Direction::Assembly ? 9000U : 7001U);
  }
}

TEST(PlanCheck, RefusesWhatCannotBeChecked) {
  ProblemSpec spec =
      weighted_chain({"expression", Expression{"1/(before - 2)", {}, {}, compile_formula}});
  EXPECT_EQ(fault_of([&] {
              static_cast<void>(checked(spec, {1, 0, 2}));
            }),
            "objective: the reward of removing \"1-2\" with 2 connections present is infinite; "
            "rewards must be finite");
  spec.objective = {"callable", Callable{}};
  std::get<Callable>(spec.objective.parameters).reward = [](const Step&) {
    return std::numeric_limits<double>::quiet_NaN();
  };
  EXPECT_EQ(fault_of([&] {
              static_cast<void>(checked(spec, {1, 0, 2}));
            }),
            "objective: the reward of removing \"2-3\" with 3 connections present is not a number; "
            "rewards must be finite");
  const Problem problem(weighted_chain(Objective()));
  EXPECT_EQ(
      fault_of([&] { static_cast<void>(check_plan(problem, Situation::whole(5), Sequence{})); }),
      "the situation is over 5 connections, the problem has 3");
}

TEST(PlanCheck, ARewardIsTheSameWithinTheRoundingOfItsSums) {
  PlanCheck check = checked(weighted_chain(Objective::named("cubesat")), {1, 0, 2});
  EXPECT_TRUE(same_reward(check.reward + 0.9e-9, check));
  EXPECT_FALSE(same_reward(check.reward + 1e-8, check));
  EXPECT_FALSE(same_reward(std::numeric_limits<double>::quiet_NaN(), check));
  EXPECT_FALSE(same_reward(std::numeric_limits<double>::infinity(), check));
  // Large rewards that cancel leave what their sum lost.
  WeightedSum sum{{{1e12, {"completion", CompletionObjective{1, 0, 0}}},
                   {-1e12, {"completion", CompletionObjective{1, 0, 0}}},
                   {1, Objective::named("cubesat")}}};
  check = checked(weighted_chain({"sum", sum}), {1, 0, 2});
  EXPECT_TRUE(same_reward(0.4, check));
  // Positions as they are seen from the Earth's centre, added up in both orders.
  ProblemSpec far = grid(8, 8);
  SplitMix64 random(1);
  for (Part& part : far.parts)
    part.position = Vector3{4.2e7 + random.uniform(), 1e7 * random.uniform(), random.uniform()};
  far.objective = {"travel", Travel{{4.2e7, 0, 0}}};
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    far.direction = direction;
    const Problem problem(far);
    const TransitionSystem system(problem);
    Expander expander(system);
    ConnectionSet open = system.start();
    double reward = 0;
    Sequence sequence;
    while (!open.empty()) {
      const auto legal = expander.legal_actions(open.view());
      const Action action = legal[random.below(legal.size())];
      reward += action.reward;
      sequence.push_back(action.connection);
      open.erase(action.connection);
    }
    EXPECT_TRUE(same_reward(reward, checked(problem, sequence)));
    EXPECT_FALSE(same_reward(reward * (1 + 1e-6), checked(problem, sequence)));
  }
}

}  // namespace
}  // namespace orasp
