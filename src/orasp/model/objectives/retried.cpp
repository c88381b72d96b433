#include "orasp/model/objectives/retried.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

/// A term whose rewards are multiplied by a factor of the connection. Where all factors are the
/// same nothing but the unit changes; else sizes alone no longer tell what a step earns.
class RetriedTerm : public ObjectiveTerm {
 public:
  RetriedTerm(std::unique_ptr<const ObjectiveTerm> once, const std::vector<double>& attempts,
              std::size_t parts)
      : once_(std::move(once)), attempts_(attempts), parts_(parts) {
    const auto [least, most] = std::ranges::minmax_element(attempts);
    if (least == attempts.end()) return;
    least_ = *least;
    most_ = *most;
    sees = once_->sees;
    sees.range_by_connection = true;
    if (least_ == most_) {
      if (const SizeCosts* const costs = once_->size_costs()) costs_ = scaled(*costs);
      return;
    }
    sees.sizes_only = sees.gain_by_sizes = sees.moving_more_costs_more = false;
    sees.gain_by_moved = false;
    sees.gain_by_connection = true;
    if (sees.piece_only && parts > 1) shared_ = once_->greatest_gain(1, 1, parts - 1);
    if (!std::isfinite(shared_)) shared_ = 0;
  }

  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> for_one_thread() const override {
    std::unique_ptr<const ObjectiveTerm> own = once_->for_one_thread();
    return own ? std::make_unique<RetriedTerm>(std::move(own), attempts_, parts_) : nullptr;
  }
  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    return attempts_[facts.connection] * once_->reward(facts, movement, pieces);
  }
  [[nodiscard]] const SizeCosts* size_costs() const override { return costs_ ? &*costs_ : nullptr; }
  [[nodiscard]] double size_reward(std::size_t a, std::size_t b, bool completes,
                                   bool whole_start) const override {
    return most_ * once_->size_reward(a, b, completes, whole_start);
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    const RewardRange once = once_->range(question);
    const double attempts = attempts_[question.connection];
    return {attempts * once.least, attempts * once.greatest};
  }
  [[nodiscard]] FormulaLine reward_over(const PlaceQuestion& question) const override {
    FormulaLine once = once_->reward_over(question);
    const double attempts = attempts_[question.connection];
    for (double* const value :
         {&once.at.least, &once.at.greatest, &once.slope.least, &once.slope.greatest})
      *value *= attempts;
    return once;
  }
  [[nodiscard]] double greatest_gain(double weight, std::size_t moved,
                                     std::size_t kept) const override {
    return most_of(weight, once_->greatest_gain(weight, moved, kept));
  }
  [[nodiscard]] double greatest_gain_unmoved(double weight, std::size_t first,
                                             std::size_t second) const override {
    return most_of(weight, once_->greatest_gain_unmoved(weight, first, second));
  }
  [[nodiscard]] double greatest_gain_of_moving(double weight,
                                               const detail::StepPieces& moved) const override {
    return most_of(weight, once_->greatest_gain_of_moving(weight, moved));
  }

  [[nodiscard]] double greatest_gain_of_moving_with(double weight, const detail::StepPieces& some,
                                                    const LargerPiece& piece) const override {
    const LargerPiece once{.least = piece.least, .most = piece.most};
    return most_of(weight, once_->greatest_gain_of_moving_with(weight, some, once));
  }

  void add_extra_costs(double weight, std::span<double> costs) const override {
    const double shared = weight * shared_;
    for (std::size_t c = 0; c < costs.size(); ++c)
      costs[c] += (attempts_[c] - best(shared)) * -shared;
  }

 private:
  /// Let all cuts gain about the same, what taking one part off all others does: `shared`. Where
  /// that is a loss the least factor of all connections is the best one, else the greatest; let it
  /// be b. A cut at c, of factor k(c), gains (b - k(c)) * shared less than one of factor b. The
  /// rest of what it gains is at most
  ///
  ///     k(c) * gain + (b - k(c)) * shared  =  b * gain + (k(c) - b) * (gain - shared)
  ///                                       <=  b * gain + (K - k) * max(0, +-(gain - shared)),
  ///
  /// K the greatest and k the least factor, + where b = k and - where b = K, whatever the
  /// connection is.
  [[nodiscard]] double most_of(double weight, double gain) const {
    const double shared = weight * shared_;
    const double above = shared > 0 ? shared - gain : gain - shared;
    return best(shared) * gain + (most_ - least_) * std::max(0.0, above);
  }
  [[nodiscard]] double best(double shared) const { return shared > 0 ? most_ : least_; }

  [[nodiscard]] SizeCosts scaled(SizeCosts costs) const {
    for (double& reward : costs.last) reward *= most_;
    costs.alone *= most_;
    costs.base *= most_;
    for (double& cost : costs.costs) cost *= most_;
    return costs;
  }

  std::unique_ptr<const ObjectiveTerm> once_;
  const std::vector<double>& attempts_;
  double least_ = 1;
  double most_ = 1;
  std::size_t parts_;
  double shared_ = 0;
  std::optional<SizeCosts> costs_;
};

class RetriedKind : public ObjectiveKindOf<Retried> {
  void require_of_problem(const Retried& retried, const ProblemSpec& problem,
                          const std::string& place) const override {
    for (const WeightedObjective& once : retried.objective)
      kind_of(once.objective).check_problem(once.objective.parameters, problem, place);
  }
  void look_back_at(const Retried& retried, LookBack& look_back) const override {
    for (const WeightedObjective& once : retried.objective)
      kind_of(once.objective).add_look_back(once.objective.parameters, look_back);
  }
  void add(const Retried& retried, double weight, const detail::ProblemTotals& totals,
           std::vector<WeightedTerm>& terms) const override {
    const std::size_t before = terms.size();
    for (const WeightedObjective& once : retried.objective)
      kind_of(once.objective)
          .add_terms(once.objective.parameters, weight * once.weight, totals, terms);
    for (std::size_t i = before; i < terms.size(); ++i)
      terms[i].term = std::make_unique<RetriedTerm>(std::move(terms[i].term), retried.attempts,
                                                    totals.problem.num_parts());
  }
  /// A step that is tried k times on average costs what k steps cost.
  void add_checked(const Retried& retried, double weight, const detail::CheckedProblem& problem,
                   std::vector<detail::CheckedTerm>& terms) const override {
    std::vector<detail::CheckedTerm> addends;
    for (const WeightedObjective& once : retried.objective)
      kind_of(once.objective)
          .add_checked_terms(once.objective.parameters, weight * once.weight, problem, addends);
    for (detail::CheckedTerm& addend : addends) {
      addend.value = [once = std::move(addend.value),
                      &retried](const detail::SeenStep& step) -> detail::CheckedValue {
        const detail::CheckedValue value = once(step);
        const double attempts = retried.attempts[step.connection];
        return {value.reward * attempts, value.rounding * attempts};
      };
      terms.push_back(std::move(addend));
    }
  }
};

}  // namespace

const ObjectiveKind& retried_kind() {
  static const RetriedKind kind;
  return kind;
}

// Declared with Objective, and here since no other file asks which parameters an objective has.
const std::string& Objective::stated_type() const {
  const auto* const retried = std::get_if<Retried>(&parameters);
  return retried == nullptr || retried->objective.empty()
             ? type
             : retried->objective.front().objective.stated_type();
}

Problem attempts_paid(const Problem& problem) {
  ProblemSpec spec = problem.spec();
  Retried retried;
  for (std::size_t c = 0; c < spec.connections.size(); ++c) {
    Connection& connection = spec.connections[c];
    const double attempts = connection.on_failure.abort ? 1 : 1 / connection.success;
    if (!std::isfinite(attempts)) {
      throw InputError("connections[" + std::to_string(c) +
                       "].success: so small that the expected reward is not a finite number");
    }
    retried.attempts.push_back(attempts);
    connection.success = 1;
    connection.on_failure = {};
  }
  retried.objective.push_back({1, std::move(spec.objective)});
  spec.objective = {"retried", std::move(retried)};
  return Problem(std::move(spec));
}

}  // namespace orasp
