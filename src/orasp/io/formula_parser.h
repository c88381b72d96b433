#pragma once

#include "orasp/model/formula.h"

namespace orasp {

/// Compiles a formula of the `expression` objective with muParser. The variables are those of
/// FormulaVariables.
/// @throws InputError that names the bad token and its position.
[[nodiscard]] std::unique_ptr<Formula> compile_formula(
    const std::string& text, const std::map<std::string, double>& constants);

}  // namespace orasp
