#pragma once

#include <map>
#include <string>

#include "orasp/model/formula.h"
#include "orasp/model/vector3.h"

namespace orasp {

class ObjectiveKind;

/// `expression`: a formula over the variables of FormulaVariables and named constants.
struct Expression {
  std::string formula{};
  std::map<std::string, double> constants{};
  Vector3 depot{};  ///< for the variable `distance`
  /// Set by io (parse_objective); a formula cannot be evaluated without one.
  FormulaCompiler compiler{};
};

[[nodiscard]] const ObjectiveKind& expression_kind();

}  // namespace orasp
