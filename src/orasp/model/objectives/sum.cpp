#include "orasp/model/objectives/sum.h"

#include <string>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

/// A sum has no term of its own: its addends stand beside those of the sums around it.
class SumKind : public ObjectiveKindOf<WeightedSum> {
  void list(WeightedSum& sum, ParameterVisitor& visitor) const override {
    visitor.terms("terms", sum.terms);
  }
  void require_of_problem(const WeightedSum& sum, const ProblemSpec& problem,
                          const std::string& place) const override {
    for (std::size_t i = 0; i < sum.terms.size(); ++i) {
      const Objective& addend = sum.terms[i].objective;
      kind_of(addend).check_problem(addend.parameters, problem,
                                    place + ".terms[" + std::to_string(i) + "]");
    }
  }
  void look_back_at(const WeightedSum& sum, LookBack& look_back) const override {
    for (const WeightedObjective& addend : sum.terms)
      kind_of(addend.objective).add_look_back(addend.objective.parameters, look_back);
  }
  void add(const WeightedSum& sum, double weight, const detail::ProblemTotals& totals,
           std::vector<WeightedTerm>& terms) const override {
    for (const WeightedObjective& addend : sum.terms) {
      kind_of(addend.objective)
          .add_terms(addend.objective.parameters, weight * addend.weight, totals, terms);
    }
  }
  void add_checked(const WeightedSum& sum, double weight, const detail::CheckedProblem& problem,
                   std::vector<detail::CheckedTerm>& terms) const override {
    for (const WeightedObjective& addend : sum.terms) {
      kind_of(addend.objective)
          .add_checked_terms(addend.objective.parameters, weight * addend.weight, problem, terms);
    }
  }
};

}  // namespace

const ObjectiveKind& sum_kind() {
  static const SumKind kind;
  return kind;
}

}  // namespace orasp
