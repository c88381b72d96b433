#include "orasp/model/objectives/fuel.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

constexpr double kStandardGravity = 9.80665;  // m/s^2

class FuelTerm : public ObjectiveTerm {
 public:
  FuelTerm(const Fuel& fuel, const detail::ProblemTotals& totals)
      : totals_(totals),
        dry_mass_(fuel.dry_mass),
        propellant_(std::expm1(fuel.delta_v / (fuel.isp * kStandardGravity))) {
    sees.counting = sees.gain_by_sizes = totals.uniform_mass && totals.moves_by_size;
    sees.piece_only = sees.moving_more_costs_more = sees.gain_by_moved = true;
  }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    static_cast<void>(pieces);
    if (!facts.separates) return 0;
    if (sees.counting) return earned(std::min(facts.a_parts, facts.b_parts) * totals_.part_mass);
    return movement.moves ? earned(movement.moved_mass) : 0;
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    static_cast<void>(question);
    return {0.0 - (2 * dry_mass_ + totals_.total_mass) * propellant_, 0};
  }
  [[nodiscard]] double greatest_gain(double weight, std::size_t moved,
                                     std::size_t kept) const override {
    static_cast<void>(kept);
    return weight * earned(weight > 0 ? totals_.lightest[moved] : totals_.heaviest[moved]);
  }
  [[nodiscard]] double greatest_gain_unmoved(double weight, std::size_t first,
                                             std::size_t second) const override {
    static_cast<void>(weight);
    static_cast<void>(first);
    static_cast<void>(second);
    return 0;
  }
  [[nodiscard]] double greatest_gain_of_moving(double weight,
                                               const detail::StepPieces& moved) const override {
    return weight * earned(moved.mass(moved.a));
  }
  [[nodiscard]] double cost_of_mass(double weight) const override {
    return weight > 0 ? weight * propellant_ : 0;
  }

 private:
  [[nodiscard]] double earned(double moved_mass) const {
    return 0.0 - (dry_mass_ * propellant_ + (dry_mass_ + moved_mass) * propellant_);
  }

  const detail::ProblemTotals& totals_;
  double dry_mass_;
  /// Propellant by burnt-out mass: e^(delta_v / (isp * g)) - 1.
  double propellant_;
};

class FuelKind : public ObjectiveKindOf<Fuel> {
  void list(Fuel& fuel, ParameterVisitor& visitor) const override {
    visitor.number("dry_mass", fuel.dry_mass, NumberRange::NotNegative);
    visitor.number("delta_v", fuel.delta_v, NumberRange::NotNegative);
    visitor.number("isp", fuel.isp, NumberRange::AboveZero);
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const Fuel& fuel, const detail::ProblemTotals& totals) const override {
    return std::make_unique<FuelTerm>(fuel, totals);
  }
  [[nodiscard]] detail::CheckedTerm checked(const Fuel& fuel,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(problem);
    detail::CheckedTerm term;
    term.value = [&fuel](const detail::SeenStep& step) -> detail::CheckedValue {
      if (step.moved_parts == 0) return {0};
      // The rocket equation: to end at mass m it burns m (e^(delta v / (g Isp)) - 1). Out empty,
      // back with the moved piece.
      constexpr double kGravity = 9.80665;  // m/s^2, the standard value in a specific impulse
      const double burnt = std::expm1(fuel.delta_v / (fuel.isp * kGravity));
      const double out = fuel.dry_mass * burnt;
      const double back = (fuel.dry_mass + step.moved_mass) * burnt;
      return {0.0 - (out + back)};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& fuel_kind() {
  static const FuelKind kind;
  return kind;
}

}  // namespace orasp
