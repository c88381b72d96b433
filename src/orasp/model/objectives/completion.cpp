#include "orasp/model/objectives/completion.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

SizeCosts costs_of(const CompletionObjective& completion, std::size_t num_parts) {
  const auto reward = [&](bool separates, bool completes) {
    return (separates ? completion.join : 0.0) - completion.step +
           (completes ? completion.bonus : 0.0);
  };
  SizeCosts costs;
  costs.last = {reward(false, true), reward(true, true)};
  costs.alone = reward(false, false);
  costs.base = -reward(true, false);
  costs.costs.assign(num_parts + 1, 0.0);
  return costs;
}

class CompletionTerm : public SizeCostTerm {
 public:
  CompletionTerm(const CompletionObjective& completion, std::size_t num_parts)
      : SizeCostTerm(costs_of(completion, num_parts)), completion_(completion) {}

  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    const double always = (question.completes ? completion_.bonus : 0.0) - completion_.step;
    return {always + std::min(0.0, completion_.join), always + std::max(0.0, completion_.join)};
  }

 private:
  CompletionObjective completion_;
};

class CompletionKind : public ObjectiveKindOf<CompletionObjective> {
  void list(CompletionObjective& completion, ParameterVisitor& visitor) const override {
    visitor.number("join", completion.join);
    visitor.number("step", completion.step);
    visitor.number("bonus", completion.bonus);
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const CompletionObjective& completion, const detail::ProblemTotals& totals) const override {
    return std::make_unique<CompletionTerm>(completion, totals.problem.num_parts());
  }
  [[nodiscard]] detail::CheckedTerm checked(const CompletionObjective& completion,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(problem);
    detail::CheckedTerm term;
    term.value = [&completion](const detail::SeenStep& step) -> detail::CheckedValue {
      double earned = step.separates ? completion.join : 0.0;
      earned -= completion.step;
      return {step.completes ? earned + completion.bonus : earned};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& completion_kind() {
  static const CompletionKind kind;
  return kind;
}

}  // namespace orasp
