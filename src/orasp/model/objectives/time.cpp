#include "orasp/model/objectives/time.h"

#include <algorithm>
#include <memory>
#include <optional>

#include "orasp/model/detail/centroid_distances.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

class TimeTerm : public ObjectiveTerm {
 public:
  TimeTerm(const TimeObjective& time, const detail::ProblemTotals& totals)
      : time_(time),
        farthest_(totals.farthest(time.depot)),
        all_placed_(std::ranges::all_of(
            totals.problem.parts(), [](const Part& part) { return part.position.has_value(); })),
        centroids_(totals.problem, time.depot) {
    // Without positions every transfer takes the same time.
    sees.counting = sees.gain_by_sizes = totals.no_positions && totals.moves_by_size;
    sees.moving_more_costs_more = totals.no_positions;
    sees.piece_only = sees.gain_by_moved = true;
  }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    const double duration = pieces.duration(facts);
    if (!facts.separates) return 0.0 - duration;
    if (sees.counting) return earned(duration, std::nullopt);
    if (!movement.moves) return 0.0 - duration;
    return earned(duration, pieces.distance(movement.a_moves, time_.depot));
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    const double transfer = std::max(time_.transfer, 2 * farthest_ / time_.speed);
    return {0.0 - question.duration - transfer, 0.0 - question.duration};
  }
  [[nodiscard]] double by_second() const override { return -1; }
  [[nodiscard]] double greatest_gain(double weight, std::size_t moved,
                                     std::size_t kept) const override {
    static_cast<void>(kept);
    if (sees.counting) return weight * (0.0 - time_.transfer);
    if (weight > 0) {
      const double least = 2 * centroids_.least(moved) / time_.speed;
      return 0.0 - weight * (all_placed_ ? least : std::min(least, time_.transfer));
    }
    return 0.0 - weight * std::max(time_.transfer, 2 * farthest_ / time_.speed);
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
    return weight * earned(0, moved.distance(true, time_.depot));
  }
  [[nodiscard]] double greatest_gain_of_moving_with(double weight, const detail::StepPieces& some,
                                                    const LargerPiece& piece) const override {
    if (weight < 0 || sees.counting) return greatest_gain(weight, piece.least, piece.least);
    if (!all_placed_ && !some.distance(true, time_.depot)) return weight * earned(0, std::nullopt);
    const double metres = centroids_.least_with(
        some.a, {piece.least, piece.most, 0.0 - piece.low_enough / weight * time_.speed / 2});
    const double seconds = 2 * metres / time_.speed;
    return 0.0 - weight * (all_placed_ ? seconds : std::min(seconds, time_.transfer));
  }

 private:
  [[nodiscard]] double earned(double duration, std::optional<double> metres) const {
    return 0.0 - (duration + (metres ? 2 * *metres / time_.speed : time_.transfer));
  }

  TimeObjective time_;
  double farthest_;
  bool all_placed_;
  detail::CentroidDistances centroids_;
};

class TimeKind : public ObjectiveKindOf<TimeObjective> {
  void list(TimeObjective& time, ParameterVisitor& visitor) const override {
    visitor.point("depot", time.depot);
    visitor.number("speed", time.speed, NumberRange::AboveZero);
    visitor.number("transfer", time.transfer, NumberRange::NotNegative);
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const TimeObjective& time, const detail::ProblemTotals& totals) const override {
    return std::make_unique<TimeTerm>(time, totals);
  }
  [[nodiscard]] detail::CheckedTerm checked(const TimeObjective& time,
                                            const detail::CheckedProblem& problem) const override {
    detail::CheckedTerm term;
    term.value = [&time, &problem](const detail::SeenStep& step) -> detail::CheckedValue {
      const double duration = step.duration;
      if (step.moved_parts == 0) return {0.0 - duration};
      if (!step.moved_centroid) return {0.0 - (duration + time.transfer)};
      const double metres = detail::metres_between(*step.moved_centroid, time.depot);
      return {0.0 - (duration + 2 * metres / time.speed),
              2 * problem.distance_error(step, time.depot) / time.speed};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& time_kind() {
  static const TimeKind kind;
  return kind;
}

}  // namespace orasp
