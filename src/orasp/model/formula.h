#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
  double elapsed = 0;        ///< s, the durations of all connections handled before this step
  /// The user's own numbers, in the order of the names with which the formula was compiled.
  std::span<const double> own{};
};

/// A variable's name in a formula and where its value stands.
struct FormulaVariable {
  std::string_view name;
  double FormulaVariables::*value;
};

/// All variables, in the order of the documentation.
inline constexpr std::array<FormulaVariable, 13> kFormulaVariables = {{
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
    {"elapsed", &FormulaVariables::elapsed},
}};

[[nodiscard]] inline bool is_formula_variable(std::string_view name) {
  return std::ranges::any_of(kFormulaVariables,
                             [&](const FormulaVariable& v) { return v.name == name; });
}

/// How the sentence of a FormulaCompiler begins where a formula names what it does not know.
inline constexpr std::string_view kUnknownName = "unknown name ";

inline constexpr std::size_t kLongestFormulaName = 64;

/// Whether a name may stand in formulas: letters, digits and _, not a digit first.
[[nodiscard]] constexpr bool is_formula_name(std::string_view name) {
  const auto letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  return !name.empty() && name.size() <= kLongestFormulaName && letter(name[0]) &&
         std::ranges::all_of(name, [&](char c) { return letter(c) || digit(c); });
}

/// The names under which a number of the user's own stands in formulas: the connection's, and the
/// sums over the parts of the moved and of the kept piece.
[[nodiscard]] inline std::array<std::string, 3> names_in_formulas(const std::string& number) {
  return {number, "moved_" + number, "kept_" + number};
}

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

/// Compiles a formula text with named constants and the names of further variables
/// (FormulaVariables::own); throws InputError that names the bad token and its place. The model
/// knows no parser (it uses the standard library only); io/formula_parser.h provides this one.
using FormulaCompiler = std::function<std::unique_ptr<Formula>(
    const std::string& text, const std::map<std::string, double>& constants,
    const std::vector<std::string>& own)>;

}  // namespace orasp
