#include "orasp/bounds/companion_bound.h"

#include <algorithm>

#include "orasp/model/detail/rules.h"

namespace orasp {
namespace {

/// About how many words all Departures of a piece may look at: half a second.
constexpr double kMostWork = 5e8;

/// What a kilogram costs that moves, where nothing else does but a fixed amount; 0 elsewhere.
double cost_of_mass(const detail::Rules& rules) {
  double sum = 0;
  for (const WeightedTerm& addend : rules.terms) {
    if (addend.weight == 0) continue;
    const double cost = addend.term->cost_of_mass(addend.weight);
    if (cost <= 0) return 0;
    sum += cost;
  }
  return sum;
}

}  // namespace

CompanionBound::CompanionBound(const TransitionSystem& system) : problem_(system.problem()) {
  const detail::Rules& rules = system.rules();
  if (system.wide() || !system.takes_apart() || !system.kept().empty()) return;
  if (!rules.blocking || problem_.num_parts() > kMostParts) return;
  cost_of_mass_ = cost_of_mass(rules);
  if (cost_of_mass_ <= 0) return;
  Expander expander(system);
  gains_.resize(problem_.num_parts());
  for (PartIndex part = 0; part < gains_.size(); ++part)
    gains_[part] = expander.greatest_gain_of_moving({&part, 1});
  world_ = std::make_shared<const Departures::World>(system);
  most_ = 0;
  rules.graph.for_each_piece(
      system.present(system.start().view()).view(),
      [&](std::span<const PartIndex> piece) { most_ += of_piece(piece).most; });
}

CompanionBound::Best CompanionBound::of_piece(std::span<const PartIndex> piece) const {
  Best best;
  double sum = 0;
  std::vector<PartIndex> may_stay;
  std::size_t fixed = 0;
  for (const PartIndex part : piece) {
    if (problem_.in_base(part)) {
      ++fixed;
      may_stay.assign(1, part);
      continue;
    }
    sum += gains_[part];
    if (fixed == 0) may_stay.push_back(part);
  }
  if (fixed > 1 || piece.size() < 2) {
    best.most = fixed > 0 ? sum : 0;
    return best;
  }
  // Those that cost most to move stay first.
  std::ranges::stable_sort(may_stay, {}, [&](PartIndex part) { return gains_[part]; });
  best.most = -kInfinity;
  double left = kMostWork;
  for (const PartIndex stays : may_stay) {
    const double others = fixed > 0 ? sum : sum - gains_[stays];
    if (others <= best.most) break;
    left -= work_of_a_look();
    if (left < 0) {
      // Those that are not looked at leave no more to others than this one.
      best.most = others;
      best.departures.reset();
      return best;
    }
    Departures departures(world_, piece, stays);
    if (!departures.possible()) continue;
    const double most = others - cost_of_companions(departures);
    if (most <= best.most) continue;
    best.most = most;
    best.departures = std::move(departures);
  }
  // Whether there is a plan at all is for others to say.
  if (!best.departures) best.most = fixed > 0 ? sum : sum - gains_[may_stay.front()];
  return best;
}

double CompanionBound::work_of_a_look() const {
  const auto parts = static_cast<double>(gains_.size());
  return parts * parts * static_cast<double>(world_->ways() * world_->words());
}

double CompanionBound::cost_of_moving_together(std::span<const PartIndex> group) const {
  double sum = 0;
  double greatest = 0;
  for (const PartIndex part : group) {
    sum += problem_.parts()[part].mass;
    greatest = std::max(greatest, problem_.parts()[part].mass);
  }
  return cost_of_mass_ * (sum - greatest);
}

double CompanionBound::cost_of_companions(const Departures& departures) const {
  double sum = 0;
  for (const std::vector<PartIndex>& group : departures.groups())
    sum += cost_of_moving_together(group);
  return sum;
}

}  // namespace orasp
