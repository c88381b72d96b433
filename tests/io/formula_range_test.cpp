#include "orasp/model/formula_range.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// A formula of every operator and function, of so much nesting at most.
std::string random_formula(SplitMix64& random, int deep) {
  const auto one_of = [&](const std::vector<std::string>& names) {
    return names[random.below(names.size())];
  };
  if (deep == 0 || random.below(6) == 0)
    return one_of({"before", "elapsed", "duration", "moved_mass", "mine", "a", "1", "2.5", "0.5",
                   "_pi", "1e-1"});
  const auto inner = [&] { return random_formula(random, deep - 1); };
  switch (random.below(8)) {
    case 0:
      return one_of({"abs",  "cosh", "acosh", "asin",  "asinh", "atan", "atanh",
                     "exp",  "ln",   "log",   "log10", "log2",  "rint", "sign",
                     "sinh", "sqrt", "tanh",  "acos",  "cos",   "sin",  "tan"}) +
             "(" + inner() + ")";
    case 1: return one_of({"min", "max", "sum", "avg"}) + "(" + inner() + "," + inner() + ")";
    case 2: return "(" + inner() + " ? " + inner() + " : " + inner() + ")";
    case 3:
      return "(" + inner() + one_of({"<", "<=", ">", ">=", "==", "!=", "&&", "||"}) + inner() + ")";
    case 4: return "(-" + inner() + ")";
    case 5: return inner() + one_of({"+", "-", "*", "/"}) + inner();
    case 6: return "(" + inner() + ")^" + one_of({"2", "3", "0.5", "-1", "(1 + before)"});
    default: return "(" + inner() + one_of({"+", "-", "*"}) + inner() + ")";
  }
}

// Whatever the variables are in their ranges, the value lies on the line.
TEST(FormulaRange, HoldsEveryValue) {
  std::size_t bounded = 0;
  std::size_t sloped = 0;
  for (std::uint64_t seed = 0; seed < some_of(4000U); ++seed) {
    SplitMix64 random(seed);
    const std::string text = random_formula(random, 3);
    SCOPED_TRACE(text);
    const auto formula = compile_formula(text, {{"a", 0.75}}, {"mine"});
    auto* const ranged = dynamic_cast<RangedFormula*>(formula.get());
    ASSERT_NE(ranged, nullptr);
    FormulaRanges ranges;
    ranges.time = {0, 5};
    const auto interval = [&] {
      const double one = 8 * random.uniform() - 3;
      const double other = random.below(4) == 0 ? one : one + 6 * random.uniform();
      return Interval{one, other};
    };
    for (FormulaLine& line : ranges.variables) line = {interval(), {0, 0}};
    const std::vector<FormulaLine> own = {{interval(), {0, 0}}};
    ranges.own = own;
    // `elapsed` moves with time.
    constexpr std::size_t kElapsed = 12;
    ASSERT_EQ(kFormulaVariables[kElapsed].name, "elapsed");
    ranges.variables[kElapsed].slope = {2, 2};
    const FormulaLine line = ranged->over(ranges);
    if (std::isfinite(line.at.greatest)) ++bounded;
    if (line.slope.greatest != 0) ++sloped;
    for (int trial = 0; trial < 60; ++trial) {
      const auto within = [&](const Interval& x) {
        const std::uint64_t end = random.below(4);
        if (end == 0) return x.least;
        if (end == 1) return x.greatest;
        return x.least + random.uniform() * (x.greatest - x.least);
      };
      const double time = within(ranges.time);
      FormulaVariables variables;
      for (std::size_t i = 0; i < kFormulaVariables.size(); ++i) {
        variables.*kFormulaVariables[i].value =
            within(ranges.variables[i].at) + ranges.variables[i].slope.least * time;
      }
      const std::vector<double> mine = {within(own[0].at)};
      variables.own = mine;
      const double value = formula->value(variables);
      if (!std::isfinite(value)) continue;
      const double tolerance = 1e-9 * std::max(1.0, std::abs(value));
      const auto [least, most] = std::minmax({line.slope.least * time, line.slope.greatest * time});
      EXPECT_GE(value, line.at.least + least - tolerance);
      EXPECT_LE(value, line.at.greatest + most + tolerance);
    }
    if (HasFailure()) return;
  }
  EXPECT_GE(bounded, least_of(1500U));
  EXPECT_GE(sloped, least_of(200U));
}

// One number for each variable gives one number.
TEST(FormulaRange, OfOneNumberEachIsTheValue) {
  const auto formula = compile_formula("-a*duration*before + max(index, 2)^2 - -3", {{"a", 2}}, {});
  auto* const ranged = dynamic_cast<RangedFormula*>(formula.get());
  FormulaRanges ranges;
  FormulaVariables variables;
  for (std::size_t i = 0; i < kFormulaVariables.size(); ++i) {
    variables.*kFormulaVariables[i].value = static_cast<double>(i);
    ranges.variables[i].at = {static_cast<double>(i), static_cast<double>(i)};
  }
  const FormulaLine line = ranged->over(ranges);
  EXPECT_EQ(line.at.least, formula->value(variables));
  EXPECT_EQ(line.at.greatest, formula->value(variables));
}

TEST(FormulaRange, IsUnknownBeyondADivisionByZero) {
  const auto formula = compile_formula("1/before", {}, {});
  FormulaRanges ranges;
  ranges.variables[0].at = {0, 3};
  const FormulaLine line = dynamic_cast<RangedFormula*>(formula.get())->over(ranges);
  EXPECT_EQ(line.at.greatest, kInfinity);
  ranges.variables[0].at = {1, 4};
  EXPECT_EQ(dynamic_cast<RangedFormula*>(formula.get())->over(ranges).at.greatest, 1);
}

}  // namespace
}  // namespace orasp
