#pragma once

#include "orasp/model/formula.h"

namespace orasp {

/// Compiles a formula of the `expression` objective with muParser. The variables are those of
/// FormulaVariables.
/// @throws InputError that names the bad token and its position.
[[nodiscard]] std::unique_ptr<Formula> compile_formula(
    const std::string& text, const std::map<std::string, double>& constants,
    const std::vector<std::string>& own = {});

/// Whether a name is that of a function or of a constant of every formula.
[[nodiscard]] bool is_formula_builtin(const std::string& name);

}  // namespace orasp
