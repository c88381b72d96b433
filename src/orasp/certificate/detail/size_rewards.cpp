#include "orasp/certificate/detail/size_rewards.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <variant>

#include "orasp/certificate/detail/outward.h"
#include "orasp/model/tolerance.h"

namespace orasp::detail {

namespace {

double cost_of(const PieceCost& cost, std::size_t parts) {
  const auto listed = cost.pieces.find(parts);
  return listed == cost.pieces.end() ? 0.0 : listed->second;
}

/// What `cubesat_zone` takes for one piece; `from_zone` tells where a single part is brought from.
double zone_cost(std::size_t parts, bool from_zone) {
  if (parts == 1) return from_zone ? 0.0823 : 0.0967;
  if (parts == 2) return 0.0722;
  return parts == 3 ? 0.0782 : 0.0;
}

}  // namespace

std::vector<std::size_t> piece_sizes(const Problem& problem, const ConnectionSet& present) {
  std::vector<std::size_t> leader(problem.num_parts());
  std::iota(leader.begin(), leader.end(), std::size_t{0});
  const auto leader_of = [&](std::size_t part) {
    while (leader[part] != part) part = leader[part] = leader[leader[part]];
    return part;
  };
  for_each_connection(present.view(), [&](ConnectionIndex c) {
    leader[leader_of(problem.ends(c)[0])] = leader_of(problem.ends(c)[1]);
  });
  std::vector<std::size_t> parts(leader.size(), 0);
  for (std::size_t part = 0; part < leader.size(); ++part) ++parts[leader_of(part)];
  std::erase(parts, std::size_t{0});
  return parts;
}

SizeRewards::SizeRewards(const Problem& problem, bool prices) : problem_(problem), prices_(prices) {
  add(problem.objective(), 1);
  starts_.assign(problem.num_parts() + 1, false);
  for (const std::size_t parts :
       piece_sizes(problem, ConnectionSet::all(problem.num_connections()))) {
    starts_[parts] = true;
    largest_ = std::max(largest_, parts);
  }
  bool any = false;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    if (problem.ends(c)[0] == problem.ends(c)[1]) continue;
    const Attempts here = attempts_at(problem, c);
    attempts_ = any ? united(attempts_, here) : here;
    any = true;
  }
  some_fixed_ = !problem.spec().base.empty();
  some_stay_ = problem.spec().base.size() > 1;
}

void SizeRewards::add(const Objective& objective, double weight) {
  const ObjectiveParameters& parameters = objective.parameters;
  if (const auto* const sum = std::get_if<WeightedSum>(&parameters)) {
    // A product of weights that is not exact would need a range of its own.
    for (const WeightedObjective& term : sum->terms) {
      if (weight != 1 && term.weight != 1) known_ = false;
      add(term.objective, weight * term.weight);
    }
    return;
  }
  const bool placed = std::ranges::any_of(
      problem_.parts(), [](const Part& part) { return part.position.has_value(); });
  const bool alike = std::ranges::all_of(problem_.parts(), [this](const Part& part) {
    return part.mass == problem_.parts().front().mass;
  });
  // Of several base parts two may come apart without a motion, which costs less than any price.
  if (prices_ && std::holds_alternative<Fuel>(parameters)) {
    known_ = known_ && weight >= 0 && problem_.spec().base.size() < 2;
    priced_.push_back({weight, &parameters});
    return;
  }
  known_ = known_ && ((std::holds_alternative<Fuel>(parameters) && alike) ||
                      std::holds_alternative<PieceCost>(parameters) ||
                      std::holds_alternative<CubesatZone>(parameters) ||
                      std::holds_alternative<CompletionObjective>(parameters) ||
                      (std::holds_alternative<TimeObjective>(parameters) && !placed));
  addends_.push_back({weight, &parameters});
}

double SizeRewards::own(ConnectionIndex connection) const {
  double sum = 0;
  for (const auto& [weight, parameters] : addends_) {
    if (const auto* const cost = std::get_if<PieceCost>(parameters))
      sum = add_up(sum, multiply_up(weight, -cost->operation));
    if (const auto* const completion = std::get_if<CompletionObjective>(parameters))
      sum = add_up(sum, multiply_up(weight, -completion->step));
    if (std::holds_alternative<TimeObjective>(*parameters))
      sum = add_up(sum, multiply_up(weight, -problem_.connections()[connection].duration));
  }
  return all_together(sum, attempts_at(problem_, connection));
}

double SizeRewards::one_cut(std::size_t a, std::size_t b) const {
  double sum = 0;
  for (const auto& [weight, parameters] : addends_) {
    if (const auto* const cost = std::get_if<PieceCost>(parameters))
      sum = add_up(sum, add_up(multiply_up(weight, -cost_of(*cost, a)),
                               multiply_up(weight, -cost_of(*cost, b))));
    if (std::holds_alternative<CubesatZone>(*parameters)) sum = add_up(sum, zone_cut(weight, a, b));
    if (const auto* const completion = std::get_if<CompletionObjective>(parameters))
      sum = add_up(sum, multiply_up(weight, completion->join));
    if (const auto* const time = std::get_if<TimeObjective>(parameters))
      sum = add_up(sum, transfer(weight, time->transfer));
    if (const auto* const fuel = std::get_if<Fuel>(parameters))
      sum = add_up(sum, fuel_cut(weight, *fuel, a, b));
  }
  return sum;
}

double SizeRewards::last(ConnectionIndex connection, bool separates, std::size_t a,
                         std::size_t b) const {
  double sum = 0;
  for (const auto& [weight, parameters] : addends_) {
    if (const auto* const fuel = std::get_if<Fuel>(parameters); fuel != nullptr && separates)
      sum = add_up(sum, fuel_cut(weight, *fuel, a, b));
    if (const auto* const cost = std::get_if<PieceCost>(parameters))
      sum = add_up(sum, multiply_up(weight, cost->completion));
    if (std::holds_alternative<CubesatZone>(*parameters)) sum = add_up(sum, weight);
    if (const auto* const completion = std::get_if<CompletionObjective>(parameters)) {
      if (separates) sum = add_up(sum, multiply_up(weight, completion->join));
      sum = add_up(sum, multiply_up(weight, -completion->step));
      sum = add_up(sum, multiply_up(weight, completion->bonus));
    }
    if (const auto* const time = std::get_if<TimeObjective>(parameters)) {
      sum = add_up(sum, multiply_up(weight, -problem_.connections()[connection].duration));
      if (separates) sum = add_up(sum, transfer(weight, time->transfer));
    }
  }
  return all_together(sum, attempts_at(problem_, connection));
}

// A single part costs less from the zone, where its piece has at most three parts and is not a
// whole piece of the product.
double SizeRewards::zone_cut(double weight, std::size_t a, std::size_t b) const {
  double most = -kInfinity;
  for (const bool from_zone : {false, true}) {
    const std::size_t parts = a + b;
    const bool possible =
        parts >= 4 ? !from_zone : (from_zone ? largest_ > parts : bool{starts_[parts]});
    if (!possible) continue;
    most = std::max(most, add_up(multiply_up(weight, -zone_cost(a, from_zone)),
                                 multiply_up(weight, -zone_cost(b, from_zone))));
  }
  // No piece of the product has so many parts or more: such a cut is never made.
  return most;
}

// The exponential is right to a few units in the last place; the value is moved up by a hundred and
// more of them.
double SizeRewards::propellant(double weight, const Fuel& fuel, double mass) {
  constexpr double kGravity = 9.80665;
  constexpr double kLost = 1e-13;
  const double burnt =
      (2 * fuel.dry_mass + mass) * std::expm1(fuel.delta_v / (fuel.isp * kGravity));
  const double earned = weight * -burnt;
  return add_up(earned, kLost * std::abs(earned));
}

// The smaller side moves, unless a base part says otherwise.
double SizeRewards::fuel_cut(double weight, const Fuel& fuel, std::size_t a, std::size_t b) const {
  double most = some_stay_ ? 0 : -kInfinity;
  for (const std::size_t moved : {a, b}) {
    if (!some_fixed_ && moved != std::min(a, b)) continue;
    const double mass = static_cast<double>(moved) * problem_.parts().front().mass;
    most = std::max(most, propellant(weight, fuel, mass));
  }
  return most;
}

double SizeRewards::price(PartIndex part) const {
  double sum = 0;
  for (const auto& [weight, parameters] : priced_) {
    if (const auto* const fuel = std::get_if<Fuel>(parameters))
      sum = add_up(sum, propellant(weight, *fuel, problem_.parts()[part].mass));
  }
  return all_together(sum, attempts_);
}

// The masses of a group may be added in any order.
double SizeRewards::price_of_group(std::span<const PartIndex> group) const {
  constexpr double kLost = 1e-11;
  double mass = 0;
  double heaviest = 0;
  for (const PartIndex part : group) {
    mass += problem_.parts()[part].mass;
    heaviest = std::max(heaviest, problem_.parts()[part].mass);
  }
  double sum = 0;
  for (const auto& [weight, parameters] : priced_) {
    const auto* const fuel = std::get_if<Fuel>(parameters);
    if (fuel == nullptr) continue;
    const Fuel without_tug{.dry_mass = 0, .delta_v = fuel->delta_v, .isp = fuel->isp};
    sum = add_up(sum, propellant(weight, without_tug, std::max(0.0, mass - heaviest)));
  }
  return std::min(0.0, add_up(sum, kLost * std::abs(sum)));
}

double SizeRewards::transfer(double weight, double seconds) const {
  const double moved = multiply_up(weight, -seconds);
  return some_stay_ ? std::max(0.0, moved) : moved;
}

}  // namespace orasp::detail
