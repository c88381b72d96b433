#include "orasp/model/operations.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/catalogue.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "tests/files.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using nlohmann::json;

/// "ab|C|d" for operations of steps: a letter a step, a capital where it moves something.
std::string grouped(const std::string& letters, Direction direction) {
  std::vector<Step> steps(letters.size());
  for (std::size_t i = 0; i < letters.size(); ++i) {
    steps[i].separates = letters[i] < 'a';
    if (steps[i].separates) steps[i].b = {0};
  }
  std::string text;
  std::size_t next = 0;
  for (const Operation& operation : operations(steps, direction)) {
    EXPECT_EQ(operation.first, next);
    next = operation.end;
    if (!text.empty()) text += '|';
    text += letters.substr(operation.first, operation.end - operation.first);
    if (operation.moving) text += letters[*operation.moving];
  }
  EXPECT_EQ(next, letters.size());
  return text;
}

TEST(Operations, EndWithThePieceThatIsTakenOff) {
  EXPECT_EQ(grouped("abCDefGhi", Direction::Disassembly), "abCC|DD|efGG|hi");
  EXPECT_EQ(grouped("ab", Direction::Disassembly), "ab");
  EXPECT_EQ(grouped("A", Direction::Disassembly), "AA");
  EXPECT_EQ(grouped("", Direction::Disassembly), "");
}

TEST(Operations, BeginWithThePieceThatIsPutOn) {
  EXPECT_EQ(grouped("ihGfeDCba", Direction::Assembly), "ih|GfeG|DD|CbaC");
  EXPECT_EQ(grouped("ab", Direction::Assembly), "ab");
  EXPECT_EQ(grouped("", Direction::Assembly), "");
}

/// What docs/format.md says of `operations`. Returns how many there are.
std::size_t expect_operations(const Problem& problem, const Result& result) {
  const json plan = json::parse(plan_text(problem, result, {}));
  const json& steps = plan.at("steps");
  std::size_t next = 1;
  for (const json& operation : plan.at("operations")) {
    const json& numbers = operation.at("steps");
    EXPECT_FALSE(numbers.empty());
    const json* moving = nullptr;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      EXPECT_EQ(numbers[k], next++);
      const json& step = steps.at(numbers[k].get<std::size_t>() - 1);
      if (step.at("moved").empty()) continue;
      EXPECT_EQ(moving, nullptr);
      moving = &step;
      EXPECT_EQ(k, problem.direction() == Direction::Assembly ? 0 : numbers.size() - 1);
    }
    EXPECT_EQ(operation.at("moved"), moving == nullptr ? json::array() : moving->at("moved"));
    EXPECT_EQ(operation.contains("direction"), moving != nullptr && moving->contains("direction"));
    if (operation.contains("direction")) {
      EXPECT_EQ(operation.at("direction"), moving->at("direction"));
    }
    // Only what stands at the outer end of the plan belongs to no piece.
    if (moving == nullptr) {
      EXPECT_EQ(&operation, problem.direction() == Direction::Assembly
                                ? &plan.at("operations").front()
                                : &plan.at("operations").back());
    }
  }
  EXPECT_EQ(next, steps.size() + 1);
  return plan.at("operations").size();
}

TEST(PlanOperations, HoldEachStepOnceInRandomProblems) {
  std::size_t several = 0;
  for (std::uint64_t seed = 0; seed < some_of(1500U); ++seed) {
    const Problem problem(random_problem(seed));
    const Result result = solve(Task(problem), seed % 2 == 0 ? "greedy" : "random");
    SCOPED_TRACE(seed);
    if (expect_operations(problem, result) < result.sequence.size()) ++several;
  }
  EXPECT_GE(several, more_than(200));
}

TEST(PlanOperations, HoldEachStepOnceInTheBuiltInProblems) {
  for (const char* name : {"hubble", "iss", "jwst", "lattice", "table-hemnes"}) {
    SCOPED_TRACE(name);
    const Problem problem = load_scenario(name);
    expect_operations(problem, solve(Task(problem), "greedy"));
    const Problem built = problem.with_direction(Direction::Assembly);
    expect_operations(built, solve(Task(built), "greedy"));
  }
}

TEST(PlanOperations, HoldEachStepOnceInModelsOfLego) {
  const std::filesystem::path folder = shared_folder() / "problems/lego";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "there is no " << folder;
  std::size_t models = 0;
  for (const auto& file : json_files(folder)) {
    if (models++ == 20) break;
    SCOPED_TRACE(file.filename());
    const Problem problem = read_problem(file);
    expect_operations(problem, solve(Task(problem), "greedy"));
  }
}

}  // namespace
}  // namespace orasp
