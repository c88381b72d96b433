#pragma once

#include <array>
#include <span>

#include "orasp/model/formula.h"

namespace orasp {

/// All numbers from `least` to `greatest`.
struct Interval {
  double least = 0;
  double greatest = 0;
};

/// A number that may move with time t along a line: whatever else holds, it is a + s t for some a
/// of `at` and some s of `slope`, the same for every t. A number that time does not touch has the
/// slope 0.
struct FormulaLine {
  Interval at;
  Interval slope;
};

/// What the variables of a formula may be: those of kFormulaVariables in their order, the user's
/// own, and time itself.
struct FormulaRanges {
  std::array<FormulaLine, kFormulaVariables.size()> variables;
  std::span<const FormulaLine> own;
  Interval time;
};

/// A formula that says what it can yield.
class RangedFormula : public Formula {
 public:
  /// A line that the value lies on for all values of the variables in these ranges; with infinite
  /// ends where that is not known. Where time enters along no line, the slope is 0 and `at` holds
  /// the values of all times.
  [[nodiscard]] virtual FormulaLine over(const FormulaRanges& ranges) = 0;
};

}  // namespace orasp
