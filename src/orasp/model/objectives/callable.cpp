#include "orasp/model/objectives/callable.h"

#include <memory>
#include <string>

#include "orasp/model/detail/wording.h"
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

class CallableKind : public ObjectiveKindOf<Callable> {
  void list(Callable& callable, ParameterVisitor& visitor) const override {
    visitor.name("name", callable.name);
  }
  void check_whole(const Callable& callable, const std::string& place) const override {
    if (!callable.reward)
      throw InputError(detail::at(place + ".reward", "the callable holds no function"));
    if (!(callable.least <= callable.greatest)) {
      throw InputError(
          detail::at(place, "least " + detail::number_text(callable.least) + " and greatest " +
                                detail::number_text(callable.greatest) + " are not a range"));
    }
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const Callable& callable, const detail::ProblemTotals& totals) const override {
    static_cast<void>(totals);
    return std::make_unique<CallableTerm>(callable);
  }
  [[nodiscard]] detail::CheckedTerm checked(const Callable& callable,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(problem);
    detail::CheckedTerm term;
    term.calls_out = term.needs_step = true;
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
