// The keys base, goal, action, numbers, attributes, changeover and route, as files state them.

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/catalogue.h"
#include "orasp/execution/replanner.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/situation.h"
#include "tests/fault.h"

namespace orasp {
namespace {

using nlohmann::json;

/// A bench, a box, a lid and two screws.
json box() {
  return json::parse(R"({
    "format": "orasp-problem/1",
    "parts": [{"id": "bench", "position": [0, 0, 0]}, {"id": "box", "position": [0, 0, 1]},
              {"id": "lid", "position": [0, 0, 2]}, {"id": "s1", "position": [1, 0, 2]},
              {"id": "s2", "position": [-1, 0, 2]}],
    "connections": [
      {"id": "clamp", "parts": ["bench", "box"], "duration": 4},
      {"id": "hinge", "parts": ["box", "lid"], "duration": 3, "attributes": {"tool": "hand"}},
      {"id": "screw 1", "parts": ["lid", "s1"], "duration": 2, "attributes": {"tool": "M3"}},
      {"id": "screw 2", "parts": ["lid", "s2"], "duration": 2, "attributes": {"tool": "M4"}}],
    "objective": {"type": "expression", "formula": "-duration"}})");
}

json with(const json& changes) {
  json problem = box();
  if (changes.contains("objective")) problem.erase("objective");
  problem.merge_patch(changes);
  return problem;
}

std::string fault(const json& changes) {
  return fault_of([&] { return parse_problem(with(changes).dump()); });
}

/// The same with one connection changed.
std::string fault_of_connection(const json& changes) {
  json problem = box();
  problem["connections"][2].merge_patch(changes);
  return fault_of([&] { return parse_problem(problem.dump()); });
}

Problem problem_with(const json& changes) {
  return parse_problem(with(changes).dump());
}

TEST(WideKeys, ComeBackAsTheyWereWritten) {
  const json changes = json::parse(R"({
    "base": ["bench"], "limits": {"grounded": true}, "goal": {"free": ["s1"], "stop": "best"},
    "objective": {"type": "sum", "terms": [
      {"type": "changeover", "attribute": "tool", "cost": 2, "start": "M4",
       "costs": [{"from": "M3", "to": "M4", "cost": 0.5}]},
      {"type": "route", "start": [1, 2, 3], "per_metre": 0.5},
      {"type": "expression", "formula": "value - moved_value*elapsed"}]}})");
  json problem = with(changes);
  problem["connections"][0]["position"] = {0, 0, 0.5};
  problem["connections"][0]["numbers"] = {{"value", 2.5}};
  problem["parts"][1]["numbers"] = {{"value", 7}};
  const Problem first = parse_problem(problem.dump());
  const Problem second = parse_problem(problem_text(first));
  EXPECT_EQ(problem_text(first), problem_text(second));
  EXPECT_EQ(problem_digest(first), problem_digest(second));
  EXPECT_EQ(second.spec().base, std::vector<std::string>{"bench"});
  EXPECT_EQ(second.spec().goal->stop, Goal::Stop::Best);
  EXPECT_EQ(second.parts()[1].numbers.at("value"), 7);
  EXPECT_EQ(second.place(0), (Vector3{0, 0, 0.5}));
  EXPECT_EQ(second.place(1), (Vector3{0, 0, 1.5}));
}

TEST(WideKeys, EachChangesTheDigest) {
  std::vector<std::string> digests = {problem_digest(parse_problem(box().dump()))};
  for (const char* const changes :
       {R"({"base": ["bench"]})", R"({"base": ["box"]})", R"({"goal": {"free": ["s1"]}})",
        R"({"goal": {"free": ["s1"], "stop": "best"}})", R"({"action": "part"})",
        R"({"base": ["bench"], "limits": {"grounded": true}})",
        R"({"objective": {"type": "changeover", "attribute": "tool"}})",
        R"({"objective": {"type": "changeover", "attribute": "tool", "start": "M3"}})",
        R"({"objective": {"type": "route"}})"}) {
    digests.push_back(problem_digest(problem_with(json::parse(changes))));
  }
  std::ranges::sort(digests);
  EXPECT_EQ(std::ranges::adjacent_find(digests), digests.end());
  // What is wanted is the same, however it is said.
  EXPECT_EQ(problem_digest(problem_with({{"goal", {{"free", {"s1"}}}}})),
            problem_digest(problem_with({{"goal", {{"removed", {"screw 1"}}}}})));
}

TEST(WideKeys, TheFileOfShapesIsKeptAndIsNoPartOfTheDigest) {
  const Problem plain = problem_with(json::object());
  const Problem shown = problem_with({{"geometry", {{"file", "box.glb"}, {"note", "n"}}}});
  EXPECT_EQ(shown.spec().geometry->file, "box.glb");
  EXPECT_EQ(problem_digest(shown), problem_digest(plain));
  EXPECT_EQ(parse_problem(problem_text(shown)).spec().geometry->file, "box.glb");
  EXPECT_EQ(problem_text(plain).find("geometry"), std::string::npos);
  EXPECT_EQ(fault({{"geometry", "box.glb"}}),
            "geometry: expected an object, found the string \"box.glb\"");
  EXPECT_EQ(fault({{"geometry", json::object()}}), "geometry: the key \"file\" is missing");
  EXPECT_EQ(fault({{"geometry", {{"file", 3}}}}),
            "geometry.file: expected a string, found the number 3");
  EXPECT_EQ(fault({{"geometry", {{"file", ""}}}}),
            "geometry.file: an empty name is no file; leave \"geometry\" out where there is none");
  EXPECT_EQ(fault({{"geometry", {{"file", "a.glb"}, {"unit", "mm"}}}}),
            "geometry: unknown key \"unit\"; known keys are file");
}

TEST(WideKeys, WrongOnesAreNamedWithTheirPlace) {
  EXPECT_EQ(fault({{"base", {"table"}}}),
            "base[0]: no part \"table\"; parts are \"bench\" to \"s2\"");
  EXPECT_EQ(fault({{"base", {"box", "box"}}}), "base[1]: \"box\" is listed twice");
  EXPECT_EQ(fault({{"limits", {{"grounded", true}}}}),
            "limits.grounded: nothing can be grounded without a \"base\"");
  EXPECT_EQ(fault({{"limits", {{"grounded", 1}}}}),
            "limits.grounded: expected true or false, found the number 1");
  EXPECT_EQ(fault({{"goal", {{"free", {"s1"}}}}, {"direction", "assembly"}}),
            "goal: a goal says what is to come off, in disassembly; an assembly makes everything");
  EXPECT_EQ(fault({{"goal", {{"stop", "best"}}}}),
            "goal: \"free\" or \"removed\" is missing, one of them is needed");
  EXPECT_EQ(fault({{"goal", {{"removed", {"glue"}}}}}),
            "goal.removed[0]: no connection \"glue\"; connections are \"clamp\" to \"screw 2\"");
  EXPECT_EQ(fault({{"goal", {{"removed", json::array()}, {"stop", "never"}}}}),
            "goal.stop: \"never\" is not when a plan stops; that is \"reached\" or \"best\"");
  EXPECT_EQ(fault({{"action", "parts"}}),
            "action: \"parts\" is not what a step takes; that is \"connection\" or \"part\"");
  EXPECT_EQ(fault_of_connection({{"attributes", {{"tool", 3}}}}),
            "connections[2].attributes.tool: expected a string, found the number 3");
  EXPECT_EQ(
      fault_of_connection({{"attributes", {{"direction", "up"}}}}),
      "connections[2].attributes.direction: the direction is the way in which a piece leaves, "
      "by \"blocking\", and is not stated; give the attribute another name");
  EXPECT_EQ(fault_of_connection({{"numbers", {{"duration", 3}}}}),
            "connections[2].numbers: \"duration\" is a variable of every formula; give the number "
            "\"duration\" another name");
  EXPECT_EQ(
      fault_of_connection({{"numbers", {{"mass", 3}}}}),
      "connections[2].numbers: \"moved_mass\" is a variable of every formula; give the number "
      "\"mass\" another name");
  EXPECT_EQ(
      fault_of_connection({{"numbers", {{"sqrt", 3}}}}),
      "connections[2].numbers: \"sqrt\" is a function or a constant of every formula; give the "
      "number another name");
  EXPECT_EQ(fault_of_connection({{"numbers", {{"v", 3}, {"moved_v", 1}}}}),
            "connections[2].numbers: \"moved_v\" is what formulas call a sum of \"v\"; give one of "
            "the two another name");
  EXPECT_EQ(fault_of_connection({{"position", {0, 1}}}),
            "connections[2].position: expected an array of 3 numbers, found 2");
  const auto objective = [](const json& given) { return fault({{"objective", given}}); };
  EXPECT_EQ(objective({{"type", "changeover"}}), "objective: the key \"attribute\" is missing");
  EXPECT_EQ(
      objective({{"type", "changeover"}, {"attribute", "tol"}}),
      "objective.attribute: no connection has the attribute \"tol\"; attributes are tool; did "
      "you mean \"tool\"?");
  EXPECT_EQ(objective({{"type", "changeover"}, {"attribute", "direction"}}),
            "objective.attribute: the direction in which a piece leaves is known by \"blocking\" "
            "only, and the problem has none");
  EXPECT_EQ(objective(json::parse(R"({"type": "changeover", "attribute": "tool",
                                      "costs": [{"from": "M3", "to": "M3", "cost": 1}]})")),
            "objective.costs[0]: from \"M3\" to itself is no change and costs nothing");
  EXPECT_EQ(fault_of([] {
              json problem = box();
              problem["parts"][4].erase("position");
              problem["objective"] = {{"type", "route"}};
              return parse_problem(problem.dump());
            }),
            "objective: \"route\" needs the place of every connection, and \"screw 2\" has no "
            "position, nor has its part \"s2\"");
  EXPECT_EQ(fault({{"action", "part"}, {"objective", {{"type", "indexed"}}}}),
            "objective: \"indexed\" looks at the place of one connection in the file, and with "
            "\"action\": \"part\" a step takes several");
  EXPECT_EQ(fault(json::parse(R"({"objective": {"type": "expression", "formula": "1 - vlaue"}})")),
            "objective.formula: unknown name \"vlaue\" at character 5; known are before, after, "
            "separates, completes, moved_parts, kept_parts, moved_mass, kept_mass, subassemblies, "
            "duration, index, distance, elapsed, _e, _pi");
}

TEST(WideKeys, ThePlanSaysWhatStaysUnderAGoal) {
  const Problem problem = problem_with({{"goal", {{"free", {"lid"}}}}});
  const Result result = solve(problem, "auto");
  EXPECT_EQ(result.status, Status::Optimal);
  EXPECT_EQ(result.reward, -7);
  const json plan = json::parse(plan_text(problem, result, {}));
  EXPECT_EQ(plan.at("stays"), json::array({"clamp"}));
  EXPECT_EQ(plan.at("steps").size(), 3U);
}

TEST(WideKeys, ThePlanOfPartsIsAListOfLists) {
  json changes = {{"action", "part"}, {"base", {"bench"}}};
  const Problem problem = problem_with(changes);
  const Result result = solve(problem, "auto");
  EXPECT_EQ(result.status, Status::Optimal);
  const std::string text = plan_text(problem, result, {});
  const json plan = json::parse(text);
  for (const json& step : plan.at("disassembly")) EXPECT_TRUE(step.is_array());
  const std::vector<PlanStep> read = plan_steps(problem, parse_plan(text, problem.direction()));
  EXPECT_TRUE(check_plan(problem, Situation::whole(4), read).legal);
}

TEST(WideKeys, TheCheckFindsWhatIsWrongWithAPlan) {
  const Situation all = Situation::whole(4);
  const auto check = [&](const Problem& problem, std::vector<PlanStep> steps) {
    return check_plan(problem, all, std::span<const PlanStep>(steps)).fault;
  };
  const Problem goal = problem_with({{"goal", {{"free", {"s1"}}}}});
  EXPECT_EQ(check(goal, {{{2}, {}}}), "");
  EXPECT_EQ(check(goal, {{{3}, {}}}), "the plan ends and \"screw 1\" is missing");
  EXPECT_EQ(check(goal, {{{2}, {}}, {{3}, {}}}),
            "step 2 removes \"screw 2\", after the goal was reached, at which the plan ends");
  const Problem parts = problem_with({{"action", "part"}, {"base", {"bench"}}});
  EXPECT_EQ(check(parts, {{{2}, {}}, {{3}, {}}, {{1}, {}}, {{0}, {}}}), "");
  EXPECT_EQ(check(parts, {{{2, 3}, {}}, {{1}, {}}, {{0}, {}}}),
            "step 1 takes connections that are not all of those between some parts and the rest of "
            "a piece, against \"action\": \"part\"");
  const Problem grounded =
      problem_with(json::parse(R"({"base": ["bench"], "limits": {"grounded": true}})"));
  EXPECT_EQ(check(grounded, {{{1}, {}}, {{2}, {}}, {{3}, {}}, {{0}, {}}}),
            "step 1, which removes \"hinge\", leaves a subassembly without a base part, against "
            "limits.grounded");
}

TEST(WideKeys, AWrongRewardOfThePastIsFound) {
  // What a plan claims is compared with a replay that looks back by itself.
  const Problem problem =
      problem_with(json::parse(R"({"objective": {"type": "changeover", "attribute": "tool"}})"));
  const std::vector<PlanStep> steps = {{{2}, {}}, {{1}, {}}, {{3}, {}}, {{0}, {}}};
  const PlanCheck check = check_plan(problem, Situation::whole(4), steps);
  EXPECT_TRUE(check.legal);
  EXPECT_EQ(check.reward, -2);
  EXPECT_FALSE(same_reward(-1, check));
}

TEST(WideKeys, ReplanningKnowsWhatTheLastStepLeftBehind) {
  const Problem problem = problem_with(json::parse(
      R"({"objective": {"type": "sum", "terms": [{"type": "changeover", "attribute": "tool"},
                                                 {"type": "route", "per_metre": 0.01}]}})"));
  Replanner replanner(problem);
  const Result whole = replanner.plan();
  ASSERT_EQ(whole.status, Status::Optimal);
  double earned = 0;
  Situation now = Situation::whole(4);
  const TransitionSystem system(problem);
  const Evaluation evaluation = evaluate(system, whole);
  for (std::size_t i = 0; i < whole.steps.size(); ++i) {
    earned += evaluation.steps[i].reward;
    replanner.done(whole.steps[i].connections.front());
    note_done(problem, whole.steps[i], now);
    const Result left = replanner.plan();
    // The best plan goes on as it began.
    EXPECT_NEAR(earned + left.reward, whole.reward, 1e-9);
    EXPECT_NEAR(solve(Task(problem, now), "dijkstra").reward, left.reward, 1e-9);
  }
}

TEST(WideKeys, MethodsThatDoNotKnowThemSaySo) {
  const Problem problem = problem_with({{"goal", {{"free", {"s1"}}}}});
  for (const char* const method : {"and-or", "mip"}) {
    SCOPED_TRACE(method);
    EXPECT_TRUE(obstacle(problem, method).has_value());
    EXPECT_NE(fault_of([&] { return solve(problem, method); }), "no fault");
  }
}

}  // namespace
}  // namespace orasp
