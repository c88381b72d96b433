#include "orasp/io/formula_parser.h"

#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/problem_json.h"
#include "tests/fault.h"

namespace orasp {
namespace {

/// Each variable has a value of its own: before = 1, after = 2, ... distance = 12.
FormulaVariables numbered() {
  FormulaVariables variables;
  double value = 0;
  for (const FormulaVariable& variable : kFormulaVariables) variables.*variable.value = ++value;
  return variables;
}

double value(const std::string& text, const std::map<std::string, double>& constants = {}) {
  return compile_formula(text, constants)->value(numbered());
}

std::string fault(const std::string& text, const std::map<std::string, double>& constants = {}) {
  return fault_of([&] { return compile_formula(text, constants); });
}

TEST(Formula, KnowsEveryVariable) {
  double expected = 0;
  for (const FormulaVariable& variable : kFormulaVariables) {
    EXPECT_EQ(value(std::string(variable.name)), ++expected) << variable.name;
  }
}

TEST(Formula, CalculatesWithConstantsAndFunctions) {
  EXPECT_EQ(value("-(duration + rate * distance)", {{"rate", 0.5}}), -16);
  EXPECT_EQ(value("before < after ? max(3, 7) : 0"), 7);
  EXPECT_EQ(value("2^3^2"), 512);  // from the right, as in mathematics
  EXPECT_EQ(value("before == 1 && after != 1"), 1);
}

TEST(Formula, GivesTheSameForTheSameStepAndFollowsAnother) {
  const auto formula = compile_formula("duration * 2", {});
  FormulaVariables variables;
  variables.duration = 3;
  EXPECT_EQ(formula->value(variables), 6);
  EXPECT_EQ(formula->value(variables), 6);
  variables.duration = 4;
  EXPECT_EQ(formula->value(variables), 8);
}

TEST(Formula, MayYieldWhatIsNotANumber) {  // the transition system refuses it where it happens
  EXPECT_TRUE(std::isinf(value("1/0")));
  EXPECT_TRUE(std::isnan(value("sqrt(-1)")));
}

TEST(Formula, NamesTheBadTokenAndItsPlace) {
  const std::string names =
      "before, after, separates, completes, moved_parts, kept_parts, moved_mass, kept_mass, "
      "subassemblies, duration, "
      "index, distance, elapsed, _e, _pi";
  EXPECT_EQ(fault("1 + durations"), "unknown name \"durations\" at character 5; known are " +
                                        names + "; did you mean \"duration\"?");
  EXPECT_EQ(fault("1 + zzzzzz", {{"rate", 1}}),
            "unknown name \"zzzzzz\" at character 5; known are " + names + ", rate");
  EXPECT_NE(fault("3 * mx(1, 2)").find("unknown function \"mx\" at character 5; known are abs, "),
            std::string::npos);
  EXPECT_EQ(fault("1 + sin"),
            "the function \"sin\" at character 5 needs its arguments in parentheses");
  EXPECT_EQ(fault("before @ 3"), "\"@\" at character 8 means nothing in a formula");
  EXPECT_EQ(fault("1e999"), "\"1e999\" at character 1 is not a number");
  EXPECT_EQ(fault("1 2"), "unexpected value \"2\" at character 3");
}

TEST(Formula, NamesWhatIsMissing) {
  EXPECT_EQ(fault("1 +"), "the formula ends too early");
  EXPECT_EQ(fault("(1 + 2"), "a closing parenthesis is missing");
  EXPECT_EQ(fault("1)"), "unexpected parenthesis \")\" at character 2");
  EXPECT_EQ(fault("before ? 1"), "a \"?\" has no \":\"");
  EXPECT_EQ(fault("1 : 2"), "a \":\" has no \"?\"");
  EXPECT_EQ(fault("sin()"), "too few parameters for function \"sin\" at character 5");
  EXPECT_EQ(fault("1, 2"),
            "the formula has several results; a comma separates the arguments of a function");
}

TEST(Formula,
     // MuParser would assign: then the reward of a step depends on the steps before.
     StoresNothing) {
  EXPECT_EQ(fault("duration = 3"), "\"=\" at character 10 assigns; write == to compare");
  EXPECT_EQ(fault("=1"), "\"=\" at character 1 assigns; write == to compare");
  EXPECT_EQ(value("(1 <= 2) + (2 >= 1) + (1 == 1) + (1 != 2)"), 4);
}

TEST(Formula, RefusesConstantsWithTheNameOfAFunction) {
  EXPECT_EQ(fault("1", {{"sin", 1}}),
            "the constant \"sin\" has the name of a function or constant of every formula");
  EXPECT_EQ(fault("1", {{"_pi", 3}}),
            "the constant \"_pi\" has the name of a function or constant of every formula");
}

TEST(Formula, RefusesConstantsWithNamesThatMuParserCannotHold) {
  EXPECT_NE(fault("1", {{std::string(200, 'a'), 1}}), "no fault");
}

TEST(Formula, TakesLongAndDeepFormulasUpToItsLimit) {
  EXPECT_EQ(value(std::string(4990, '(') + "1" + std::string(4990, ')')), 1);
  EXPECT_EQ(fault(std::string(10'001, '1')), "the formula has 10001 bytes; at most 10000 are read");
}

TEST(Formula, CompilesInSeveralThreadsAtOnce) {
  std::vector<std::thread> threads;
  std::vector<double> results(4);
  for (std::size_t t = 0; t < results.size(); ++t) {
    threads.emplace_back([t, &results] {
      for (int i = 0; i < 50; ++i)
        results[t] += value("duration * k", {{"k", static_cast<double>(t)}});
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t t = 0; t < results.size(); ++t)
    EXPECT_EQ(results[t], 50 * 10 * static_cast<double>(t));
}

TEST(Formula, IsCheckedWhenAnObjectiveIsRead) {
  EXPECT_EQ(fault_of([] {
              return parse_objective(R"({"type": "expression", "formula": "1 +"})", "objective");
            }),
            "objective.formula: the formula ends too early");
}

}  // namespace
}  // namespace orasp
