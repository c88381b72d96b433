#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace orasp {

/// What an `expression` objective may use of one step; the names are those of the formula language.
/// Counts are whole numbers, flags are 0 or 1; units as in Problem (kg, m, s).
struct FormulaVariables {
  double before = 0;         ///< connections present before the step
  double after = 0;          ///< connections present after the step
  double separates = 0;      ///< 1 if the step separates (assembly: joins) two pieces
  double completes = 0;      ///< 1 if it is the last step of all
  double moved_parts = 0;    ///< parts in the moved piece, 0 unless it separates
  double kept_parts = 0;     ///< parts in the other piece, 0 unless it separates
  double moved_mass = 0;     ///< kg, 0 unless it separates
  double kept_mass = 0;      ///< kg, 0 unless it separates
  double subassemblies = 0;  ///< pieces with two or more parts after the step
  double duration = 0;       ///< s, of the connection
  double index = 0;          ///< the connection's position in the file, from 0
  double distance = 0;       ///< m, centroid of the moved piece to the depot; 0 without positions
};

/// A variable's name in a formula and where its value stands.
struct FormulaVariable {
  std::string_view name;
  double FormulaVariables::*value;
};

/// All variables, in the order of the documentation.
inline constexpr std::array<FormulaVariable, 12> kFormulaVariables = {{
    {"before", &FormulaVariables::before},
    {"after", &FormulaVariables::after},
    {"separates", &FormulaVariables::separates},
    {"completes", &FormulaVariables::completes},
    {"moved_parts", &FormulaVariables::moved_parts},
    {"kept_parts", &FormulaVariables::kept_parts},
    {"moved_mass", &FormulaVariables::moved_mass},
    {"kept_mass", &FormulaVariables::kept_mass},
    {"subassemblies", &FormulaVariables::subassemblies},
    {"duration", &FormulaVariables::duration},
    {"index", &FormulaVariables::index},
    {"distance", &FormulaVariables::distance},
}};

/// A compiled formula. Not shareable between threads: each thread compiles its own through
/// FormulaCompiler.
class Formula {
 public:
  Formula() = default;
  Formula(const Formula&) = delete;
  Formula& operator=(const Formula&) = delete;
  virtual ~Formula() = default;
  [[nodiscard]] virtual double value(const FormulaVariables& variables) = 0;
  /// Whether the value may depend on the variable called `name`; true where that is not known.
  [[nodiscard]] virtual bool uses(std::string_view name) const {
    static_cast<void>(name);
    return true;
  }
};

/// Compiles a formula text with named constants; throws InputError that names the bad token and its
/// place. The model knows no parser (it uses the standard library only); io/formula_parser.h
/// provides this one.
using FormulaCompiler = std::function<std::unique_ptr<Formula>(
    const std::string& text, const std::map<std::string, double>& constants)>;

}  // namespace orasp
