// Fuzz target: the bytes are a formula of the objective `expression`.
//
// Whatever they are, compile_formula accepts them or refuses them in one sentence. The value of a
// formula that it accepts is the same each time, and does not change with a variable that it says
// not to use. As the objective of a problem it is written and read back as the same text.
#include <bit>
#include <map>

#include "fuzz/property.h"
#include "orasp/io/formula_parser.h"
#include "orasp/io/problem_json.h"

namespace orasp::fuzz {
namespace {

const std::map<std::string, double>& constants() {
  static const std::map<std::string, double> kConstants = {{"cost", 2.5}, {"zero", 0}};
  return kConstants;
}

FormulaVariables some_step() {
  return {.before = 5,
          .after = 4,
          .separates = 1,
          .completes = 0,
          .moved_parts = 2,
          .kept_parts = 3,
          .moved_mass = 1.5,
          .kept_mass = 7,
          .subassemblies = 2,
          .duration = 12,
          .index = 3,
          .distance = 0.25};
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

/// A value, or NaN where the formula refuses these numbers in one sentence.
double value_of(Formula& formula, const FormulaVariables& variables) {
  return accepted([&] { return formula.value(variables); }).value_or(std::nan(""));
}

}  // namespace
}  // namespace orasp::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace orasp;
  using namespace orasp::fuzz;
  const std::string text(text_of(data, size));
  const auto formula = accepted([&] { return compile_formula(text, constants()); });
  if (!formula) return 0;
  const FormulaVariables step = some_step();
  const double value = value_of(**formula, step);
  require(same_bits(value, value_of(**formula, step)), "a formula is a function");
  for (const FormulaVariable& variable : kFormulaVariables) {
    if ((*formula)->uses(variable.name)) continue;
    FormulaVariables other = step;
    other.*variable.value += 1;
    require(same_bits(value, value_of(**formula, other)),
            "a formula's value depends on the variables that it uses");
  }
  const Objective objective("expression",
                            Expression{text, constants(), {}, FormulaCompiler(compile_formula)});
  const auto written = accepted([&] { return objective_text(objective); });
  if (!written) return 0;
  const auto again = accepted([&] { return parse_objective(*written, "objective"); });
  if (!again) return 0;
  require(objective_text(*again) == *written, "writing a formula keeps it");
  return 0;
}
