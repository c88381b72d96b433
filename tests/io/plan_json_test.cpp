#include "orasp/io/plan_json.h"

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/validate.h"
#include "tests/fault.h"
#include "tests/files.h"

namespace orasp {
namespace {

using nlohmann::json;

/// 1 - 2 - 3 - 4, its middle connection first: -(0.1248 + 0.1248), then -(0.0967 + 0.0967), then
/// the completion 1.
Result plan_of_4brick() {
  Result result;
  result.method = "value-iteration";
  result.status = Status::Optimal;
  result.sequence = {1, 0, 2};
  result.reward = 0.557;
  result.bound = 0.557;
  result.statistics.states = 8;
  result.statistics.actions = 12;
  return result;
}

std::string fault(const std::string& text) {
  return fault_of([&] { return parse_plan(text, Direction::Disassembly); });
}

TEST(PlanText, HasTheKeysOfTheContractInTheirOrder) {
  const Problem problem = load_scenario("4brick");
  EXPECT_EQ(plan_text(problem, plan_of_4brick(), {{"epsilon", "1e-9"}, {"order", "\"layers\""}}),
            R"({
  "format": "orasp-plan/1",
  "problem": "4Brick",
  "problem_digest": ")" +
                problem_digest(problem) +
                R"(",
  "method": "value-iteration",
  "status": "optimal",
  "reward": 0.557,
  "bound": 0.557,
  "gap": 0.0,
  "disassembly": ["2-3", "1-2", "3-4"],
  "assembly": ["3-4", "1-2", "2-3"],
  "steps": [
    {"step": 1, "connection": "2-3", "reward": -0.2496, "total": -0.2496, "separates": true, )"
                R"("pieces": [["1", "2"], ["3", "4"]], "moved": ["3", "4"]},
    {"step": 2, "connection": "1-2", "reward": -0.1934, "total": -0.44299999999999995, )"
                R"("separates": true, "pieces": [["1"], ["2"]], "moved": ["2"]},
    {"step": 3, "connection": "3-4", "reward": 1.0, "total": 0.557, "separates": true, )"
                R"("pieces": [["3"], ["4"]], "moved": ["4"]}
  ],
  "operations": [
    {"steps": [1], "moved": ["3", "4"]},
    {"steps": [2], "moved": ["2"]},
    {"steps": [3], "moved": ["4"]}
  ],
  "order": [],
  "statistics": {"states": 8, "actions": 12, "expanded": 0, "generated": 0, "reopened": 0, )"
                R"("pruned": 0, "sweeps": 0, "seconds": 0.0, "peak_bytes": 0},
  "seed": 1,
  "options": {"epsilon": 1e-9, "order": "layers"}
}
)");
}

TEST(PlanText, ListsNoPiecesWhereNothingSeparates) {
  Result result = plan_of_4brick();
  result.sequence = {0, 1, 2};
  const json plan = json::parse(plan_text(load_scenario("3piece"), result, {}));
  EXPECT_EQ(plan["steps"][0]["separates"], false);
  EXPECT_EQ(plan["steps"][0]["pieces"], json::array());
  EXPECT_EQ(plan["steps"][0]["moved"], json::array());
  EXPECT_EQ(plan["options"], json::object());
}

TEST(PlanText, IsInTheOrderOfTheProblemsDirection) {
  const Problem problem = load_scenario("4brick").with_direction(Direction::Assembly);
  const json plan = json::parse(plan_text(problem, plan_of_4brick(), {}));
  EXPECT_EQ(plan["assembly"], json({"2-3", "1-2", "3-4"}));
  EXPECT_EQ(plan["disassembly"], json({"3-4", "1-2", "2-3"}));
  EXPECT_EQ(plan["steps"][0]["connection"], "2-3");
}

TEST(PlanText, WritesTheGapOfAPlanWithoutProof) {
  Result result = plan_of_4brick();
  result.status = Status::Feasible;
  result.stop = Stop::TimeLimit;
  result.bound = 1;
  result.notes = {"one", "two"};
  const json plan = json::parse(plan_text(load_scenario("4brick"), result, {}));
  EXPECT_EQ(plan["status"], "feasible");
  EXPECT_EQ(plan["stopped"], "time limit");
  EXPECT_EQ(plan["bound"], 1.0);
  EXPECT_NEAR(plan["gap"].get<double>(), 0.443, 1e-12);
  EXPECT_EQ(plan["notes"], json({"one", "two"}));
}

TEST(PlanText, WritesNullWhereNothingIsKnown) {
  Result result = plan_of_4brick();
  result.status = Status::Feasible;
  result.bound.reset();
  json plan = json::parse(plan_text(load_scenario("4brick"), result, {}));
  EXPECT_TRUE(plan["bound"].is_null());
  EXPECT_TRUE(plan["gap"].is_null());

  result = Result{};
  result.status = Status::Infeasible;
  plan = json::parse(plan_text(load_scenario("4brick"), result, {}));
  EXPECT_EQ(plan["status"], "infeasible");
  EXPECT_TRUE(plan["reward"].is_null());
  EXPECT_TRUE(plan["gap"].is_null());
  EXPECT_EQ(plan["disassembly"], json::array());
  EXPECT_EQ(plan["assembly"], json::array());
  EXPECT_EQ(plan["steps"], json::array());
  EXPECT_FALSE(plan.contains("stopped"));
  EXPECT_FALSE(plan.contains("notes"));

  result.status = Status::Unknown;
  result.bound = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(json::parse(plan_text(load_scenario("4brick"), result, {}))["bound"].is_null());
}

TEST(PlanText, NeverPutsABoundBelowTheReward) {  // by the last bits of another order of adding
  Result result = plan_of_4brick();
  result.status = Status::Feasible;
  result.bound = 0.5569999999999998;
  const json plan = json::parse(plan_text(load_scenario("4brick"), result, {}));
  EXPECT_EQ(plan["gap"], 0.0);
  EXPECT_EQ(plan["bound"], plan["reward"]);
}

TEST(PlanText, IsEmptyForAProblemWithoutConnections) {
  Result result;
  result.status = Status::Optimal;
  result.reward = 0;
  const json plan = json::parse(plan_text(load_scenario("chain:1"), result, {}));
  EXPECT_EQ(plan["reward"], 0.0);
  EXPECT_EQ(plan["gap"], 0.0);
  EXPECT_EQ(plan["steps"], json::array());
}

TEST(ParsePlan, ReadsWhatPlanTextWrote) {
  const Problem problem = load_scenario("4brick");
  const std::string text = plan_text(problem, plan_of_4brick(), {});
  const PlanFile plan = parse_plan(text, Direction::Disassembly);
  EXPECT_EQ(plan.sequence, (std::vector<std::string>{"2-3", "1-2", "3-4"}));
  EXPECT_EQ(plan.problem_digest, problem_digest(problem));
  EXPECT_EQ(parse_plan(text, Direction::Assembly).sequence,
            (std::vector<std::string>{"3-4", "1-2", "2-3"}));
}

TEST(ParsePlan, TurnsTheOtherListRound) {
  const std::string text = R"({"format": "orasp-plan/1", "assembly": ["a", "b"], "anything": 1})";
  EXPECT_EQ(parse_plan(text, Direction::Disassembly).sequence,
            (std::vector<std::string>{"b", "a"}));
  EXPECT_EQ(parse_plan(text, Direction::Assembly).sequence, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(parse_plan(text, Direction::Assembly).problem_digest, "");
}

TEST(ParsePlan, ReadsBareLists) {
  const std::vector<std::string> ids = {"2-3", "a b"};
  EXPECT_EQ(parse_plan(R"(["2-3", "a b"])", Direction::Disassembly).sequence, ids);
  EXPECT_EQ(parse_plan("\n# a comment\n2-3\r\n\n  a b  ", Direction::Assembly).sequence, ids);
  EXPECT_TRUE(parse_plan("[]", Direction::Disassembly).sequence.empty());
}

TEST(ParsePlan, SaysWhatIsWrong) {
  EXPECT_EQ(fault(""), "the file is empty");
  EXPECT_EQ(fault(R"({"disassembly": []})"), "the key \"format\" is missing");
  EXPECT_EQ(fault(R"({"format": "orasp-problem/1"})"),
            "format: \"orasp-problem/1\" is not the format of a plan; that is \"orasp-plan/1\"");
  EXPECT_EQ(fault(R"({"format": "orasp-plan/1"})"),
            "the key \"disassembly\" or \"assembly\" is missing, one of them is needed");
  EXPECT_EQ(fault(R"({"format": "orasp-plan/1", "disassembly": "1-2"})"),
            "disassembly: expected an array of connection ids, found the string \"1-2\"");
  EXPECT_EQ(fault(R"({"format": "orasp-plan/1", "disassembly": ["1-2", 3]})"),
            "disassembly[1]: expected a connection id, which is a string, found the number 3");
  EXPECT_EQ(
      fault(R"({"format": "orasp-plan/1", "disassembly": ["a", "b"], "assembly": ["a", "b"]})"),
      "assembly: it is not the reverse of \"disassembly\"");
  EXPECT_EQ(fault(R"([1])"),
            "[0]: expected a connection id, which is a string, found the number 1");
  EXPECT_EQ(fault("1-2\n\xff"), "line 2: the byte 0xff is not valid UTF-8");
  EXPECT_EQ(fault("[\"1-2\""), "line 1, column 7: the text ends too early");
}

// The page shows the shelf and its plan.
TEST(FormatPage, ShowsAPlanThatIsTrue) {
  const auto problems = json_examples("format.md", "\"Shelf\"");
  ASSERT_EQ(problems.size(), 2U);  // the problem, then the plan
  const Problem shelf = parse_problem(problems[0]);
  const PlanFile plan = parse_plan(problems[1], shelf.direction());
  EXPECT_EQ(plan.problem_digest, problem_digest(shelf));
  const Evaluation evaluation = evaluate(shelf, plan.sequence);
  EXPECT_TRUE(evaluation.valid);
  EXPECT_NEAR(evaluation.reward, json::parse(problems[1])["reward"].get<double>(), 1e-9);
}

}  // namespace
}  // namespace orasp
