#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "orasp/model/formula_range.h"

namespace orasp::detail {

/// A formula as a tree, to find what it yields over ranges of its variables: interval arithmetic
/// (R. E. Moore, Interval Analysis, 1966), carried along lines in time as long as only sums and
/// products with what stands still are formed.
///
/// Guarantee. The value of the formula lies on the line that `over` tells, for all values of the
///            variables in the ranges, but for rounding of the last digits. The tree is read by the
///            precedence of muParser's operators; whoever makes one compares values with
///            muParser's.
/// Limit.     A name that stands several times counts as several numbers, which may make ranges
///            wider than they are. Nesting beyond kMostDeep is not read.
class FormulaTree {
 public:
  static constexpr int kMostDeep = 100;

  /// Nothing where the text is not understood. `constants` are all that a formula may name.
  [[nodiscard]] static std::optional<FormulaTree> read(
      const std::string& text, const std::map<std::string, double>& constants,
      const std::vector<std::string>& own);

  [[nodiscard]] FormulaLine over(const FormulaRanges& ranges) const;

  enum class Kind : std::uint8_t {
    Number,
    Variable,
    Own,
    Minus,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
    And,
    Or,
    Choose,
    Call
  };
  struct Node {
    Kind kind = Kind::Number;
    std::size_t which = 0;  ///< of Variable and Own: its place; of Call: the function
    double number = 0;
    std::vector<std::size_t> children{};  ///< nodes that stand before
  };

 private:
  std::vector<Node> nodes_;  ///< children before their parents, the last the whole
};

}  // namespace orasp::detail
