#include "orasp/io/state_policy_json.h"

#include <string>

#include <gtest/gtest.h>

#include "orasp/io/problem_json.h"
#include "orasp/planners/uncertain_value_iteration.h"

namespace orasp {
namespace {

std::string problem_with(const std::string& on_failure, const std::string& direction = "") {
  return R"({"format": "orasp-problem/1", "parts": [{"id": "a"}, {"id": "b"}, {"id": "c"}],
    "connections": [{"parts": ["a", "b"], "success": 0.5)" +
         (on_failure.empty() ? "" : R"(, "on_failure": )" + on_failure) +
         R"(}, {"parts": ["b", "c"]}])" + direction + "}";
}

std::string fault(const std::string& json) {
  try {
    static_cast<void>(parse_problem(json));
    return "no fault";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(OnFailure, IsReadAndWritten) {
  for (const std::string text : {R"({"breaks": ["b-c", "a-b"]})", R"({"abort": -50.5})"}) {
    const Problem problem = parse_problem(problem_with(text));
    const std::string written = problem_text(problem);
    EXPECT_NE(written.find("\"on_failure\": " + text), std::string::npos) << written;
    const Problem again = parse_problem(written);
    EXPECT_EQ(problem_text(again), written);
    EXPECT_EQ(problem_digest(again), problem_digest(problem));
  }
  const Problem retry = parse_problem(problem_with("\"retry\""));
  EXPECT_EQ(problem_text(retry).find("on_failure"), std::string::npos);
  EXPECT_EQ(*retry.first_uncertain(), 0U);
}

TEST(OnFailure, ShowsInTheDigest) {
  const auto digest = [](const std::string& on_failure) {
    return problem_digest(parse_problem(problem_with(on_failure)));
  };
  EXPECT_EQ(digest(""), digest("\"retry\""));
  EXPECT_NE(digest(""), digest(R"({"breaks": ["b-c"]})"));
  EXPECT_NE(digest(""), digest(R"({"abort": 0})"));
  EXPECT_NE(digest(R"({"abort": 1})"), digest(R"({"abort": 0})"));
  EXPECT_EQ(digest(R"({"breaks": ["b-c", "a-b"]})"), digest(R"({"breaks": ["a-b", "b-c"]})"));
}

TEST(OnFailure, FaultsNameTheirPlace) {
  const auto of = [](const std::string& on_failure) { return fault(problem_with(on_failure)); };
  EXPECT_EQ(of(R"({"breaks": ["x"]})"),
            "connections[0].on_failure.breaks[0]: no connection \"x\"; connections are \"a-b\" and "
            "\"b-c\"");
  EXPECT_EQ(of(R"({"breaks": ["b-c", "b-c"]})"),
            "connections[0].on_failure.breaks[1]: \"b-c\" is listed twice");
  EXPECT_EQ(of(R"({"breaks": []})"),
            "connections[0].on_failure.breaks: an empty list breaks nothing; write \"retry\"");
  EXPECT_EQ(of(R"({"breaks": [""]})"),
            "connections[0].on_failure.breaks[0]: an id must not be empty");
  EXPECT_EQ(of(R"({"breaks": [1]})").find("connections[0].on_failure.breaks[0]: expected an id"),
            0U);
  EXPECT_EQ(of("{}"),
            "connections[0].on_failure: \"breaks\" or \"abort\" is missing, one of them is needed");
  EXPECT_EQ(of(R"({"brakes": ["b-c"]})").find("connections[0].on_failure: unknown key \"brakes\""),
            0U);
  EXPECT_EQ(of(R"({"abort": "x"})").find("connections[0].on_failure.abort: expected a number"), 0U);
  EXPECT_NE(of(R"({"abort": 1e999})"), "no fault");
  EXPECT_NE(of(R"({"abort": NaN})"), "no fault");
  EXPECT_EQ(of(R"("explode")").find("connections[0].on_failure: \"explode\" is not what a failure"),
            0U);
  EXPECT_EQ(of("3").find("connections[0].on_failure: expected \"retry\""), 0U);
  EXPECT_EQ(of(R"({"abort": 1, "breaks": ["b-c"]})").find("connections[0].on_failure: \"breaks\""),
            0U);
  EXPECT_EQ(
      fault(problem_with(R"({"breaks": ["b-c"]})", R"(, "direction": "assembly")")),
      "connections[0].on_failure.breaks: connections come off in disassembly only; in assembly "
      "a failure can \"retry\" or \"abort\"");
  EXPECT_EQ(fault(problem_with(R"({"abort": -1})", R"(, "direction": "assembly")")), "no fault");
}

TEST(StatePolicy, ReadsBackWhatWasWritten) {
  for (const std::string direction : {"", R"(, "direction": "assembly")"}) {
    const Problem problem = parse_problem(problem_with("", direction));
    const TransitionSystem system(problem);
    const Result result = uncertain_value_iteration(system, {}, {});
    const std::string text = state_policy_text(system, result);
    EXPECT_NE(text.find(direction.empty() ? "\"removed\"" : "\"made\""), std::string::npos);
    const std::vector<PolicyState> read = parse_state_policy(system, text);
    ASSERT_EQ(read.size(), result.expectation->policy.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      EXPECT_EQ(read[i].open, result.expectation->policy[i].open);
      EXPECT_EQ(read[i].next, result.expectation->policy[i].next);
      EXPECT_EQ(read[i].reward, result.expectation->policy[i].reward);
    }
  }
}

TEST(StatePolicy, RefusesWhatIsNoPolicyOfTheProblem) {
  const Problem problem = parse_problem(problem_with(""));
  const TransitionSystem system(problem);
  const std::string text = state_policy_text(system, uncertain_value_iteration(system, {}, {}));
  const auto fault_of = [&](const std::string& from, const std::string& to) -> std::string {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    try {
      static_cast<void>(parse_state_policy(system, changed));
      return "no fault";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(fault_of("orasp-state-policy/1", "orasp-plan/1"),
            "format: \"orasp-plan/1\" is not the format of a policy of states; that is "
            "\"orasp-state-policy/1\"");
  EXPECT_EQ(fault_of(problem_digest(problem), "00").find("problem_digest: the policy was made for"),
            0U);
  EXPECT_EQ(fault_of("\"removed\": []", "\"removed\": [\"x\"]")
                .find("states[0].removed[0]: no connection \"x\""),
            0U);
  EXPECT_EQ(fault_of("\"removed\": []", "\"removed\": [\"a-b\", \"a-b\"]")
                .find("states[0].removed[1]: \"a-b\" is listed twice"),
            0U);
  EXPECT_EQ(fault_of("\"next\"", "\"then\""), "states[0]: the key \"next\" is missing");
  EXPECT_EQ(fault_of("\"states\"", "\"entries\""), "the key \"states\" is missing");
  EXPECT_EQ(fault_of("\"removed\": []", "\"removed\": 3")
                .find("states[0].removed: expected an array of connection ids"),
            0U);
}

}  // namespace
}  // namespace orasp
