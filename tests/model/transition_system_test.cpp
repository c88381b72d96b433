#include "orasp/model/transition_system.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/graph/state_graph.h"
#include "orasp/model/random.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/model/validate.h"
#include "tests/checks.h"
#include "tests/fault.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using instances::assembly;

oracle::Rule rule_of(Constraint constraint) {
  switch (constraint) {
    case Constraint::Precedence: return oracle::Rule::Precedence;
    case Constraint::PrecedenceAny: return oracle::Rule::PrecedenceAny;
    case Constraint::PrecedenceMadeAny: return oracle::Rule::PrecedenceMadeAny;
    case Constraint::MaxSubassemblies: return oracle::Rule::MaxSubassemblies;
    case Constraint::MaxMovedParts: return oracle::Rule::MaxMovedParts;
    case Constraint::MaxMovedMass: return oracle::Rule::MaxMovedMass;
    case Constraint::Blocking: return oracle::Rule::Blocking;
    case Constraint::NotOpen:
    case Constraint::Inaccessible:
    case Constraint::NotNext:
    case Constraint::Late:
    case Constraint::Grounded:
    case Constraint::Goal:
    case Constraint::NotOneStep: break;
  }
  throw std::logic_error("no constraint that the oracle knows");
}

oracle::Parts as_parts(const std::vector<PartIndex>& list) {
  return {list.begin(), list.end()};
}

/// legal_actions(), step() and violations() of one state against the oracle.
void expect_same_rules(Expander& expander, const TransitionSystem& system,
                       const oracle::World& world, const oracle::State& open) {
  const ConnectionSet set = oracle::set_of(open);
  std::string text;
  for (const bool bit : open) text += bit ? '1' : '0';
  SCOPED_TRACE("open connections " + text);

  const auto span = expander.legal_actions(set.view());
  const std::vector<Action> actions(span.begin(), span.end());
  const std::vector<oracle::Facts> legal = world.legal_facts(open);
  ASSERT_EQ(actions.size(), legal.size());
  for (std::size_t i = 0; i < actions.size(); ++i) {
    EXPECT_EQ(actions[i].connection, legal[i].connection);
    EXPECT_NEAR(actions[i].reward, legal[i].reward, reward_tolerance(legal[i].reward));
  }

  const auto number_open = static_cast<std::size_t>(std::count(open.begin(), open.end(), true));
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (!open[i]) continue;
    const auto c = static_cast<ConnectionIndex>(i);
    SCOPED_TRACE("connection " + system.problem().connection_id(c));
    const oracle::Facts facts = world.facts(open, i);
    const Step step = expander.step(set.view(), c);
    EXPECT_EQ(step.connection, c);
    EXPECT_EQ(step.before, facts.before);
    EXPECT_EQ(step.after, facts.after);
    EXPECT_EQ(step.separates, facts.separates);
    EXPECT_EQ(step.completes, facts.completes);
    EXPECT_EQ(step.subassemblies, facts.subassemblies);
    EXPECT_TRUE(std::is_sorted(step.a.begin(), step.a.end()));
    EXPECT_TRUE(std::is_sorted(step.b.begin(), step.b.end()));
    EXPECT_EQ(as_parts(step.a), facts.a);
    EXPECT_EQ(as_parts(step.b), facts.b);
    if (facts.separates) {
      EXPECT_EQ(as_parts(step.moved()), facts.moved);
    }
    EXPECT_NEAR(step.moved_mass, facts.moved_mass, reward_tolerance(facts.moved_mass));
    EXPECT_NEAR(step.kept_mass, facts.kept_mass, reward_tolerance(facts.kept_mass));
    EXPECT_NEAR(step.reward, facts.reward, reward_tolerance(facts.reward));

    std::set<oracle::Rule> broken;
    for (const Violation& violation : expander.violations(set.view(), c)) {
      broken.insert(rule_of(violation.constraint));
      EXPECT_FALSE(violation.message.empty());
    }
    EXPECT_EQ(broken, facts.broken);
    EXPECT_EQ(expander.legal(set.view(), c), facts.legal());

    const RewardRange range = system.reward_range(c, number_open, facts.completes);
    EXPECT_LE(range.least, facts.reward + reward_tolerance(facts.reward));
    EXPECT_GE(range.greatest, facts.reward - reward_tolerance(facts.reward));
  }
}

class TransitionSystemOnRandomProblems : public testing::TestWithParam<int> {};

TEST_P(TransitionSystemOnRandomProblems, AgreesWithTheOracleInEveryReachableState) {
  for (std::uint64_t seed = 0; seed < some_of(60U); ++seed) {
    const ProblemSpec spec =
        random_problem(1000 + static_cast<std::uint64_t>(GetParam()) * 60 + seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    Expander expander(system);
    const oracle::World world(spec);
    for (const auto& [open, value] : oracle::brute_force(spec).best_to_go) {
      expect_same_rules(expander, system, world, open);
      if (HasFailure()) return;  // one state is enough to read
    }
  }
}

// Many states in one call, in any company: the same actions and, bit for bit, the same rewards.
TEST_P(TransitionSystemOnRandomProblems, ExpandsManyStatesAsOneByOne) {
  for (std::uint64_t seed = 0; seed < some_of(60U); ++seed) {
    const ProblemSpec spec =
        random_problem(6000 + static_cast<std::uint64_t>(GetParam()) * 60 + seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    Expander many(system);
    Expander single(system);
    std::vector<std::uint64_t> states;
    for (const auto& [open, value] : oracle::brute_force(spec).best_to_go) {
      const ConnectionSet set = oracle::set_of(open);
      states.insert(states.end(), set.view().begin(), set.view().end());
    }
    std::size_t visited = 0;
    many.for_each_expansion(states, [&](std::size_t i, std::span<const Action> actions) {
      EXPECT_EQ(i, visited++);
      const auto expected = single.legal_actions(std::span(states).subspan(i, 1));
      ASSERT_EQ(actions.size(), expected.size());
      for (std::size_t k = 0; k < actions.size(); ++k) {
        EXPECT_EQ(actions[k].connection, expected[k].connection);
        EXPECT_EQ(actions[k].reward, expected[k].reward);
      }
    });
    EXPECT_EQ(visited, states.size());
    if (HasFailure()) return;
  }
}

// The checker judges illegal steps too, and replanning starts anywhere.
TEST_P(TransitionSystemOnRandomProblems, AgreesWithTheOracleInEverySetOfConnections) {
  for (std::uint64_t seed = 0; seed < some_of(40U); ++seed) {
    const ProblemSpec spec =
        random_problem(2000 + static_cast<std::uint64_t>(GetParam()) * 40 + seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    if (problem.num_connections() > 6) continue;
    const TransitionSystem system(problem);
    Expander expander(system);
    const oracle::World world(spec);
    for (unsigned bits = 0; bits < 1U << problem.num_connections(); ++bits) {
      oracle::State open(problem.num_connections());
      for (std::size_t c = 0; c < open.size(); ++c) open[c] = (bits >> c & 1U) != 0;
      expect_same_rules(expander, system, world, open);
      if (HasFailure()) return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, TransitionSystemOnRandomProblems, testing::Range(0, 6));

// -------------------------------------------------------------------------------------------------

/// The ids of the legal actions in the state in which `handled` have been handled.
std::vector<std::string> legal_after(const ProblemSpec& spec,
                                     const std::vector<std::string>& handled = {}) {
  const Problem problem(spec);
  const TransitionSystem system(problem);
  Expander expander(system);
  ConnectionSet open = system.start();
  for (const std::string& id : handled) open.erase(problem.find_connection(id, "test"));
  std::vector<std::string> ids;
  for (const Action& action : expander.legal_actions(open.view()))
    ids.push_back(problem.connection_id(action.connection));
  return ids;
}

/// The step that handles `id` after `handled`.
Step step_after(const ProblemSpec& spec, const std::vector<std::string>& handled,
                const std::string& id) {
  const Problem problem(spec);
  const TransitionSystem system(problem);
  Expander expander(system);
  ConnectionSet open = system.start();
  for (const std::string& done : handled) open.erase(problem.find_connection(done, "test"));
  return expander.step(open.view(), problem.find_connection(id, "test"));
}

using Ids = std::vector<std::string>;
using Indices = std::vector<PartIndex>;

// 1 - 2 - 3: of {1} and {2, 3} the one with fewer parts moves, however heavy.
TEST(MovedPiece, IsTheOneWithFewerParts) {
  ProblemSpec spec = instances::chain_of_three();
  spec.parts[0].mass = 100;
  const Step step = step_after(spec, {}, "1-2");
  EXPECT_EQ(step.a, Indices({0}));
  EXPECT_EQ(step.b, Indices({1, 2}));
  EXPECT_EQ(step.moved(), Indices({0}));
  EXPECT_DOUBLE_EQ(step.moved_mass, 100);
  EXPECT_DOUBLE_EQ(step.kept_mass, 2);
}

// 1 (5 kg) - 2 (4 kg): one part each, the lighter moves, whichever end of the connection is listed
// first.
TEST(MovedPiece, IsTheLighterOneOnATie) {
  for (const bool turned : {false, true}) {
    ProblemSpec spec = assembly(2, {turned ? std::pair{2, 1} : std::pair{1, 2}});
    spec.parts[0].mass = 5;
    spec.parts[1].mass = 4;
    const Step step = step_after(spec, {}, turned ? "2-1" : "1-2");
    EXPECT_EQ(step.moved(), Indices({1}));
    EXPECT_EQ(step.a, turned ? Indices({1}) : Indices({0}));
  }
}

// 1 - 2 - 3 - 4 cut in the middle; parts and masses tie, part 1 is listed first and stays.
TEST(MovedPiece, IsTheOneWithoutTheEarliestPartOnATieOfMass) {
  EXPECT_EQ(step_after(instances::greedy_trap(), {}, "2-3").moved(), Indices({2, 3}));
  EXPECT_EQ(step_after(assembly(4, {{2, 4}, {4, 1}, {1, 3}}), {}, "4-1").moved(), Indices({1, 3}));
}

// 1 (0.3) - 2 (0) - 3 (0.1) - 4 (0.2): 0.1 + 0.2 and 0.3 are one mass to a user (in binary they
// differ by 6e-17, which would make {1, 2} the lighter), so the tie goes to the piece without part
// 1.
TEST(MovedPiece, TakesMassesThatDifferByRoundingForATie) {
  ProblemSpec spec = instances::greedy_trap();
  spec.parts[0].mass = 0.3;
  spec.parts[1].mass = 0;
  spec.parts[2].mass = 0.1;
  spec.parts[3].mass = 0.2;
  ASSERT_NE(0.1 + 0.2, 0.3);
  EXPECT_EQ(step_after(spec, {}, "2-3").moved(), Indices({2, 3}));
}

// 1 - 2 - 3 - 4 - 5, at most one subassembly: only the ends may be cut, since 2-3 leaves {1, 2} and
// {3, 4, 5}.
TEST(Limits, MaxSubassembliesCountsPiecesOfTwoOrMore) {
  ProblemSpec spec = chain(5);
  spec.limits.max_subassemblies = 1;
  EXPECT_EQ(legal_after(spec), Ids({"1-2", "4-5"}));
  spec.limits.max_subassemblies = 2;
  EXPECT_EQ(legal_after(spec), Ids({"1-2", "2-3", "3-4", "4-5"}));
}

// Two products of two parts under a limit of one: 1-2 may not even be begun with, the start is too
// much already.
TEST(Limits, AStartWithTooManySubassembliesIsInfeasible) {
  ProblemSpec spec = instances::two_pieces();
  spec.limits.max_subassemblies = 1;
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    spec.direction = direction;
    const Problem problem(spec);
    const auto reason = TransitionSystem(problem).infeasibility();
    ASSERT_TRUE(reason.has_value());
    EXPECT_EQ(constraint_name(reason->constraint), "max_subassemblies");
  }
}

// 1 - 2 - 3 - 4: the cut in the middle moves two parts of 1 kg.
TEST(Limits, MovedPartsAndMassBindTheMovedPieceOnly) {
  ProblemSpec parts = instances::greedy_trap();
  parts.limits.max_moved_parts = 1;
  EXPECT_EQ(legal_after(parts), Ids({"1-2", "3-4"}));
  ProblemSpec mass = instances::greedy_trap();
  mass.limits.max_moved_mass = 1.5;
  EXPECT_EQ(legal_after(mass), Ids({"1-2", "3-4"}));
  mass.limits.max_moved_mass = 2;
  EXPECT_EQ(legal_after(mass), Ids({"1-2", "2-3", "3-4"}));
}

// A piece of 0.1 + 0.2 kg may be carried where 0.3 kg may.
TEST(Limits, AMassEqualToTheLimitIsAllowedWhateverTheRounding) {
  ProblemSpec spec = instances::greedy_trap();
  for (Part& part : spec.parts) part.mass = 0.2;
  spec.parts[2].mass = 0.1;
  spec.limits.max_moved_mass = 0.3;
  EXPECT_EQ(legal_after(spec), Ids({"1-2", "2-3", "3-4"}));
  spec.limits.max_moved_mass = 0.2999;
  EXPECT_EQ(legal_after(spec), Ids({"1-2", "3-4"}));
}

// A ring 1 - 2 - 3 - 1 under limits that forbid every separation: the first removal separates
// nothing and is free of them; after it the ring is a chain and nothing more may go.
TEST(Limits, DoNotBindARemovalThatDoesNotSeparate) {
  ProblemSpec spec = assembly(3, {{1, 2}, {2, 3}, {1, 3}});
  spec.limits.max_moved_parts = 0;
  EXPECT_EQ(legal_after(spec), Ids({"1-2", "2-3", "1-3"}));
  EXPECT_EQ(legal_after(spec, {"1-2"}), Ids{});
}

// 1 - 2 - 3 - 4 - 5: 4-5 waits for both of 1-2, 2-3 and for one of 3-4, 2-3.
TEST(PrecedenceRule, AfterNeedsAllAndAfterAnyNeedsOne) {
  ProblemSpec spec = chain(5);
  spec.precedence = {
      {"4-5", {"1-2"}, {}}, {"4-5", {"2-3"}, {"3-4", "2-3"}}, {"1-2", {}, {"3-4", "2-3"}}};
  EXPECT_EQ(legal_after(spec), Ids({"2-3", "3-4"}));
  EXPECT_EQ(legal_after(spec, {"3-4"}), Ids({"1-2", "2-3"}));
  EXPECT_EQ(legal_after(spec, {"3-4", "1-2"}), Ids({"2-3"}));
  EXPECT_EQ(legal_after(spec, {"2-3", "1-2"}), Ids({"3-4", "4-5"}));
}

// The same for assembly: 1-2 and 2-3 are made after 4-5; 1-2 before at least one of 3-4, 2-3.
TEST(PrecedenceRule, IsReversedInAssembly) {
  ProblemSpec spec = chain(5);
  spec.precedence = {{"4-5", {"1-2", "2-3"}, {}}, {"1-2", {}, {"3-4", "2-3"}}};
  spec.direction = Direction::Assembly;
  EXPECT_EQ(legal_after(spec), Ids({"3-4", "4-5"}));
  EXPECT_EQ(legal_after(spec, {"4-5"}), Ids({"1-2", "2-3", "3-4"}));
  EXPECT_EQ(legal_after(spec, {"4-5", "3-4"}), Ids({"1-2"}));  // 2-3 would shut out 1-2
  EXPECT_EQ(legal_after(spec, {"2-3"}), Ids{});  // 4-5 is too late, and 3-4 would shut out 1-2
  EXPECT_EQ(legal_after(spec, {"4-5", "3-4", "2-3"}), Ids{});  // 1-2 is too late: both are there
}

// 1 - 2 - 3 - 4 - 5, stated by the way it is made: 1-2 after 3-4, and after 2-3 or 4-5.
TEST(PrecedenceRule, IsStatedByTheWayTheProductIsMade) {
  ProblemSpec spec = chain(5);
  spec.precedence = {
      {.connection = "1-2", .made_after = {"3-4"}, .made_after_any = {"2-3", "4-5"}}};
  EXPECT_EQ(legal_after(spec), Ids({"1-2", "2-3", "4-5"}));
  EXPECT_EQ(legal_after(spec, {"2-3"}), Ids({"1-2"}));  // 3-4 and 4-5 are needed as long as 1-2 is
  EXPECT_EQ(legal_after(spec, {"2-3", "1-2"}), Ids({"3-4", "4-5"}));
  spec.direction = Direction::Assembly;
  EXPECT_EQ(legal_after(spec), Ids({"2-3", "3-4", "4-5"}));
  EXPECT_EQ(legal_after(spec, {"3-4"}), Ids({"2-3", "4-5"}));
  EXPECT_EQ(legal_after(spec, {"3-4", "4-5"}), Ids({"1-2", "2-3"}));
}

// Each of 1-2 and 2-3 needs the other or 3-4: without 3-4 neither could have been put on first.
TEST(PrecedenceRule, WhatHoldsOnlyEachOtherCouldNotHaveBeenPutOn) {
  ProblemSpec spec = chain(4);
  spec.precedence = {{.connection = "1-2", .made_after_any = {"2-3", "3-4"}},
                     {.connection = "2-3", .made_after_any = {"1-2", "3-4"}}};
  EXPECT_EQ(legal_after(spec), Ids({"1-2", "2-3"}));
  EXPECT_EQ(legal_after(spec, {"1-2"}), Ids({"2-3"}));
  EXPECT_EQ(legal_after(spec, {"1-2", "2-3"}), Ids({"3-4"}));
}

// Blocked along +x alone, 1 may leave 2 along -x.
TEST(BlockingRule, OneFreeDirectionIsEnough) {
  ProblemSpec spec = instances::boxed_in();
  EXPECT_EQ(legal_after(spec), Ids{});
  spec.blocking->blocked = {{"2", "1", {"+x"}}};
  EXPECT_EQ(legal_after(spec), Ids({"1-2"}));
}

// 1 is blocked by 2 along +x; 2 is blocked by 1 along +x, so 1 by 2 along -x too: nothing is free.
TEST(BlockingRule, IsAntisymmetric) {
  ProblemSpec spec = assembly(2, {{1, 2}});
  spec.blocking = Blocking{{"+x", "-x"}, {{"1", "2", {"+x"}}, {"2", "1", {"+x"}}}};
  EXPECT_EQ(legal_after(spec), Ids{});
  spec.blocking = Blocking{{"+x", "-x"}, {{"1", "2", {"+x"}}, {"2", "1", {"-x"}}}};
  EXPECT_EQ(legal_after(spec), Ids({"1-2"}));
  spec.blocking = Blocking{{"+x", "-x", "+y", "-y"}, {{"1", "2", {"+x"}}, {"2", "1", {"+x"}}}};
  EXPECT_EQ(legal_after(spec), Ids({"1-2"}));  // along y
}

// sandwich() without its precedence: 1 between 3 and 2. With 1-3 gone, 1-2 would pull 1 out of the
// middle; with 2-3 gone as well it may go, since 3 is in another piece by then.
TEST(BlockingRule, LooksAtThePartsOfTheTwoPiecesOnly) {
  ProblemSpec spec = instances::sandwich();
  spec.precedence.clear();
  EXPECT_EQ(legal_after(spec), Ids({"1-3", "1-2", "2-3"}));
  EXPECT_EQ(legal_after(spec, {"1-3"}), Ids({"2-3"}));
  EXPECT_EQ(legal_after(spec, {"1-3", "2-3"}), Ids({"1-2"}));
}

// 1 - 2 - 3 - 4 with a construction zone: a single part out of a piece of 4 costs 0.0967, out of a
// smaller piece that is not a whole starting piece 0.0823; two parts cost 0.0722, three 0.0782.
TEST(CubesatZoneObjective, DependsOnThePieceAPartCameFrom) {
  ProblemSpec spec = instances::greedy_trap();
  spec.objective = Objective::named("cubesat_zone");
  EXPECT_NEAR(step_after(spec, {}, "3-4").reward, -(0.0967 + 0.0782), 1e-12);
  EXPECT_NEAR(step_after(spec, {}, "2-3").reward, -(0.0722 + 0.0722), 1e-12);
  EXPECT_NEAR(step_after(spec, {"3-4"}, "2-3").reward, -(0.0823 + 0.0722), 1e-12);
  EXPECT_NEAR(step_after(spec, {"2-3"}, "1-2").reward, -(0.0823 + 0.0823), 1e-12);
  EXPECT_NEAR(step_after(spec, {"3-4", "2-3"}, "1-2").reward, 1, 1e-12);
  // Of a product of 2 + 2 parts each piece is a whole starting piece.
  ProblemSpec pieces = instances::two_pieces();
  pieces.objective = spec.objective;
  EXPECT_NEAR(step_after(pieces, {}, "1-2").reward, -(0.0967 + 0.0967), 1e-12);
  // A ring's first removal separates nothing and costs nothing.
  ProblemSpec ring = assembly(3, {{1, 2}, {2, 3}, {1, 3}});
  ring.objective = spec.objective;
  EXPECT_NEAR(step_after(ring, {}, "1-2").reward, 0, 1e-12);
  EXPECT_NEAR(step_after(ring, {"1-2"}, "2-3").reward, -(0.0967 + 0.0722), 1e-12);
}

// n = 3 connections present: n - i = 3, 2 for i = 0, 1 and -1 for i = 2. In assembly n counts what
// is present before the step: 0, 1, 2; only i < n - 1 earns, so 0 is the one, when two are there.
TEST(IndexedObjective, CountsWhatIsPresentBeforeTheStep) {
  ProblemSpec spec = instances::greedy_trap();
  spec.objective = Objective::named("indexed");
  EXPECT_EQ(step_after(spec, {}, "1-2").reward, 3);
  EXPECT_EQ(step_after(spec, {}, "2-3").reward, 2);
  EXPECT_EQ(step_after(spec, {}, "3-4").reward, -1);
  EXPECT_EQ(step_after(spec, {"2-3"}, "1-2").reward, 2);
  spec.direction = Direction::Assembly;
  EXPECT_EQ(step_after(spec, {}, "1-2").reward, -1);
  EXPECT_EQ(step_after(spec, {"3-4"}, "1-2").reward, -1);
  EXPECT_EQ(step_after(spec, {"2-3", "3-4"}, "1-2").reward, 2);
}

// 1 at x = 0 and 2, 3 at x = 3, 5 m; depot at (0, 0, 0), 2 m/s. Cutting 1-2 moves {1}: 0 m. Cutting
// 2-3 moves {3}: 2 * 5 / 2 = 5 s. Duration 10 s. Where the moved part has no position the transfer
// takes 7 s.
TEST(TimeObjective, AddsTheTransferOfTheMovedPiece) {
  ProblemSpec spec = instances::chain_of_three();
  spec.parts[0].position = Vector3{0, 0, 0};
  spec.parts[1].position = Vector3{3, 0, 0};
  spec.parts[2].position = Vector3{5, 0, 0};
  for (Connection& connection : spec.connections) connection.duration = 10;
  spec.objective = {"time", TimeObjective{.depot = {}, .speed = 2, .transfer = 7}};
  EXPECT_DOUBLE_EQ(step_after(spec, {}, "1-2").reward, -10);
  EXPECT_DOUBLE_EQ(step_after(spec, {}, "2-3").reward, -15);
  spec.parts[1].position.reset();
  EXPECT_DOUBLE_EQ(step_after(spec, {}, "2-3").reward, -15);
  spec.parts[2].position.reset();
  EXPECT_DOUBLE_EQ(step_after(spec, {}, "2-3").reward, -17);
}

// A piece of two parts at (1, 0, 0) and (1, 4, 0) and a depot at (1, -1, 0): centroid (1, 2, 0), 3
// m, so -2 * 9.
TEST(TravelObjective, IsSquaredDistanceOfTheCentroidForEachPart) {
  ProblemSpec spec = instances::greedy_trap();
  spec.parts[0].position = Vector3{9, 9, 9};
  spec.parts[1].position = Vector3{8, 8, 8};
  spec.parts[2].position = Vector3{1, 0, 0};
  spec.parts[3].position = Vector3{1, 4, 0};
  spec.objective = {"travel", Travel{.depot = {1, -1, 0}}};
  EXPECT_DOUBLE_EQ(step_after(spec, {}, "2-3").reward, -18);
}

// Default tug, 1 kg moved: k = 30 / (200 * 9.80665) = 0.01529574..., e^k - 1 = 0.01541332...; 13 kg
// of that.
TEST(FuelObjective, IsTheRocketEquationOutEmptyAndBackLoaded) {
  ProblemSpec spec = instances::chain_of_three();
  spec.objective = Objective::named("fuel");
  EXPECT_NEAR(step_after(spec, {}, "1-2").reward, -13 * std::expm1(30 / (200 * 9.80665)), 1e-12);
  // Two such steps are the best plan of `3piece`, which earns -0.400746.
  EXPECT_NEAR(step_after(spec, {}, "1-2").reward, -0.200373, 5e-7);
}

// 1 ) - 2: the connection of part 1 to itself separates nothing and is bound by precedence alone;
// the last removal completes even if it separates nothing.
TEST(SelfConnection, SeparatesNothing) {
  ProblemSpec spec = assembly(2, {{1, 1}, {1, 2}});
  spec.limits.max_moved_parts = 0;
  EXPECT_EQ(legal_after(spec), Ids({"1-1"}));
  spec.limits = {};
  const Step first = step_after(spec, {}, "1-1");
  EXPECT_FALSE(first.separates);
  EXPECT_EQ(first.subassemblies, 1U);
  EXPECT_EQ(first.reward, 0);
  const Step last = step_after(spec, {"1-2"}, "1-1");
  EXPECT_TRUE(last.completes);
  EXPECT_FALSE(last.separates);
  EXPECT_EQ(last.subassemblies, 0U);
  EXPECT_EQ(last.reward, 1);
  const Problem problem(spec);
  EXPECT_EQ(problem.warnings().size(), 1U);
}

// Two connections a and b between 1 and 2: the first to go separates nothing.
TEST(ParallelConnections, OnlyTheLastOfThemSeparates) {
  ProblemSpec spec = assembly(3, {{1, 2}, {1, 2}, {2, 3}});
  spec.connections[0].id = "a";
  spec.connections[1].id = "b";
  EXPECT_FALSE(step_after(spec, {}, "a").separates);
  EXPECT_TRUE(step_after(spec, {"b"}, "a").separates);
  EXPECT_EQ(step_after(spec, {"b"}, "a").moved(), Indices({0}));
}

// 1 - 2   3 - 4: removing 1-2 leaves one subassembly, and the step knows nothing of 3 and 4.
TEST(StartPieces, AreSeparateProducts) {
  const Step step = step_after(instances::two_pieces(), {}, "1-2");
  EXPECT_EQ(step.a, Indices({0}));
  EXPECT_EQ(step.b, Indices({1}));
  EXPECT_EQ(step.subassemblies, 1U);
  EXPECT_FALSE(step.completes);
  EXPECT_TRUE(step_after(instances::two_pieces(), {"1-2"}, "3-4").completes);
}

// Assembly of 1 - 2 - 3: before the first step nothing is present. 1-2 joins {1} and {2}: -2 *
// 0.0967; then 2-3 joins {1, 2} and {3} and completes.
TEST(AssemblyDirection, JoinsTheTwoPieces) {
  ProblemSpec spec = instances::chain_of_three();
  spec.direction = Direction::Assembly;
  const Step first = step_after(spec, {}, "1-2");
  EXPECT_EQ(first.before, 0U);
  EXPECT_EQ(first.after, 1U);
  EXPECT_EQ(first.a, Indices({0}));
  EXPECT_EQ(first.b, Indices({1}));
  EXPECT_EQ(first.subassemblies, 1U);
  EXPECT_FALSE(first.completes);
  EXPECT_NEAR(first.reward, -0.1934, 1e-12);
  const Step second = step_after(spec, {"1-2"}, "2-3");
  EXPECT_EQ(second.before, 1U);
  EXPECT_EQ(second.a, Indices({0, 1}));
  EXPECT_EQ(second.b, Indices({2}));
  EXPECT_EQ(second.moved(), Indices({2}));
  EXPECT_TRUE(second.completes);
  EXPECT_EQ(second.reward, 1);
}

// Precedence that can never be met is found without search, and the message spells the cycle out.
TEST(Infeasibility, NamesTheCycle) {
  const Problem problem(instances::locked_ring());
  const auto reason = TransitionSystem(problem).infeasibility();
  ASSERT_TRUE(reason.has_value());
  EXPECT_EQ(constraint_name(reason->constraint), "precedence");
  for (const char* id : {"1-2", "2-3", "1-3"})
    EXPECT_NE(reason->message.find(id), std::string::npos) << reason->message;
}

// What stands in the way is there as data: the entry of the file and the connections.
TEST(Violations, NameThePlaceAndTheConnectionsInTheWay) {
  ProblemSpec spec = chain(5);
  spec.precedence = {
      {"1-2", {}, {}}, {"4-5", {"3-4", "1-2", "2-3"}, {}}, {"4-5", {}, {"3-4", "2-3"}}};
  spec.limits.max_moved_parts = 0;
  const Problem problem(spec);
  const TransitionSystem system(problem);
  Expander expander(system);
  ConnectionSet open = system.start();
  open.erase(0);
  const std::vector<Violation> found = expander.violations(open.view(), 3);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(constraint_name(found[0].constraint), "precedence");
  EXPECT_EQ(found[0].where, "precedence[1]");
  EXPECT_EQ(found[0].blocking_connections, (std::vector<ConnectionIndex>{1, 2}));
  EXPECT_EQ(found[1].where, "precedence[2]");
  EXPECT_EQ(found[1].blocking_connections, (std::vector<ConnectionIndex>{1, 2}));
  EXPECT_EQ(constraint_name(found[2].constraint), "max_moved_parts");
  EXPECT_EQ(found[2].where, "limits.max_moved_parts");
  EXPECT_TRUE(found[2].blocking_connections.empty());
  for (const Violation& violation : found) {
    EXPECT_NE(violation.message.find("4-5"), std::string::npos) << violation.message;
  }
  const std::vector<Violation> again = expander.violations(open.view(), 0);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].constraint, Constraint::NotOpen);
}

// 1-2 waits for one of 2-3 and 3-4, each of which waits for 1-2: a cycle through `after_any`.
TEST(Infeasibility, SeesCyclesThroughAfterAny) {
  ProblemSpec spec = instances::greedy_trap();
  spec.precedence = {{"1-2", {}, {"2-3", "3-4"}}, {"2-3", {"1-2"}, {}}, {"3-4", {"1-2"}, {}}};
  const Problem closed(spec);
  EXPECT_TRUE(TransitionSystem(closed).infeasibility().has_value());
  spec.precedence.pop_back();  // now 3-4 is free, and so is everything after it
  const Problem open(spec);
  EXPECT_FALSE(TransitionSystem(open).infeasibility().has_value());
}

// -------------------------------------------------------------------------------------------------
// More than 64 connections.

class WideChain : public testing::TestWithParam<std::size_t> {};

// Cut from the left one part moves off each time: -0.0967, and -0.1368 more when 3 parts are left
// behind; the last three parts are 3piece: 0.7785.
TEST_P(WideChain, ComesApartFromTheLeft) {
  const std::size_t parts = GetParam();
  const Problem problem(chain(parts));
  const TransitionSystem system(problem);
  EXPECT_EQ(system.words(), (parts - 1 + 63) / 64);
  Expander expander(system);
  ConnectionSet open = system.start();
  double total = 0;
  for (ConnectionIndex c = 0; c + 1 < parts; ++c) {
    const auto actions = expander.legal_actions(open.view());
    ASSERT_EQ(actions.size(), parts - 1 - c);
    ASSERT_EQ(actions.front().connection, c);
    total += actions.front().reward;
    open.erase(c);
  }
  EXPECT_TRUE(open.empty());
  const double expected = 0.7785 - static_cast<double>(parts - 3) * 0.0967 - 0.1368;
  EXPECT_NEAR(total, expected, 1e-9);
}

TEST_P(WideChain, AgreesWithTheOracleAlongARandomSequence) {
  const std::size_t parts = GetParam();
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    ProblemSpec spec = chain(parts);
    spec.direction = direction;
    spec.limits.max_moved_parts = parts / 3;
    for (std::size_t p = 0; p < parts; ++p) spec.parts[p].mass = 0.1 * static_cast<double>(p % 5);
    const std::string last = std::to_string(parts - 1) + "-" + std::to_string(parts);
    spec.precedence = {
        {"1-2", {last}, {}}, {last, {}, {"2-3", "30-31"}}, {"40-41", {"1-2"}, {"5-6"}}};
    const Problem problem(spec);
    const TransitionSystem system(problem);
    Expander expander(system);
    const oracle::World world(spec);
    SplitMix64 random(parts);
    oracle::State open = world.start();
    for (std::size_t step = 0; step + 1 < parts; ++step) {
      if (step % (parts / 10) == 0 || step + 10 > parts) {
        expect_same_rules(expander, system, world, open);
        if (HasFailure()) return;
      }
      const auto actions = expander.legal_actions(oracle::set_of(open).view());
      if (actions.empty()) break;
      open[actions[static_cast<std::size_t>(random.below(actions.size()))].connection] = false;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lengths, WideChain, testing::Values(64, 65, 66, 128, 200));

// 1,000 connections, as a chain of 1,001 parts in which each connection waits for the one before
// it.
TEST(WideProblem, OfAThousandConnectionsHasItsStates) {
  ProblemSpec spec = chain(1001);
  for (std::size_t c = 1; c < 1000; ++c) {
    const auto id = [](std::size_t i) {
      return std::to_string(i + 1) + "-" + std::to_string(i + 2);
    };
    spec.precedence.push_back({id(c), {id(c - 1)}, {}});
  }
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const StateGraph graph = StateGraph::build(system, Budget{});
  EXPECT_EQ(graph.num_states(), 1001U);
  EXPECT_EQ(graph.num_actions(), 1000U);
  EXPECT_TRUE(graph.goal().has_value());
}

// In assembly each waits for the one that is removed after it, so there is one order.
TEST(WideProblem, OfAThousandConnectionsIsReversedInAssembly) {
  ProblemSpec spec = chain(1001);
  spec.direction = Direction::Assembly;
  for (std::size_t c = 1; c < 1000; ++c) {
    const auto id = [](std::size_t i) {
      return std::to_string(i + 1) + "-" + std::to_string(i + 2);
    };
    spec.precedence.push_back({id(c), {id(c - 1)}, {}});
  }
  const Problem problem(spec);
  const TransitionSystem system(problem);
  Expander expander(system);
  ConnectionSet open = system.start();
  for (ConnectionIndex c = 999; c > 0; --c) {
    const auto legal = expander.legal_actions(open.view());
    ASSERT_EQ(legal.size(), 1U);
    ASSERT_EQ(legal.front().connection, c);
    EXPECT_FALSE(expander.legal(open.view(), c - 1));
    open.erase(c);
  }
}

/// `small` among `filler` more connections of the first part to itself, which must go one after the
/// other before anything of `small`: in front of its connections in the file, or after them.
ProblemSpec embedded(const ProblemSpec& small, std::size_t filler, bool in_front) {
  ProblemSpec wide = small;
  std::vector<Connection> fill;
  const auto id = [](std::size_t i) { return "filler" + std::to_string(i); };
  for (std::size_t i = 0; i < filler; ++i) {
    Connection connection;
    connection.id = id(i);
    connection.parts = {small.parts[0].id, small.parts[0].id};
    fill.push_back(connection);
    if (i > 0) wide.precedence.push_back({id(i), {id(i - 1)}, {}});
  }
  for (const Connection& connection : small.connections) {
    const std::string own =
        connection.id.empty() ? connection.parts[0] + "-" + connection.parts[1] : connection.id;
    wide.precedence.push_back({own, {id(filler - 1)}, {}});
  }
  wide.connections.insert(in_front ? wide.connections.begin() : wide.connections.end(),
                          fill.begin(), fill.end());
  return wide;
}

// A chain of m connections that must stay in one piece: what is present is a run of neighbours, so
// m (m + 1) / 2 states and the empty one; each run of one may lose its connection and each longer
// run one at either end, so m + 2 (m (m - 1) / 2) = m^2 actions.
TEST(WideProblem, ChainInOnePieceHasItsRunsAsStates) {
  for (const std::size_t m : {12U, 63U, 64U, 65U, 130U}) {
    ProblemSpec spec = chain(m + 1);
    spec.limits.max_subassemblies = 1;
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const StateGraph graph = StateGraph::build(system, Budget{});
    EXPECT_EQ(graph.num_states(), m * (m + 1) / 2 + 1) << m;
    EXPECT_EQ(graph.num_actions(), m * m) << m;
  }
}

// The same in assembly: reversed, a step must *begin* with at most one subassembly. So from every
// run any of the m - L connections not in it may be made; one that touches it makes a longer run,
// another a state of two subassemblies, a run of L and a single one, from which nothing is legal
// any more.
TEST(WideProblem, ChainInOnePieceHasDeadEndsInAssembly) {
  for (const std::size_t m : {12U, 40U, 65U}) {
    ProblemSpec spec = chain(m + 1);
    spec.limits.max_subassemblies = 1;
    spec.direction = Direction::Assembly;
    std::size_t states = 1;
    std::size_t actions = m;
    for (std::size_t begin = 0; begin < m; ++begin) {
      for (std::size_t end = begin + 1; end <= m; ++end) {
        ++states;
        actions += m - (end - begin);
        for (std::size_t single = 0; single < m; ++single) {
          const bool apart = single + 1 < begin || single > end;
          const bool once = end - begin > 1 || single > begin;  // two singles: one state
          if (apart && once) ++states;
        }
      }
    }
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const StateGraph graph = StateGraph::build(system, Budget{});
    EXPECT_EQ(graph.num_states(), states) << m;
    EXPECT_EQ(graph.num_actions(), actions) << m;
  }
}

TEST(TransitionSystem, RefusesAnObjectiveOfAFleet) {
  ProblemSpec spec;
  spec.parts.resize(2);
  spec.parts[0].id = "1";
  spec.parts[1].id = "2";
  spec.fleet = Fleet{};
  spec.objective = Objective::named("makespan");
  const Problem problem(spec);
  try {
    const TransitionSystem system(problem);
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "objective: \"makespan\" judges plans of several robots and no plan of one; name "
                 "another objective, or plan for the fleet");
  }
}

// The code for more than one word must agree with the oracle as the code for one word does; H is
// that of the small problem with one state for each filler in front.
TEST(WideProblem, AgreesWithTheOracleOnEmbeddedRandomProblems) {
  for (std::uint64_t seed = 3000; seed < 3000 + some_of(40U); ++seed) {
    ProblemSpec small = random_problem(seed);
    small.direction =
        Direction::Disassembly;  // in assembly precedence forces no order, and H would be enormous
    if (small.parts.empty() || small.connections.size() > 6) continue;
    for (const bool in_front : {false, true}) {
      const ProblemSpec wide = embedded(small, 65 + seed % 3, in_front);
      SCOPED_TRACE(wide.name + (in_front ? ", fillers in front" : ", fillers behind"));
      const Problem problem(wide);
      const TransitionSystem system(problem);
      ASSERT_GE(system.words(), 2U);
      Expander expander(system);
      const oracle::World world(wide);
      const oracle::OracleResult truth = oracle::brute_force(wide);
      std::size_t number = 0;
      for (const auto& [open, value] : truth.best_to_go) {
        if (number++ % 5 != 0) continue;  // a fifth of them is enough
        expect_same_rules(expander, system, world, open);
        if (HasFailure()) return;
      }
      const StateGraph graph = StateGraph::build(system, Budget{});
      EXPECT_EQ(graph.num_states(), truth.states);
      EXPECT_EQ(graph.num_actions(), truth.actions);
      const oracle::OracleResult alone = oracle::brute_force(small);
      EXPECT_EQ(truth.states, alone.states + 65 + seed % 3);
      EXPECT_EQ(truth.sequences, alone.sequences);
    }
  }
}

/// The sentence that refuses the rewards of a problem, or of its first steps.
std::string fault_of_rewards(const ProblemSpec& spec) {
  return fault_of([&] {
    const Problem problem(spec);
    const TransitionSystem system(problem);
    Expander expander(system);
    return expander.legal_actions(system.start().view()).size();
  });
}

// Rewards of 1e308 add up to minus infinity, which is what having no plan is worth: value iteration
// would prove that there is none.
TEST(TransitionSystem, RefusesRewardsWhoseSumsAreNotFinite) {
  ProblemSpec spec = instances::chain_of_three();
  spec.objective = {"piece_cost", PieceCost{1e308, {{1, 1e308}}, 0}};
  EXPECT_EQ(
      fault_of_rewards(spec).find("objective: a step may earn or cost infinity, and 2 such steps"),
      0U)
      << fault_of_rewards(spec);
  spec.objective = {"piece_cost", PieceCost{8e307, {}, 0}};
  EXPECT_EQ(fault_of_rewards(spec),
            "objective: a step may earn or cost 8e+307, and 2 such steps add up to no finite "
            "number; choose larger units");
  spec.objective = {"piece_cost", PieceCost{1e305, {}, 0}};
  EXPECT_EQ(fault_of_rewards(spec), "no fault");
  spec.objective = {"sum", WeightedSum{{{1e300, {"piece_cost", PieceCost{1e300, {}, 0}}}}}};
  EXPECT_NE(fault_of_rewards(spec), "no fault");
}

TEST(TransitionSystem, RefusesAStepWhoseRewardIsTooLargeWhereNoRangeIsKnown) {
  ProblemSpec spec = instances::chain_of_three();
  spec.objective = {"fuel", Fuel{.dry_mass = 6, .delta_v = 1e9, .isp = 1}};
  EXPECT_NE(fault_of_rewards(spec).find("is infinite; rewards must be finite"), std::string::npos)
      << fault_of_rewards(spec);
  Callable huge;
  huge.reward = [](const Step&) { return 1e308; };
  spec.objective = {"callable", huge};
  EXPECT_NE(fault_of_rewards(spec).find("is 1e+308; sums of rewards must be finite"),
            std::string::npos)
      << fault_of_rewards(spec);
  huge.reward = [](const Step&) { return 1e7; };
  spec.objective = {"sum", WeightedSum{{{1e300, {"callable", huge}}}}};
  EXPECT_NE(fault_of_rewards(spec).find("sums of rewards must be finite"), std::string::npos)
      << fault_of_rewards(spec);
}

}  // namespace
}  // namespace orasp
