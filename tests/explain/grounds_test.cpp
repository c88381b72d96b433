// What allows a step: with the violations that the model finds, exactly the constraints that bear
// on it.

#include "orasp/explain/grounds.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "orasp/io/problem_json.h"
#include "orasp/model/validate.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// Four parts in a row, held together by 1-2, 2-3, 3-4, with more members of the file.
Problem row(const std::string& more = "") {
  return parse_problem(
      R"({"format": "orasp-problem/1",
          "parts": [{"id": "1"}, {"id": "2"}, {"id": "3"}, {"id": "4"}],
          "connections": [{"parts": ["1", "2"]}, {"parts": ["2", "3"]}, {"parts": ["3", "4"]}])" +
      more + "}");
}

std::vector<std::vector<Ground>> grounds_of(const Problem& problem,
                                            const std::vector<std::string>& sequence) {
  const TransitionSystem system(problem);
  return grounds(system, evaluate(system, std::span<const std::string>(sequence)).steps);
}

TEST(Grounds, AStepThatNothingBearsOnHasNone) {
  for (const auto& found : grounds_of(row(), {"1-2", "2-3", "3-4"})) EXPECT_TRUE(found.empty());
}

TEST(Grounds, AMetPrecedenceNamesTheStepInEitherOrder) {
  const Problem problem =
      row(R"(, "precedence": [{"connection": "3-4", "after": ["1-2"], "after_any": ["2-3"]}])");
  const auto found = grounds_of(problem, {"1-2", "2-3", "3-4"});
  ASSERT_EQ(found[2].size(), 2);
  EXPECT_EQ(found[2][0].where, "precedence[0]");
  EXPECT_EQ(found[2][0].disassembly, "goes only after \"1-2\" (step 1)");
  EXPECT_EQ(found[2][0].assembly, "is made before \"1-2\" (step 3)");
  EXPECT_EQ(found[2][1].constraint, Constraint::PrecedenceAny);
  EXPECT_EQ(found[2][1].disassembly,
            "goes only after at least one of \"2-3\", here \"2-3\" (step 2)");
}

TEST(Grounds, LimitsSayHowMuchOfThemASeparationTakes) {
  const Problem problem =
      row(R"(, "limits": {"max_subassemblies": 2, "max_moved_parts": 3, "max_moved_mass": 2.5})");
  const auto found = grounds_of(problem, {"2-3", "1-2", "3-4"});
  // 2-3 cuts the row into 1-2 and 3-4: two subassemblies, two parts moved, 2 kg.
  ASSERT_EQ(found[0].size(), 3);
  EXPECT_EQ(found[0][0].disassembly, "leaves 2 of at most 2 subassemblies");
  EXPECT_EQ(found[0][0].assembly, "starts from 2 of at most 2 subassemblies");
  EXPECT_EQ(found[0][1].disassembly, "moves 2 of at most 3 parts");
  EXPECT_EQ(found[0][2].disassembly, "moves 2 of at most 2.5 kg");
  EXPECT_EQ(found[1][0].disassembly, "leaves 1 of at most 2 subassemblies");
}

TEST(Grounds, AnAssemblyCountsSubassembliesBeforeTheJoint) {
  const Problem problem = row(R"(, "direction": "assembly", "limits": {"max_subassemblies": 2})");
  const auto found = grounds_of(problem, {"1-2", "3-4", "2-3"});
  EXPECT_EQ(found[0][0].assembly, "starts from 0 of at most 2 subassemblies");
  EXPECT_EQ(found[2][0].assembly, "starts from 2 of at most 2 subassemblies");
}

TEST(Grounds, BlockingNamesTheWaysOfTheMovedPiece) {
  const Problem problem = row(R"(, "blocking": {"directions": ["+x", "-x"],
                                  "blocked": [{"part": "1", "by": "2", "directions": ["+x"]}]})");
  const auto found = grounds_of(problem, {"1-2", "2-3", "3-4"});
  // 1 cannot leave 2 along +x, so it leaves along -x, and comes on along +x. 2 is not blocked by 3
  // and 4.
  ASSERT_EQ(found[0].size(), 1);
  EXPECT_EQ(found[0][0].disassembly, "free to leave along -x");
  EXPECT_EQ(found[0][0].assembly, "free to come on along +x");
  EXPECT_EQ(found[1][0].disassembly, "nothing is in the way: free along +x, -x");
}

/// Constraints that bear on a step by the problem's own entries: those of docs/format.md.
std::multiset<std::string> bearing_on(const Problem& problem, const Step& step) {
  std::multiset<std::string> places;
  for (const PrecedenceClause& clause : problem.precedence()) {
    const std::string where = "precedence[" + std::to_string(clause.entry) + "]";
    const bool own = clause.connection == step.connection;
    // In assembly the one that is made later waits.
    const bool named = std::ranges::find(clause.after, step.connection) != clause.after.end();
    const bool assembly = problem.direction() == Direction::Assembly;
    if (assembly ? named : own && !clause.after.empty()) places.insert(where);
    if (own && !assembly && !clause.after_any.empty()) places.insert(where);
    if (own && assembly && !clause.made_after_any.empty()) places.insert(where);
  }
  if (!step.separates) return places;
  if (problem.limits().max_subassemblies) places.insert("limits.max_subassemblies");
  if (problem.limits().max_moved_parts) places.insert("limits.max_moved_parts");
  if (problem.limits().max_moved_mass) places.insert("limits.max_moved_mass");
  if (!problem.directions().empty()) places.insert("blocking");
  return places;
}

TEST(Grounds, WhatBearsOnAStepIsEitherMetOrViolated) {
  std::size_t met = 0;
  std::size_t broken = 0;
  for (std::uint64_t seed = 1; seed < 1 + some_of(600U); ++seed) {
    const Problem problem(random_problem(seed));
    const TransitionSystem system(problem);
    // Connections in the order of the file, legal or not.
    std::vector<std::string> sequence;
    for (const Connection& connection : problem.connections()) sequence.push_back(connection.id);
    const Evaluation evaluation = evaluate(system, std::span<const std::string>(sequence));
    const auto found = grounds(system, evaluation.steps);
    ASSERT_EQ(found.size(), evaluation.steps.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      std::multiset<std::string> places;
      // Rules that are met by the step that they are about, and broken by another one.
      const Constraint ahead = problem.direction() == Direction::Assembly
                                   ? Constraint::PrecedenceAny
                                   : Constraint::PrecedenceMadeAny;
      for (const Ground& ground : found[i]) {
        if (ground.constraint != ahead) places.insert(ground.where);
      }
      met += places.size();
      for (const StepViolation& violation : evaluation.violations) {
        if (violation.step != i + 1 || violation.violation.constraint == ahead) continue;
        places.insert(violation.violation.where);
        ++broken;
      }
      EXPECT_EQ(places, bearing_on(problem, evaluation.steps[i]))
          << "seed " << seed << ", step " << i + 1;
    }
  }
  EXPECT_GE(met, more_than(500));
  EXPECT_GE(broken, more_than(100));
}

TEST(FreeDirections, AreNoneExactlyWhereBlockingIsViolated) {
  for (std::uint64_t seed = 1; seed < 1 + some_of(400U); ++seed) {
    const Problem problem(random_problem(seed));
    if (problem.directions().empty()) continue;
    const TransitionSystem system(problem);
    Expander expander(system);
    ConnectionSet open = system.start();
    while (!open.empty()) {
      ConnectionIndex last = 0;
      for_each_connection(open.view(), [&](ConnectionIndex c) {
        last = c;
        const bool separates = expander.step(open.view(), c).separates;
        const auto violations = expander.violations(open.view(), c);
        const bool blocked = std::ranges::any_of(violations, [](const Violation& violation) {
          return violation.constraint == Constraint::Blocking;
        });
        EXPECT_EQ(separates && expander.free_directions(open.view(), c).empty(), blocked) << seed;
      });
      open.erase(last);
    }
  }
}

}  // namespace
}  // namespace orasp
