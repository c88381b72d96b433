#include "orasp/model/objectives/callable.h"

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "orasp/model/detail/step_variables.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/formula.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

class CallableTerm : public ObjectiveTerm {
 public:
  explicit CallableTerm(const Callable& callable) : callable_(callable) { sees.calls_out = true; }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    static_cast<void>(movement);
    return pieces.checked(callable_.reward(pieces.full_step(facts)), facts);
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    static_cast<void>(question);
    return {callable_.least, callable_.greatest};
  }

 private:
  const Callable& callable_;
};

/// The table of the steps of a problem with these numbers, with no step.
StepTable empty_table(std::span<const std::string> own_numbers) {
  StepTable table;
  for (const FormulaVariable& variable : kFormulaVariables) table.names.emplace_back(variable.name);
  for (const std::string& number : own_numbers) {
    for (std::string& name : names_in_formulas(number)) table.names.push_back(std::move(name));
  }
  table.columns.resize(table.names.size());
  return table;
}

void add_row(const FormulaVariables& variables, StepTable& table) {
  std::size_t column = 0;
  for (const FormulaVariable& variable : kFormulaVariables)
    table.columns[column++].push_back(variables.*variable.value);
  for (const double number : variables.own) table.columns[column++].push_back(number);
}

/// A function of many steps. The notes are one thread's own.
class ManyStepsTerm : public ObjectiveTerm {
 public:
  ManyStepsTerm(const Callable& callable, const detail::ProblemTotals& totals)
      : callable_(callable),
        totals_(totals),
        own_(3 * totals.own_numbers.size(), 0.0),
        table_(empty_table(totals.own_numbers)) {
    sees.calls_out = sees.elapsed = true;
  }

  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> for_one_thread() const override {
    return std::make_unique<ManyStepsTerm>(callable_, totals_);
  }
  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    if (!taking_notes_) forget();
    FormulaVariables variables = detail::variables_of(facts, movement, pieces, callable_.depot);
    for (std::size_t i = 0; i < totals_.own_numbers.size(); ++i)
      detail::own_numbers_of(facts, movement, pieces, i, own_);
    variables.own = own_;
    add_row(variables, table_);
    if (!taking_notes_) return pieces.checked(asked().front(), facts);
    noted_.push_back(facts);
    return static_cast<double>(noted_.size() - 1);
  }
  [[nodiscard]] bool can_take_notes() const override { return true; }
  void take_notes(bool begin) const override {
    taking_notes_ = begin;
    forget();
  }
  [[nodiscard]] std::span<const double> noted_rewards() const override {
    taking_notes_ = false;
    if (noted_.empty()) return {};
    const std::span<const double> rewards = asked();
    const detail::StepPieces pieces{totals_, {}, {}};
    for (std::size_t i = 0; i < rewards.size(); ++i)
      static_cast<void>(pieces.checked(rewards[i], noted_[i]));
    return rewards;
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    static_cast<void>(question);
    return {callable_.least, callable_.greatest};
  }

 private:
  void forget() const {
    noted_.clear();
    for (std::vector<double>& column : table_.columns) column.clear();
  }
  [[nodiscard]] std::span<const double> asked() const {
    rewards_.assign(table_.num_steps(), std::numeric_limits<double>::quiet_NaN());
    callable_.rewards(table_, rewards_);
    return rewards_;
  }

  const Callable& callable_;
  const detail::ProblemTotals& totals_;
  mutable bool taking_notes_ = false;
  mutable std::vector<double> own_;
  mutable StepTable table_;
  mutable std::vector<detail::StepFacts> noted_;
  mutable std::vector<double> rewards_;
};

/// A function of many steps in the check of plans, which asks about one.
detail::CheckedValue value_of_one(const Callable& callable, const detail::SeenStep& step,
                                  std::span<const std::string> numbers) {
  FormulaVariables variables = detail::variables_of(step, callable.depot);
  const std::vector<double> own = detail::own_numbers_of(step, numbers);
  variables.own = own;
  StepTable table = empty_table(numbers);
  add_row(variables, table);
  double reward = std::numeric_limits<double>::quiet_NaN();
  callable.rewards(table, std::span(&reward, 1));
  return {reward};
}

class CallableKind : public ObjectiveKindOf<Callable> {
  void list(Callable& callable, ParameterVisitor& visitor) const override {
    visitor.name("name", callable.name);
  }
  void check_whole(const Callable& callable, const std::string& place) const override {
    if (!callable.reward && !callable.rewards)
      throw InputError(detail::at(place + ".reward", "the callable holds no function"));
    if (callable.reward && callable.rewards) {
      throw InputError(detail::at(place + ".rewards",
                                  "the callable holds a function of one step and one of many"));
    }
    if (!(callable.least <= callable.greatest)) {
      throw InputError(
          detail::at(place, "least " + detail::number_text(callable.least) + " and greatest " +
                                detail::number_text(callable.greatest) + " are not a range"));
    }
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const Callable& callable, const detail::ProblemTotals& totals) const override {
    if (callable.rewards) return std::make_unique<ManyStepsTerm>(callable, totals);
    return std::make_unique<CallableTerm>(callable);
  }
  [[nodiscard]] detail::CheckedTerm checked(const Callable& callable,
                                            const detail::CheckedProblem& problem) const override {
    detail::CheckedTerm term;
    term.calls_out = true;
    if (callable.rewards) {
      term.value = [&callable, numbers = detail::numbers_of(problem.problem().spec())](
                       const detail::SeenStep& step) {
        return value_of_one(callable, step, numbers);
      };
      return term;
    }
    term.needs_step = true;
    term.value = [&callable](const detail::SeenStep& step) -> detail::CheckedValue {
      return {callable.reward(*step.step)};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& callable_kind() {
  static const CallableKind kind;
  return kind;
}

}  // namespace orasp
