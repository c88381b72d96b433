#include "orasp/model/objectives/expression.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/objective_kind.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

using detail::in_quotes;

/// A formula of sizes alone is looked up in a table of its values up to this many parts (two values
/// for each pair of sizes).
constexpr std::size_t kMostPartsInTable = 2048;
constexpr std::size_t kLongestName = 64;

bool is_identifier(std::string_view name) {
  const auto letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  return !name.empty() && name.size() <= kLongestName && letter(name[0]) &&
         std::ranges::all_of(name, [&](char c) { return letter(c) || digit(c); });
}

/// Formulas cannot be shared between threads, so each has a term of its own.
class ExpressionTerm : public ObjectiveTerm {
 public:
  ExpressionTerm(const Expression& expression, const detail::ProblemTotals& totals)
      : expression_(expression),
        totals_(totals),
        formula_(expression.compiler(expression.formula, expression.constants)) {
    const auto uses = [&](std::string_view name) { return formula_->uses(name); };
    sees.calls_out = true;
    sees.piece_only = !uses("before") && !uses("after") && !uses("subassemblies");
    sees.gain_by_connection = uses("duration") || uses("index");
    sees.gain_by_sizes = sees.piece_only && !sees.gain_by_connection && !uses("moved_mass") &&
                         !uses("kept_mass") && !uses("distance");
    sees.counting = sees.gain_by_sizes && totals.problem.num_parts() <= kMostPartsInTable;
  }

  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> for_one_thread() const override {
    return std::make_unique<ExpressionTerm>(expression_, totals_);
  }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    if (sees.counting) return reward_of_sizes(facts, pieces);
    FormulaVariables variables;
    variables.before = static_cast<double>(facts.before);
    variables.after = static_cast<double>(facts.after);
    variables.separates = facts.separates ? 1 : 0;
    variables.completes = facts.completes ? 1 : 0;
    variables.subassemblies = static_cast<double>(totals_.assembly ? facts.subassemblies_joined
                                                                   : facts.subassemblies_apart);
    variables.duration = totals_.problem.connections()[facts.connection].duration;
    variables.index = facts.connection;
    if (facts.separates) {
      variables.moved_parts = std::min(facts.a_parts, facts.b_parts);
      variables.kept_parts = std::max(facts.a_parts, facts.b_parts);
      variables.moved_mass = movement.moved_mass;
      variables.kept_mass = movement.kept_mass;
      variables.distance = pieces.distance(movement.a_moves, expression_.depot).value_or(0);
    }
    return pieces.checked(formula_->value(variables), facts);
  }
  [[nodiscard]] double greatest_gain(double weight, std::size_t moved,
                                     std::size_t kept) const override {
    if (!sees.gain_by_sizes) return kInfinity;
    FormulaVariables variables;
    const double own = formula_->value(variables);
    variables.separates = 1;
    variables.moved_parts = static_cast<double>(moved);
    variables.kept_parts = static_cast<double>(kept);
    const double gain = weight * (formula_->value(variables) - own);
    return std::isfinite(gain) ? gain : kInfinity;
  }

 private:
  /// From the table, which is a hundred times quicker than the formula.
  [[nodiscard]] double reward_of_sizes(const detail::StepFacts& facts,
                                       const detail::StepPieces& pieces) const {
    const std::size_t moved = std::min(facts.a_parts, facts.b_parts);
    const std::size_t parts = facts.a_parts + facts.b_parts;
    const std::size_t place = (parts * parts / 4 + moved) * 2 + (facts.completes ? 1 : 0);
    if (place >= table_.size()) table_.resize(place + 1, std::numeric_limits<double>::quiet_NaN());
    double& value = table_[place];
    if (std::isnan(value)) {
      FormulaVariables variables;
      variables.separates = facts.separates ? 1 : 0;
      variables.completes = facts.completes ? 1 : 0;
      variables.moved_parts = static_cast<double>(moved);
      variables.kept_parts = static_cast<double>(parts - moved);
      value = pieces.checked(formula_->value(variables), facts);
    }
    return value;
  }

  const Expression& expression_;
  const detail::ProblemTotals& totals_;
  std::unique_ptr<Formula> formula_;
  /// Of a formula of sizes alone: the values met so far, NaN before; at ((moved + kept)^2 / 4 +
  /// moved) * 2 + completes.
  mutable std::vector<double> table_;
};

/// The formula in the check of plans.
class CheckedFormula {
 public:
  CheckedFormula(const Expression& expression, const detail::CheckedProblem& problem)
      : expression_(expression),
        problem_(problem),
        formula_(expression.compiler(expression.formula, expression.constants)),
        measures_(formula_->uses("moved_mass") || formula_->uses("kept_mass") ||
                  formula_->uses("distance")) {}

  detail::CheckedValue operator()(const detail::SeenStep& step) const {
    FormulaVariables seen;
    seen.before = static_cast<double>(step.before);
    seen.after = static_cast<double>(step.after);
    seen.separates = step.separates ? 1 : 0;
    seen.completes = step.completes ? 1 : 0;
    seen.moved_parts = static_cast<double>(step.moved_parts);
    seen.kept_parts = static_cast<double>(step.a_parts + step.b_parts - step.moved_parts);
    seen.moved_mass = step.moved_mass;
    seen.kept_mass = step.kept_mass;
    seen.subassemblies = static_cast<double>(step.subassemblies);
    seen.duration = problem_.problem().connections()[step.connection].duration;
    seen.index = static_cast<double>(step.connection);
    if (step.moved_centroid)
      seen.distance = detail::metres_between(*step.moved_centroid, expression_.depot);
    detail::CheckedValue found{formula_->value(seen)};
    if (measures_ && step.separates) found.rounding = rounding(step, seen, found.reward);
    return found;
  }

 private:
  /// A formula can enlarge what is lost when masses and positions are added up: this is what it
  /// makes of slightly other sums.
  [[nodiscard]] double rounding(const detail::SeenStep& step, const FormulaVariables& seen,
                                double reward) const {
    const double share = 4 * std::numeric_limits<double>::epsilon() *
                         static_cast<double>(step.a_parts + step.b_parts);
    const double metres =
        step.moved_centroid ? problem_.distance_error(step, expression_.depot) : 0.0;
    double most = 0;
    for (const double sign : {-1.0, 1.0}) {
      FormulaVariables other = seen;
      other.moved_mass += sign * share * seen.moved_mass;
      other.kept_mass -= sign * share * seen.kept_mass;
      other.distance = std::max(0.0, seen.distance + sign * metres);
      const double change = std::abs(formula_->value(other) - reward);
      if (std::isfinite(change)) most = std::max(most, change);
    }
    return most;
  }

  const Expression& expression_;
  const detail::CheckedProblem& problem_;
  std::shared_ptr<Formula> formula_;
  bool measures_;
};

class ExpressionKind : public ObjectiveKindOf<Expression> {
  void list(Expression& expression, ParameterVisitor& visitor) const override {
    visitor.formula("formula", expression.formula, expression.compiler);
    visitor.constants("constants", expression.constants);
    visitor.point("depot", expression.depot);
  }
  void check_whole(const Expression& expression, const std::string& place) const override {
    for (const auto& [name, value] : expression.constants)
      check_constant(name, value, place + ".constants");
    const std::string formula_place = place + ".formula";
    const auto fail = [&](const std::string& message) {
      throw InputError(detail::at(formula_place, message));
    };
    if (expression.formula.find_first_not_of(" \t\r\n") == std::string::npos)
      fail("the formula is empty");
    if (!expression.compiler) {
      fail(
          "no compiler is set; set Expression::compiler to compile_formula of "
          "io/formula_parser.h");
    }
    try {
      (void)expression.compiler(expression.formula, expression.constants);
    } catch (const InputError& error) {
      fail(error.what());
    }
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const Expression& expression, const detail::ProblemTotals& totals) const override {
    return std::make_unique<ExpressionTerm>(expression, totals);
  }
  [[nodiscard]] detail::CheckedTerm checked(const Expression& expression,
                                            const detail::CheckedProblem& problem) const override {
    detail::CheckedTerm term;
    term.calls_out = true;
    term.value = CheckedFormula(expression, problem);
    return term;
  }

  static void check_constant(const std::string& name, double value, const std::string& place) {
    if (!is_identifier(name)) {
      throw InputError(detail::at(place, in_quotes(name) + " is not a name; names are up to " +
                                             std::to_string(kLongestName) +
                                             " letters, digits and _, not a digit first"));
    }
    if (std::ranges::any_of(kFormulaVariables,
                            [&](const FormulaVariable& v) { return v.name == name; })) {
      throw InputError(detail::at(
          place,
          in_quotes(name) + " is a variable of every formula; give the constant another name"));
    }
    if (!std::isfinite(value)) {
      throw InputError(
          detail::at(place + "." + name, detail::number_text(value) + " is not a finite number"));
    }
  }
};

}  // namespace

const ObjectiveKind& expression_kind() {
  static const ExpressionKind kind;
  return kind;
}

}  // namespace orasp
