#include "orasp/model/objectives/route.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

double length(const Vector3& from, const Vector3& to) {
  return std::hypot(from[0] - to[0], from[1] - to[1], from[2] - to[2]);
}

class RouteTerm : public ObjectiveTerm {
 public:
  RouteTerm(const Route& route, const detail::ProblemTotals& totals) : route_(route) {
    sees.looks_back = true;
    // No two places lie farther apart than the corners of the box around all of them.
    Vector3 least{kInfinity, kInfinity, kInfinity};
    Vector3 greatest{-kInfinity, -kInfinity, -kInfinity};
    const auto take_in = [&](const Vector3& place) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        least[axis] = std::min(least[axis], place[axis]);
        greatest[axis] = std::max(greatest[axis], place[axis]);
      }
    };
    for (ConnectionIndex c = 0; c < totals.problem.num_connections(); ++c) {
      if (const auto place = totals.problem.place(c)) take_in(*place);
    }
    if (route.start) take_in(*route.start);
    if (least[0] <= greatest[0]) farthest_ = length(least, greatest);
  }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    static_cast<void>(facts);
    static_cast<void>(movement);
    if (pieces.memory == nullptr) return 0;
    const std::optional<Vector3>& from =
        pieces.memory->last_place ? pieces.memory->last_place : route_.start;
    if (!from || !pieces.memory->place) return 0;
    return 0.0 - route_.per_metre * length(*from, *pieces.memory->place);
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    static_cast<void>(question);
    const double most = route_.per_metre * farthest_;
    return {std::min(0.0, 0.0 - most), std::max(0.0, 0.0 - most)};
  }
  [[nodiscard]] std::optional<LookBackCosts> look_back_costs() const override {
    return LookBackCosts{.per_metre = route_.per_metre, .start = route_.start};
  }

 private:
  Route route_;
  double farthest_ = 0;
};

class RouteKind : public ObjectiveKindOf<Route> {
  void list(Route& route, ParameterVisitor& visitor) const override {
    visitor.optional_point("start", route.start);
    visitor.number("per_metre", route.per_metre);
  }
  void require_of_problem(const Route& route, const ProblemSpec& problem,
                          const std::string& place) const override {
    static_cast<void>(route);
    std::unordered_map<std::string_view, bool> has_position;
    for (const Part& part : problem.parts) has_position[part.id] = part.position.has_value();
    for (const Connection& connection : problem.connections) {
      if (connection.position) continue;
      for (const std::string& end : connection.parts) {
        if (has_position[end]) continue;
        throw InputError(detail::at(place, "\"route\" needs the place of every connection, and " +
                                               detail::in_quotes(connection.id) +
                                               " has no position, nor has its part " +
                                               detail::in_quotes(end)));
      }
    }
  }
  void look_back_at(const Route& route, LookBack& look_back) const override {
    static_cast<void>(route);
    look_back.place = true;
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const Route& route, const detail::ProblemTotals& totals) const override {
    return std::make_unique<RouteTerm>(route, totals);
  }
  [[nodiscard]] detail::CheckedTerm checked(const Route& route,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(problem);
    detail::CheckedTerm term;
    term.looks_back = true;
    term.value = [&route](const detail::SeenStep& step) -> detail::CheckedValue {
      const std::optional<Vector3> from = step.last_place ? step.last_place : route.start;
      if (!from || !step.place) return {0};
      const double metres = detail::metres_between(*step.place, *from);
      double reach = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        reach = std::max({reach, std::abs((*from)[axis]), std::abs((*step.place)[axis])});
      const double rounding = 64 * std::numeric_limits<double>::epsilon() * reach;
      return {0.0 - route.per_metre * metres, std::abs(route.per_metre) * rounding};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& route_kind() {
  static const RouteKind kind;
  return kind;
}

}  // namespace orasp
