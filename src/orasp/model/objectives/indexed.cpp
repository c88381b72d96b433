#include "orasp/model/objectives/indexed.h"

#include <memory>
#include <string>

#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

class IndexedTerm : public ObjectiveTerm {
 public:
  IndexedTerm() { sees.counting = sees.order_only = sees.by_place = true; }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    static_cast<void>(movement);
    static_cast<void>(pieces);
    const auto present = static_cast<double>(facts.before);
    const double index = facts.connection;
    return index < present - 1 ? present - index : -1;
  }
  /// The reward grows with the connections present.
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    const double most = question.most_before;
    return {-1, question.connection < most - 1 ? most - question.connection : -1.0};
  }
  [[nodiscard]] FormulaLine reward_over(const PlaceQuestion& question) const override {
    const double slope = question.before.slope.greatest;
    const double least = question.before.at.least +
                         std::min(slope * question.time.least, slope * question.time.greatest);
    const double most = question.before.at.greatest +
                        std::max(slope * question.time.least, slope * question.time.greatest);
    const RewardRange all = range({.connection = question.connection, .most_before = most});
    const double index = question.connection;
    // Beyond the bend it grows with what is present.
    return {{index < least - 1 ? least - index : -1.0, all.greatest}, {0, 0}};
  }
};

class IndexedKind : public ObjectiveKindOf<Indexed> {
  void require_of_problem(const Indexed& parameters, const ProblemSpec& problem,
                          const std::string& place) const override {
    static_cast<void>(parameters);
    if (problem.action == StepKind::Connection) return;
    throw InputError(detail::at(place,
                                "\"indexed\" looks at the place of one connection in the file, and "
                                "with \"action\": \"part\" a step takes several"));
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const Indexed& parameters, const detail::ProblemTotals& totals) const override {
    static_cast<void>(parameters);
    static_cast<void>(totals);
    return std::make_unique<IndexedTerm>();
  }
  [[nodiscard]] detail::CheckedTerm checked(const Indexed& parameters,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(parameters);
    static_cast<void>(problem);
    detail::CheckedTerm term;
    term.value = [](const detail::SeenStep& step) -> detail::CheckedValue {
      const auto connections = static_cast<double>(step.before);
      const auto index = static_cast<double>(step.connection);
      return {index + 1 < connections ? connections - index : -1.0};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& indexed_kind() {
  static const IndexedKind kind;
  return kind;
}

}  // namespace orasp
