#include "orasp/model/objectives/piece_cost.h"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

class PieceCostTerm : public SizeCostTerm {
 public:
  explicit PieceCostTerm(SizeCosts all) : SizeCostTerm(std::move(all)) {
    const auto by_size =
        std::span(costs().costs).subspan(std::min<std::size_t>(1, costs().costs.size()));
    if (by_size.empty()) return;
    const auto [cheapest, dearest] = std::ranges::minmax(by_size);
    range_ = {0.0 - costs().base - std::max(0.0, 2 * dearest),
              0.0 - costs().base - std::min(0.0, 2 * cheapest)};
  }

  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    return question.completes ? RewardRange{costs().last[1], costs().last[1]} : range_;
  }

 private:
  RewardRange range_{0, 0};  ///< of a step that does not complete
};

class PieceCostKind : public ObjectiveKindOf<PieceCost> {
  void list(PieceCost& cost, ParameterVisitor& visitor) const override {
    visitor.number("operation", cost.operation);
    visitor.costs_by_size("pieces", cost.pieces);
    visitor.number("completion", cost.completion);
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const PieceCost& cost, const detail::ProblemTotals& totals) const override {
    SizeCosts costs;
    costs.last = {cost.completion, cost.completion};
    costs.alone = 0.0 - cost.operation;
    costs.base = cost.operation;
    costs.costs.assign(totals.problem.num_parts() + 1, 0.0);
    for (const auto& [size, value] : cost.pieces) {
      if (size < costs.costs.size()) costs.costs[size] = value;
    }
    return std::make_unique<PieceCostTerm>(std::move(costs));
  }
  [[nodiscard]] detail::CheckedTerm checked(const PieceCost& cost,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(problem);
    detail::CheckedTerm term;
    term.value = [&cost](const detail::SeenStep& step) -> detail::CheckedValue {
      if (step.completes) return {cost.completion};
      double spent = cost.operation;
      if (step.separates) {
        for (const std::size_t parts : step.pieces()) {
          const auto listed = cost.pieces.find(parts);
          if (listed != cost.pieces.end()) spent += listed->second;
        }
      }
      return {0.0 - spent};
    };
    return term;
  }
};

/// One with fixed numbers, of which a file states none.
class FixedPieceCostKind : public PieceCostKind {
 public:
  explicit FixedPieceCostKind(PieceCost cost) : cost_(std::move(cost)) {}

  [[nodiscard]] ObjectiveParameters defaults() const override { return cost_; }
  [[nodiscard]] bool takes(const ObjectiveParameters& parameters) const override {
    const auto* const cost = std::get_if<PieceCost>(&parameters);
    return cost != nullptr && cost->operation == cost_.operation && cost->pieces == cost_.pieces &&
           cost->completion == cost_.completion;
  }

 private:
  void list(PieceCost& cost, ParameterVisitor& visitor) const override {
    static_cast<void>(cost);
    static_cast<void>(visitor);
  }

  PieceCost cost_;
};

}  // namespace

const ObjectiveKind& piece_cost_kind() {
  static const PieceCostKind kind;
  return kind;
}

const ObjectiveKind& cubesat_kind() {
  static const FixedPieceCostKind kind(
      {.operation = 0, .pieces = {{1, 0.0967}, {2, 0.1248}, {3, 0.1368}}, .completion = 1});
  return kind;
}

const ObjectiveKind& custom_kind() {
  static const FixedPieceCostKind kind(
      {.operation = 0.1, .pieces = {{1, 1}, {2, 1.5}, {3, 1.75}}, .completion = 1});
  return kind;
}

}  // namespace orasp
