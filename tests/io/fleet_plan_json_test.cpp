#include "orasp/io/fleet_plan_json.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/fleet/fleet_search.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "tests/fault.h"

namespace orasp {
namespace {

Result solved(const Problem& problem) {
  return fleet_search(FleetProblem(problem), {}, {});
}

TEST(FleetPlanJson, ComesBackAsItWasWritten) {
  for (const char* name : {"fleet-lattice", "fleet-hubble"}) {
    for (const char* objective : {"makespan", "fleet_travel"}) {
      const Problem problem = load_scenario(name).with_objective(Objective::named(objective));
      const FleetProblem fleet(problem);
      const Result result = solved(problem);
      const std::string text = plan_text(problem, result, {});
      ASSERT_TRUE(is_fleet_plan(text));
      const FleetPlanFile file = parse_fleet_plan(text, fleet);
      EXPECT_EQ(file.plan, result.fleet_plan);
      EXPECT_EQ(file.problem_digest, problem_digest(problem));
      EXPECT_TRUE(evaluate(fleet, file.plan).valid);
    }
  }
}

TEST(FleetPlanJson, HoldsTheKeysOfAPlanAndThoseOfAFleet) {
  const Problem problem =
      load_scenario("fleet-lattice").with_objective(Objective::named("fleet_travel"));
  const Result result = solved(problem);
  const auto json = nlohmann::json::parse(plan_text(problem, result, {{"steps", "4"}}));
  EXPECT_EQ(json["format"], "orasp-plan/1");
  EXPECT_EQ(json["status"], "optimal");
  EXPECT_EQ(json["reward"], -81);
  EXPECT_EQ(json["bound"], -81);
  EXPECT_EQ(json["gap"], 0);
  EXPECT_EQ(json["fleet"]["objective"], "fleet_travel");
  EXPECT_EQ(json["fleet"]["steps_allowed"], 4);
  EXPECT_EQ(json["fleet"]["makespan"], 4);
  EXPECT_EQ(json["fleet"]["travel"], 81);
  EXPECT_EQ(json["options"]["steps"], 4);
  ASSERT_EQ(json["disassembly"].size(), 12U);
  EXPECT_EQ(json["disassembly"].front(), json["assembly"].back());
  double total = 0;
  std::size_t cut = 0;
  for (const auto& step : json["steps"]) {
    total += step["reward"].get<double>();
    EXPECT_EQ(step["total"], total);
    cut += step["connections"].size();
    std::size_t robots = 0;
    for (const auto& move : step["moves"]) {
      EXPECT_EQ(move["robots"].size(), move["parts"].size());
      robots += move["robots"].size();
    }
    EXPECT_EQ(step["robots_used"], robots);
  }
  EXPECT_EQ(total, -81);
  EXPECT_EQ(cut, 12U);
}

TEST(FleetPlanJson, WritesAnAnswerWithoutAPlan) {
  ProblemSpec spec = load_scenario("fleet-lattice").spec();
  spec.fleet->robots = 2;
  const Problem problem(spec);
  const auto json = nlohmann::json::parse(plan_text(problem, solved(problem), {}));
  EXPECT_EQ(json["status"], "infeasible");
  EXPECT_TRUE(json["reward"].is_null());
  EXPECT_TRUE(json["bound"].is_null());
  EXPECT_TRUE(json["gap"].is_null());
  EXPECT_TRUE(json["fleet"]["makespan"].is_null());
  EXPECT_TRUE(json["steps"].empty());
  EXPECT_EQ(json["notes"].size(), 1U);
}

TEST(FleetPlanJson, TellsAPlanOfAFleetFromOthers) {
  EXPECT_FALSE(is_fleet_plan(""));
  EXPECT_FALSE(is_fleet_plan("1-2\n2-3\n"));
  EXPECT_FALSE(is_fleet_plan(R"(["1-2", "fleet"])"));
  EXPECT_FALSE(is_fleet_plan(R"({"format": "orasp-plan/1", "disassembly": ["fleet"]})"));
  EXPECT_TRUE(is_fleet_plan(R"({"fleet": {}})"));
}

TEST(FleetPlanJson, NamesTheFaultAndItsPlace) {
  const Problem problem = load_scenario("fleet-lattice");
  const FleetProblem fleet(problem);
  const auto fault = [&](const std::string& steps) {
    return fault_of([&] {
      return parse_fleet_plan(
          R"({"format": "orasp-plan/1", "fleet": {"objective": "makespan"}, "steps": )" + steps +
              "}",
          fleet);
    });
  };
  const auto move = [](const std::string& parts, const std::string& to, const std::string& motion) {
    return R"([{"connections": [], "moves": [{"robots": [1], "parts": )" + parts +
           R"(, "from": "site 1", "to": ")" + to + R"(", "motion": ")" + motion +
           R"(", "distance": 1}]}])";
  };
  EXPECT_EQ(fault("[]"), "no fault");
  EXPECT_EQ(fault(move(R"(["1"])", "depot", "stay")), "no fault");
  EXPECT_EQ(fault(move(R"(["1", "77"])", "depot", "stay")),
            R"(steps[0].moves[0].parts[1]: no part "77"; parts are "1" to "9")");
  EXPECT_EQ(fault(move("[]", "depot", "stay")),
            "steps[0].moves[0].parts: a move has at least one part");
  EXPECT_EQ(
      fault(move("[1]", "depot", "stay")),
      "steps[0].moves[0].parts[0]: expected a part id, which is a string, found the number 1");
  EXPECT_EQ(
      fault(move(R"(["1"])", "site 5", "stay")),
      R"(steps[0].moves[0].to: no place "site 5"; places are "depot" and "site 1" to "site 4")");
  EXPECT_EQ(
      fault(move(R"(["1"])", "depot", "up")),
      R"(steps[0].moves[0].motion: "up" is not a motion; motions are stay, +x, -x, +y, -y, +z )"
      R"(and -z)");
  EXPECT_EQ(fault(R"([{"connections": ["9-1"], "moves": []}])"),
            R"(steps[0].connections[0]: no connection "9-1"; connections are "1-2" to "6-9")");
  EXPECT_EQ(fault(R"([{"connections": []}])"), R"(steps[0]: the key "moves" is missing)");
  EXPECT_EQ(fault("[3]"), "steps[0]: expected a step, which is an object, found the number 3");
  EXPECT_EQ(fault("{}"), "steps: expected an array, found an object");
  EXPECT_EQ(fault_of([&] {
              return parse_fleet_plan(
                  R"({"format": "orasp-plan/1", "fleet": {"objective": "speed"}, "steps": []})",
                  fleet);
            }),
            R"(fleet.objective: "speed" is none of makespan, fleet_travel)");
}

}  // namespace
}  // namespace orasp
