#include "orasp/model/objectives/expression.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "orasp/model/detail/step_variables.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/formula_range.h"
#include "orasp/model/objectives/objective_kind.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

using detail::in_quotes;

/// A formula of sizes alone is looked up in a table of its values up to this many parts (two values
/// for each pair of sizes).
constexpr std::size_t kMostPartsInTable = 2048;

/// The place of a variable in kFormulaVariables.
consteval std::size_t number_of_variable(std::string_view name) {
  std::size_t i = 0;
  while (kFormulaVariables[i].name != name) ++i;
  return i;
}

/// The names of the user's own numbers, as formulas know them.
std::vector<std::string> own_names(const std::vector<std::string>& numbers) {
  std::vector<std::string> names;
  for (const std::string& number : numbers) {
    for (std::string& name : names_in_formulas(number)) names.push_back(std::move(name));
  }
  return names;
}
std::vector<std::string> own_names(const detail::ProblemTotals& totals) {
  return own_names(totals.own_numbers);
}

/// Formulas cannot be shared between threads, so each has a term of its own.
class ExpressionTerm : public ObjectiveTerm {
 public:
  ExpressionTerm(const Expression& expression, const detail::ProblemTotals& totals)
      : expression_(expression),
        totals_(totals),
        formula_(expression.compiler(expression.formula, expression.constants, own_names(totals))),
        own_(3 * totals.own_numbers.size(), 0.0) {
    const auto uses = [&](std::string_view name) { return formula_->uses(name); };
    sees.calls_out = true;
    bool own_of_pieces = false;
    for (std::size_t i = 0; i < totals.own_numbers.size(); ++i) {
      const auto names = names_in_formulas(totals.own_numbers[i]);
      const bool of_connection = uses(names[0]);
      const bool of_pieces = uses(names[1]) || uses(names[2]);
      if (of_connection || of_pieces) used_.push_back(i);
      sees.gain_by_connection = sees.gain_by_connection || of_connection;
      own_of_pieces = own_of_pieces || of_pieces;
    }
    sees.elapsed = uses("elapsed");
    sees.by_place = uses("before") || uses("after");
    sees.piece_only = !uses("before") && !uses("after") && !uses("subassemblies") && !sees.elapsed;
    sees.gain_by_connection = sees.gain_by_connection || uses("duration") || uses("index");
    sees.gain_by_sizes = sees.piece_only && !sees.gain_by_connection && !uses("moved_mass") &&
                         !uses("kept_mass") && !uses("distance") && !own_of_pieces &&
                         totals.moves_by_size;
    sees.counting = sees.gain_by_sizes && totals.problem.num_parts() <= kMostPartsInTable;
  }

  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> for_one_thread() const override {
    return std::make_unique<ExpressionTerm>(expression_, totals_);
  }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    if (sees.counting) return reward_of_sizes(facts, pieces);
    FormulaVariables variables = detail::variables_of(facts, movement, pieces, expression_.depot);
    if (!used_.empty()) variables.own = own_numbers(facts, movement, pieces);
    return pieces.checked(formula_->value(variables), facts);
  }
  [[nodiscard]] FormulaLine reward_over(const PlaceQuestion& question) const override {
    auto* const formula = dynamic_cast<RangedFormula*>(formula_.get());
    if (formula == nullptr) return {{-kInfinity, kInfinity}, {0, 0}};
    FormulaRanges ranges;
    ranges.time = question.time;
    std::vector<FormulaLine> own(own_.size());
    set_ranges(question, ranges, own);
    ranges.own = own;
    return formula->over(ranges);
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
  /// The connection's number of each name, and the sums over the moved and over the kept piece.
  [[nodiscard]] std::span<const double> own_numbers(const detail::StepFacts& facts,
                                                    const detail::Movement& movement,
                                                    const detail::StepPieces& pieces) const {
    for (const std::size_t i : used_) detail::own_numbers_of(facts, movement, pieces, i, own_);
    return own_;
  }

  /// What the variables may be of a step of which no more is known than the question says.
  void set_ranges(const PlaceQuestion& question, FormulaRanges& ranges,
                  std::vector<FormulaLine>& own) const {
    const auto set = [&](std::size_t variable, double least, double greatest) {
      ranges.variables[variable] = {{least, greatest}, {0, 0}};
    };
    ranges.variables[number_of_variable("before")] = question.before;
    ranges.variables[number_of_variable("after")] = question.after;
    ranges.variables[number_of_variable("elapsed")] = question.elapsed;
    const double completes = question.completes ? 1 : 0;
    set(number_of_variable("completes"), completes, completes);
    set(number_of_variable("duration"), question.duration.least, question.duration.greatest);
    set(number_of_variable("index"), question.connection, question.connection);
    // Each subassembly holds a connection that is present.
    const double slope = question.after.slope.greatest;
    const double present = question.after.at.greatest +
                           std::max(slope * question.time.least, slope * question.time.greatest);
    const auto parts = static_cast<double>(totals_.problem.num_parts());
    set(number_of_variable("subassemblies"), 0,
        std::max(0.0, std::min(present, std::floor(parts / 2))));
    const double known = totals_.moves_by_size ? 1 : 0;
    if (question.separates) {
      // Sums of masses and positions are rounded.
      constexpr double kRounding = 1 + 1e-12;
      const double mass = totals_.total_mass * kRounding;
      set(number_of_variable("separates"), 1, 1);
      set(number_of_variable("moved_parts"), known,
          totals_.moves_by_size ? std::floor(parts / 2) : parts);
      set(number_of_variable("kept_parts"), known, parts);
      set(number_of_variable("moved_mass"), 0, mass);
      set(number_of_variable("kept_mass"), 0, mass);
      set(number_of_variable("distance"), 0, farthest() * kRounding);
    }
    for (const std::size_t i : used_) {
      const NumberSums& sums = sums_of(i);
      const double value = sums.of_connection[question.connection];
      own[3 * i] = {question.several ? sums.of_connections : Interval{value, value}, {0, 0}};
      if (question.separates) own[3 * i + 1] = own[3 * i + 2] = {sums.of_parts, {0, 0}};
    }
  }
  [[nodiscard]] double farthest() const {
    if (!farthest_) farthest_ = totals_.farthest(expression_.depot);
    return *farthest_;
  }

  /// What a number of the user's own may add up to.
  struct NumberSums {
    std::vector<double> of_connection;
    Interval of_connections;  ///< of any of them
    Interval of_parts;        ///< of any parts
  };
  [[nodiscard]] const NumberSums& sums_of(std::size_t number) const {
    sums_.resize(totals_.own_numbers.size());
    NumberSums& sums = sums_[number];
    const Problem& problem = totals_.problem;
    if (!sums.of_connection.empty()) return sums;
    const auto stated = [&](const std::map<std::string, double>& numbers, Interval& sum) {
      const auto found = numbers.find(totals_.own_numbers[number]);
      const double value = found == numbers.end() ? 0 : found->second;
      (value < 0 ? sum.least : sum.greatest) += value;
      return value;
    };
    for (const Connection& connection : problem.spec().connections)
      sums.of_connection.push_back(stated(connection.numbers, sums.of_connections));
    for (const Part& part : problem.spec().parts) (void)stated(part.numbers, sums.of_parts);
    for (Interval* const sum : {&sums.of_connections, &sums.of_parts}) {
      const double rounding = 1e-12 * (sum->greatest - sum->least);
      sum->least -= rounding;
      sum->greatest += rounding;
    }
    return sums;
  }

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
  std::vector<std::size_t> used_;         ///< those of totals_.own_numbers that the formula names
  mutable std::vector<double> own_;       ///< three for each of totals_.own_numbers
  mutable std::vector<NumberSums> sums_;  ///< by number, filled when asked for
  mutable std::optional<double> farthest_;
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
        numbers_(detail::numbers_of(problem.problem().spec())),
        formula_(
            expression.compiler(expression.formula, expression.constants, own_names(numbers_))),
        measures_(formula_->uses("moved_mass") || formula_->uses("kept_mass") ||
                  formula_->uses("distance") || formula_->uses("elapsed") || uses_own_sums()) {}

  detail::CheckedValue operator()(const detail::SeenStep& step) const {
    FormulaVariables seen = detail::variables_of(step, expression_.depot);
    const std::vector<double> own = detail::own_numbers_of(step, numbers_);
    seen.own = own;
    detail::CheckedValue found{formula_->value(seen)};
    if (measures_) found.rounding = rounding(step, seen, found.reward);
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
      other.elapsed += sign * 4 * std::numeric_limits<double>::epsilon() *
                       static_cast<double>(problem_.problem().num_connections()) * seen.elapsed;
      std::vector<double> own(seen.own.begin(), seen.own.end());
      for (std::size_t i = 0; i < own.size(); ++i) {
        if (i % 3 != 0) own[i] += sign * share * step.largest_number_sum;
      }
      other.own = own;
      const double change = std::abs(formula_->value(other) - reward);
      if (std::isfinite(change)) most = std::max(most, change);
    }
    return most;
  }

  [[nodiscard]] bool uses_own_sums() const {
    return std::ranges::any_of(numbers_, [this](const std::string& name) {
      return formula_->uses("moved_" + name) || formula_->uses("kept_" + name);
    });
  }

  const Expression& expression_;
  const detail::CheckedProblem& problem_;
  std::vector<std::string> numbers_;  ///< their names
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
    // A name that is unknown here may be that of a number which parts or connections state.
    try {
      (void)expression.compiler(expression.formula, expression.constants, {});
    } catch (const InputError& error) {
      if (!std::string_view(error.what()).starts_with(kUnknownName)) fail(error.what());
    }
  }
  void require_of_problem(const Expression& expression, const ProblemSpec& problem,
                          const std::string& place) const override {
    try {
      (void)expression.compiler(expression.formula, expression.constants,
                                own_names(detail::numbers_of(problem)));
    } catch (const InputError& error) {
      throw InputError(detail::at(place + ".formula", error.what()));
    }
    if (problem.action == StepKind::Connection) return;
    const auto formula = expression.compiler(expression.formula, expression.constants,
                                             own_names(detail::numbers_of(problem)));
    if (formula->uses("index"))
      throw InputError(detail::at(place + ".formula",
                                  "\"index\" is the place of one connection, and with \"action\": "
                                  "\"part\" a step takes several"));
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
    if (!is_formula_name(name)) {
      throw InputError(detail::at(place, in_quotes(name) + " is not a name; names are up to " +
                                             std::to_string(kLongestFormulaName) +
                                             " letters, digits and _, not a digit first"));
    }
    if (is_formula_variable(name)) {
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
