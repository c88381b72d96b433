#include "orasp/model/step_directions.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/catalogue.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "tests/fault.h"
#include "tests/files.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using nlohmann::json;

std::vector<std::optional<DirectionIndex>> chosen(
    const std::vector<std::vector<DirectionIndex>>& free,
    const std::vector<std::optional<DirectionIndex>>& stated = {}) {
  std::vector<Step> steps(free.size());
  for (std::size_t i = 0; i < free.size(); ++i) steps[i].free_directions = free[i];
  choose_directions(steps, stated);
  std::vector<std::optional<DirectionIndex>> directions;
  for (const Step& step : steps) directions.push_back(step.direction);
  return directions;
}

std::optional<DirectionIndex> along(std::uint16_t direction) {
  return DirectionIndex(direction);
}

TEST(StepDirections, StayWhereTheyAreFree) {
  EXPECT_EQ(chosen({{4, 1}, {}, {0, 1, 4}, {0, 1}, {}, {4, 1}}),
            (std::vector<std::optional<DirectionIndex>>{along(4), std::nullopt, along(4), along(0),
                                                        std::nullopt, along(4)}));
  EXPECT_TRUE(chosen({}).empty());
}

TEST(StepDirections, AreThoseThatAreStatedWhereTheyAreFree) {
  EXPECT_EQ(
      chosen({{4, 1}, {4, 1}, {4, 1}, {}}, {along(1), std::nullopt, along(3), along(1)}),
      (std::vector<std::optional<DirectionIndex>>{along(1), along(1), along(1), std::nullopt}));
}

/// Of each step of a plan, what is free by brute force over the ProblemSpec.
std::vector<std::set<std::string>> truth_of(const ProblemSpec& spec,
                                            std::span<const ConnectionIndex> sequence) {
  const oracle::World world(spec);
  oracle::State open = world.start();
  std::vector<std::set<std::string>> free;
  for (const ConnectionIndex c : sequence) {
    free.push_back(world.facts(open, c).free_directions);
    open[c] = false;
  }
  return free;
}

/// The names of the directions in the order of the file, the opposites of named ones among them.
std::vector<std::string> listed_names(const ProblemSpec& spec) {
  std::vector<std::string> names;
  if (!spec.blocking) return names;
  for (const BlockingDirection& direction : spec.blocking->directions) {
    names.push_back(direction.id);
    if (direction.vector) names.push_back("-" + direction.id);
  }
  return names;
}

/// The directions of a plan file are what docs/format.md says; returns how many steps have one.
std::size_t expect_directions(const ProblemSpec& spec, const Result& result) {
  const Problem problem(spec);
  const json plan = json::parse(plan_text(problem, result, {}));
  const auto truth = truth_of(problem.spec(), result.sequence);
  const std::vector<std::string> names = listed_names(spec);
  std::string last;
  std::size_t directed = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const json& step = plan.at("steps").at(i);
    const bool moves = spec.blocking && step.at("separates");
    EXPECT_EQ(step.contains("direction"), moves);
    EXPECT_EQ(step.contains("free_directions"), moves);
    if (!moves) continue;
    std::vector<std::string> expected;
    for (const std::string& name : names) {
      if (truth[i].contains(name)) expected.push_back(name);
    }
    EXPECT_EQ(step.at("free_directions"), json(expected));
    last = truth[i].contains(last) ? last : expected.at(0);
    EXPECT_EQ(step.at("direction"), last);
    ++directed;
  }
  // What is written is read, and found valid.
  const PlanFile file = parse_plan(plan.dump(), spec.direction);
  EXPECT_EQ(!file.directions.empty(), directed > 0);
  EXPECT_TRUE(evaluate(problem, file.sequence, file.directions).valid);
  return directed;
}

TEST(PlanDirections, AreFreeInRandomProblems) {
  std::size_t directed = 0;
  std::size_t named = 0;
  for (std::uint64_t seed = 0; seed < some_of(1500U); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    const Problem problem(spec);
    const Result result = solve(Task(problem), seed % 2 == 0 ? "greedy" : "random");
    if (!result.has_plan()) continue;
    SCOPED_TRACE(seed);
    const std::size_t found = expect_directions(spec, result);
    directed += found;
    if (spec.blocking && spec.blocking->directions.back().vector) named += found;
  }
  EXPECT_GE(directed, more_than(300));
  EXPECT_GE(named, more_than(60));
}

TEST(PlanDirections, AreNoneInTheBuiltInProblems) {
  for (const char* name : {"hubble", "4brick", "lattice"}) {
    const Problem problem = load_scenario(name);
    EXPECT_EQ(expect_directions(problem.spec(), solve(Task(problem), "greedy")), 0U);
  }
}

TEST(PlanDirections, AreFreeInTheShelf) {
  const Problem shelf = read_problem(source_folder() / "examples/shelf.json");
  EXPECT_EQ(expect_directions(shelf.spec(), solve(Task(shelf), "auto")), 6U);
  const Problem built = shelf.with_direction(Direction::Assembly);
  EXPECT_EQ(expect_directions(built.spec(), solve(Task(built), "auto")), 6U);
}

TEST(PlanDirections, AreFreeInModelsOfLego) {
  const std::filesystem::path folder = shared_folder() / "problems/lego";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "there is no " << folder;
  std::size_t models = 0;
  for (const auto& file : json_files(folder)) {
    const Problem problem = read_problem(file);
    if (problem.num_connections() > 45) continue;
    const Result result = solve(Task(problem), "greedy");
    if (!result.has_plan()) continue;
    SCOPED_TRACE(file.filename());
    EXPECT_GT(expect_directions(problem.spec(), result), 0U);
    if (++models == 20) return;
  }
  FAIL() << models << " models are too few";
}

// A direction that is stated breaks a rule exactly where something is in the way.
TEST(CheckPlan, JudgesStatedDirections) {
  std::size_t good = 0;
  std::size_t bad = 0;
  for (std::uint64_t seed = 0; seed < some_of(800U); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    const Problem problem(spec);
    if (!spec.blocking) continue;
    const Result result = solve(Task(problem), "greedy");
    if (!result.has_plan()) continue;
    const Situation whole = Situation::whole(problem.num_connections());
    const auto truth = truth_of(spec, result.sequence);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      for (const DirectionIndex d : problem.directions()) {
        std::vector<std::optional<DirectionIndex>> directions(truth.size());
        directions[i] = d;
        const PlanCheck check = check_plan(problem, whole, result.sequence, directions);
        const std::string& name = problem.direction_name(d);
        const bool fits = truth[i].empty() || truth[i].contains(name);
        EXPECT_EQ(check.legal, fits) << seed << ", step " << i + 1 << ", " << name;
        EXPECT_EQ(check.step, fits ? 0 : i + 1);
        std::vector<std::string> names(truth.size());
        names[i] = name;
        std::vector<std::string> ids;
        for (const ConnectionIndex c : result.sequence) ids.push_back(problem.connection_id(c));
        const Evaluation evaluation = evaluate(problem, ids, names);
        EXPECT_EQ(evaluation.valid, fits);
        ASSERT_EQ(evaluation.violations.size(), fits ? 0U : 1U);
        if (!fits) {
          EXPECT_EQ(evaluation.violations[0].step, i + 1);
        } else if (!truth[i].empty()) {
          EXPECT_EQ(evaluation.steps[i].direction, d);
        }
        ++(fits ? good : bad);
      }
    }
  }
  EXPECT_GE(good, more_than(500));
  EXPECT_GE(bad, more_than(200));
}

Problem two_on_a_base() {
  return parse_problem(R"({"format": "orasp-problem/1",
      "parts": [{"id": "base"}, {"id": "a"}, {"id": "b"}],
      "connections": [{"parts": ["base", "a"]}, {"parts": ["a", "base"], "id": "second"},
                      {"parts": ["base", "b"]}],
      "blocking": {"directions": ["+x", "-x", {"id": "slant", "vector": [0, 1, 1]}],
                   "blocked": [{"part": "a", "by": "base", "directions": ["+x", "-slant"]}]}})");
}

TEST(CheckPlan, NamesTheDirectionThatIsNotFree) {
  const Problem problem = two_on_a_base();
  const std::vector<ConnectionIndex> sequence = {0, 1, 2};
  const auto check = [&](std::vector<std::optional<DirectionIndex>> directions) {
    return check_plan(problem, Situation::whole(3), sequence, directions);
  };
  EXPECT_TRUE(check({std::nullopt, along(6), along(7)}).legal);
  EXPECT_TRUE(check({along(0), along(1), std::nullopt}).legal);  // nothing moves in the first step
  EXPECT_EQ(
      check({std::nullopt, along(7), std::nullopt}).fault,
      "step 2 removes \"second\" and states the direction -slant, in which \"base\" is in the "
      "way of \"a\"");
  EXPECT_EQ(fault_of([&] { return check({std::nullopt}); }),
            "the plan has 3 steps and states 1 directions");
}

TEST(Evaluate, NamesTheDirectionThatIsNotFree) {
  const Problem problem = two_on_a_base();
  const auto violations = [&](const std::string& direction) {
    const std::string plan = R"({"format": "orasp-plan/1",
        "disassembly": ["base-a", "second", "base-b"],
        "steps": [{"connection": "base-b"}, {"connection": "second", "direction": ")" +
                             direction + R"("}]})";
    const PlanFile file = parse_plan(plan, Direction::Disassembly);
    std::string text;
    for (const StepViolation& found : evaluate(problem, file.sequence, file.directions).violations)
      text += std::to_string(found.step) + ": " + found.violation.message;
    return text;
  };
  EXPECT_EQ(violations("slant"), "");
  EXPECT_EQ(
      violations("+x"),
      "2: the plan states the direction +x, in which \"base\" is in the way of \"a\"; free are "
      "-x, slant");
  EXPECT_EQ(
      violations("up"),
      "2: the plan states the direction \"up\", which is not in blocking.directions; free are "
      "-x, slant");
}

TEST(PlanJson, RefusesDirectionsThatAreNoNames) {
  const auto fault = [](const std::string& steps) {
    return fault_of([&] {
      return parse_plan(
          R"({"format": "orasp-plan/1", "disassembly": ["a"], "steps": )" + steps + "}",
          Direction::Disassembly);
    });
  };
  EXPECT_EQ(fault(R"([{"connection": "a"}, 3, {"connection": "a", "direction": 1}])"),
            "steps[2].direction: expected the name of a direction, found the number 1");
  EXPECT_EQ(fault(R"([{"direction": "+x"}])"),
            "steps[0]: it states a direction, but no connection");
  EXPECT_EQ(fault(R"("none")"), "no fault");
  EXPECT_EQ(fault(R"([{"connection": "b", "direction": "+x"}])"), "no fault");
}

TEST(PlanJson, FindsDirectionsInBothOrders) {
  const std::string plan =
      R"({"format": "orasp-plan/1", "assembly": ["b", "a"],
          "steps": [{"connection": "b", "direction": "+x"}, {"connection": "a"}]})";
  EXPECT_EQ(parse_plan(plan, Direction::Disassembly).directions,
            (std::vector<std::string>{"", "+x"}));
  EXPECT_EQ(parse_plan(plan, Direction::Assembly).directions, (std::vector<std::string>{"+x", ""}));
}

}  // namespace
}  // namespace orasp
