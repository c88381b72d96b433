#include "orasp/model/objectives/travel.h"

#include <algorithm>
#include <memory>
#include <string>

#include "orasp/model/detail/centroid_distances.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

class TravelTerm : public ObjectiveTerm {
 public:
  TravelTerm(const Travel& travel, const detail::ProblemTotals& totals)
      : depot_(travel.depot),
        farthest_(totals.farthest(travel.depot)),
        most_moved_(static_cast<double>(totals.moves_by_size ? totals.problem.num_parts() / 2
                                                             : totals.problem.num_parts())),
        centroids_(totals.problem, travel.depot) {
    sees.piece_only = sees.gain_by_moved = true;
  }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    static_cast<void>(facts);
    if (!movement.moves) return 0;
    const double moved_parts = movement.moved_parts;
    const double metres = pieces.distance(movement.a_moves, depot_).value_or(0);
    return 0.0 - moved_parts * metres * metres;
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    static_cast<void>(question);
    return {0.0 - most_moved_ * farthest_ * farthest_, 0};
  }
  [[nodiscard]] double greatest_gain(double weight, std::size_t moved,
                                     std::size_t kept) const override {
    static_cast<void>(kept);
    const double metres = weight > 0 ? centroids_.least(moved) : farthest_;
    return 0.0 - weight * static_cast<double>(moved) * metres * metres;
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
    const double metres = moved.distance(true, depot_).value_or(0);
    return 0.0 - weight * static_cast<double>(moved.a.parts()) * metres * metres;
  }
  [[nodiscard]] double greatest_gain_of_moving_with(double weight, const detail::StepPieces& some,
                                                    const LargerPiece& piece) const override {
    if (weight < 0) return greatest_gain(weight, piece.most, piece.most);
    return 0.0 - weight * centroids_.least_moment_with(
                              some.a, {piece.least, piece.most, 0.0 - piece.low_enough / weight});
  }

 private:
  Vector3 depot_;
  double farthest_;
  double most_moved_;
  detail::CentroidDistances centroids_;
};

class TravelKind : public ObjectiveKindOf<Travel> {
  void list(Travel& travel, ParameterVisitor& visitor) const override {
    visitor.point("depot", travel.depot);
  }
  void require_of_problem(const Travel& travel, const ProblemSpec& problem,
                          const std::string& place) const override {
    static_cast<void>(travel);
    const auto without =
        std::ranges::find_if(problem.parts, [](const Part& part) { return !part.position; });
    if (without == problem.parts.end()) return;
    throw InputError(detail::at(place, "\"travel\" needs the position of every part, and part " +
                                           detail::in_quotes(without->id) + " has none"));
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const Travel& travel, const detail::ProblemTotals& totals) const override {
    return std::make_unique<TravelTerm>(travel, totals);
  }
  [[nodiscard]] detail::CheckedTerm checked(const Travel& travel,
                                            const detail::CheckedProblem& problem) const override {
    detail::CheckedTerm term;
    term.value = [&travel, &problem](const detail::SeenStep& step) -> detail::CheckedValue {
      if (!step.separates || !step.moved_centroid) return {0};
      const auto parts = static_cast<double>(step.moved_parts);
      const double metres = detail::metres_between(*step.moved_centroid, travel.depot);
      const double error = problem.distance_error(step, travel.depot);
      return {0.0 - parts * metres * metres, parts * (2 * metres + error) * error};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& travel_kind() {
  static const TravelKind kind;
  return kind;
}

}  // namespace orasp
