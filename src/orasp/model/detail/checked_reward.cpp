#include "orasp/model/detail/checked_reward.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <variant>

namespace orasp::detail {

namespace {

constexpr double kGravity = 9.80665;  // m/s^2, the standard value in a specific impulse
constexpr double kRounding = std::numeric_limits<double>::epsilon();

double metres_between(const Vector3& point, const Vector3& depot) {
  return std::hypot(point[0] - depot[0], point[1] - depot[1], point[2] - depot[2]);
}

double largest_coordinate(const Vector3& point) {
  return std::max({std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
}

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace

struct CheckedReward::TermValue {
  double reward = 0;
  double rounding = 0;
};

CheckedReward::CheckedReward(const Problem& problem) : problem_(problem) {
  add_terms(problem.objective(), 1);
  for (const Part& part : problem.parts()) {
    if (part.position)
      farthest_coordinate_ = std::max(farthest_coordinate_, largest_coordinate(*part.position));
  }
}

void CheckedReward::add_terms(const Objective& objective, double weight) {
  if (const auto* sum = std::get_if<WeightedSum>(&objective.parameters)) {
    for (const WeightedObjective& addend : sum->terms)
      add_terms(addend.objective, weight * addend.weight);
    return;
  }
  if (objective.of_fleet()) {
    throw InputError("objective: \"" + objective.type +
                     "\" judges plans of several robots and no plan of one; name another "
                     "objective, or plan for the fleet");
  }
  Term term{weight, &objective.parameters, nullptr, false};
  if (const auto* expression = std::get_if<Expression>(&objective.parameters)) {
    if (!expression->compiler) {
      throw InputError(
          "objective: an expression needs a compiler (use parse_objective, or set "
          "Expression::compiler)");
    }
    term.formula = expression->compiler(expression->formula, expression->constants);
    term.formula_measures = term.formula->uses("moved_mass") || term.formula->uses("kept_mass") ||
                            term.formula->uses("distance");
  }
  if (std::holds_alternative<Callable>(objective.parameters)) needs_step_ = true;
  if (std::holds_alternative<CubesatZone>(objective.parameters)) find_starting_pieces();
  terms_.push_back(std::move(term));
}

void CheckedReward::find_starting_pieces() {
  if (!starting_piece_.empty()) return;
  std::vector<PartIndex> leader(problem_.num_parts());
  std::iota(leader.begin(), leader.end(), PartIndex{0});
  const auto leader_of = [&](PartIndex part) {
    while (leader[part] != part) part = leader[part] = leader[leader[part]];
    return part;
  };
  for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
    const auto& ends = problem_.ends(c);
    leader[leader_of(ends[0])] = leader_of(ends[1]);
  }
  std::vector<std::size_t> parts(leader.size(), 0);
  for (PartIndex part = 0; part < leader.size(); ++part) ++parts[leader_of(part)];
  starting_piece_.resize(leader.size());
  for (PartIndex part = 0; part < leader.size(); ++part)
    starting_piece_[part] = parts[leader_of(part)];
}

double CheckedReward::zone_cost(std::size_t parts, std::size_t of_parts, bool starting) const {
  if (parts == 1) return of_parts < 4 && !starting ? 0.0823 : 0.0967;
  if (parts == 2) return 0.0722;
  return parts == 3 ? 0.0782 : 0.0;
}

// How far two honest means of the same positions can lie apart, and two distances with them.
double CheckedReward::distance_error(const SeenStep& step, const Vector3& depot) const {
  const double reach = std::max(farthest_coordinate_, largest_coordinate(depot));
  return 4 * kRounding * static_cast<double>(step.moved_parts + 1) * reach;
}

CheckedReward::TermValue CheckedReward::value(const Term& term, const SeenStep& step) const {
  const double duration = problem_.connections()[step.connection].duration;
  const auto moved_parts = static_cast<double>(step.moved_parts);
  return std::visit(
      Overloaded{
          [&](const PieceCost& cost) -> TermValue {
            if (step.completes) return {cost.completion};
            double spent = cost.operation;
            if (step.separates) {
              for (const std::size_t parts : {step.a_parts, step.b_parts}) {
                const auto listed = cost.pieces.find(parts);
                if (listed != cost.pieces.end()) spent += listed->second;
              }
            }
            return {0.0 - spent};
          },
          [&](const CubesatZone&) -> TermValue {
            if (step.completes) return {1};
            if (!step.separates) return {0};
            const std::size_t parts = step.a_parts + step.b_parts;
            const PartIndex part = problem_.ends(step.connection)[0];
            const bool starting = starting_piece_[part] == parts;
            return {0.0 - (zone_cost(step.a_parts, parts, starting) +
                           zone_cost(step.b_parts, parts, starting))};
          },
          [&](const Indexed&) -> TermValue {
            const auto connections = static_cast<double>(step.before);
            const auto index = static_cast<double>(step.connection);
            return {index + 1 < connections ? connections - index : -1.0};
          },
          [&](const TimeObjective& time) -> TermValue {
            if (!step.separates) return {0.0 - duration};
            if (!step.moved_centroid) return {0.0 - (duration + time.transfer)};
            const double metres = metres_between(*step.moved_centroid, time.depot);
            return {0.0 - (duration + 2 * metres / time.speed),
                    2 * distance_error(step, time.depot) / time.speed};
          },
          [&](const Travel& travel) -> TermValue {
            if (!step.separates || !step.moved_centroid) return {0};
            const double metres = metres_between(*step.moved_centroid, travel.depot);
            const double error = distance_error(step, travel.depot);
            return {0.0 - moved_parts * metres * metres,
                    moved_parts * (2 * metres + error) * error};
          },
          [&](const Fuel& fuel) -> TermValue {
            if (!step.separates) return {0};
            // The rocket equation: to end at mass m it burns m (e^(delta v / (g Isp)) - 1). Out
            // empty, back with the moved piece.
            const double burnt = std::expm1(fuel.delta_v / (fuel.isp * kGravity));
            const double out = fuel.dry_mass * burnt;
            const double back = (fuel.dry_mass + step.moved_mass) * burnt;
            return {0.0 - (out + back)};
          },
          [&](const CompletionObjective& completion) -> TermValue {
            double earned = step.separates ? completion.join : 0.0;
            earned -= completion.step;
            return {step.completes ? earned + completion.bonus : earned};
          },
          [&](const Expression& expression) -> TermValue {
            FormulaVariables seen;
            seen.before = static_cast<double>(step.before);
            seen.after = static_cast<double>(step.after);
            seen.separates = step.separates ? 1 : 0;
            seen.completes = step.completes ? 1 : 0;
            seen.moved_parts = moved_parts;
            seen.kept_parts = static_cast<double>(step.a_parts + step.b_parts - step.moved_parts);
            seen.moved_mass = step.moved_mass;
            seen.kept_mass = step.kept_mass;
            seen.subassemblies = static_cast<double>(step.subassemblies);
            seen.duration = duration;
            seen.index = static_cast<double>(step.connection);
            if (step.moved_centroid)
              seen.distance = metres_between(*step.moved_centroid, expression.depot);
            TermValue found{term.formula->value(seen)};
            if (!term.formula_measures || !step.separates) return found;
            // A formula can enlarge what is lost when masses and positions are added up: see what
            // it makes of slightly other sums.
            const double share = 4 * kRounding * static_cast<double>(step.a_parts + step.b_parts);
            const double metres =
                step.moved_centroid ? distance_error(step, expression.depot) : 0.0;
            for (const double sign : {-1.0, 1.0}) {
              FormulaVariables other = seen;
              other.moved_mass += sign * share * seen.moved_mass;
              other.kept_mass -= sign * share * seen.kept_mass;
              other.distance = std::max(0.0, seen.distance + sign * metres);
              const double change = std::abs(term.formula->value(other) - found.reward);
              if (std::isfinite(change)) found.rounding = std::max(found.rounding, change);
            }
            return found;
          },
          [&](const Callable& callable) -> TermValue { return {callable.reward(*step.step)}; },
          // These are no terms: add_terms resolves the one and refuses the others.
          [](const WeightedSum&) -> TermValue { return {}; },
          [](const Makespan&) -> TermValue { return {}; },
          [](const FleetTravel&) -> TermValue { return {}; },
      },
      *term.parameters);
}

CheckedReward::Value CheckedReward::of(const SeenStep& step) const {
  Value sum;
  for (const Term& term : terms_) {
    const TermValue found = value(term, step);
    const bool of_the_user = term.formula || std::holds_alternative<Callable>(*term.parameters);
    if (of_the_user && !std::isfinite(found.reward) && sum.finite) {
      sum.finite = false;
      sum.unfit = found.reward;
    }
    sum.reward += term.weight * found.reward;
    sum.magnitude += std::abs(term.weight * found.reward);
    sum.rounding += std::abs(term.weight) * found.rounding;
  }
  return sum;
}

}  // namespace orasp::detail
