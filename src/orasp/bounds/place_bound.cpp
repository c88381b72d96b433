#include "orasp/bounds/place_bound.h"

#include <algorithm>
#include <utility>

#include "orasp/model/tolerance.h"

namespace orasp {

PlaceBound::PlaceBound(const TransitionSystem& system, PlacePrices::Terms terms)
    : PlaceBound(system, std::make_shared<const PlacePrices>(system, terms)) {}

PlaceBound::PlaceBound(const TransitionSystem& system, std::shared_ptr<const PlacePrices> prices)
    : prices_(std::move(prices)),
      completes_first_(system.completes_first()),
      num_steps_(system.num_steps()),
      takes_before_(system.num_connections(), 0.0),
      slope_before_(system.num_connections(), 0.0) {}

PlaceBound::PairCosts PlaceBound::costs(const PlacePrices::Pairs& pairs, SetView open,
                                        std::span<const double> takes) {
  PairCosts costs;
  for (const PlacePrices::Pair& pair : pairs.all) {
    if (!contains(open, pair.second)) continue;
    if (contains(open, pair.first)) {
      costs.both += pair.price * (takes.empty() ? 1 : takes[pair.first]);
    } else {
      costs.second += pair.price;
    }
  }
  return costs;
}

double PlaceBound::of_lines(const PlacePrices::Lines& lines, SetView open) {
  time_ = 0;
  for (const ConnectionIndex c : lines.order) {
    if (!contains(open, c)) time_ += lines.takes[c];
  }
  double sum = 0;
  double takes = 0;
  double slopes = 0;
  for (const ConnectionIndex c : lines.order) {
    if (!contains(open, c)) continue;
    takes_before_[c] = takes;
    slope_before_[c] = slopes;
    sum += lines.at[c] + lines.slope[c] * (time_ + takes);
    takes += lines.takes[c];
    slopes += lines.slope[c];
  }
  costs_ = costs(lines.pairs, open, lines.takes);
  return sum - costs_.both - costs_.second * time_;
}

double PlaceBound::of_places(SetView open) const {
  const PlacePrices::Places& places = prices_->places();
  double sum = 0;
  std::size_t left = 0;
  for_each_connection(open, [&](ConnectionIndex c) {
    sum += places.of_connection[c];
    ++left;
  });
  const std::size_t done = num_steps_ - left;
  const PairCosts paid = costs(places.pairs, open, {});
  return sum + places.of_rest[done] - paid.both - paid.second * static_cast<double>(done);
}

double PlaceBound::operator()(SetView open) {
  if (!known()) return kInfinity;
  const std::size_t left = count(open);
  if (left == 0) return 0;
  double sum = completes_later(left) ? prices_->last_surplus() : 0;
  if (prices_->by_place().used) sum += of_lines(prices_->by_place(), open);
  if (prices_->by_seconds().used) sum += of_lines(prices_->by_seconds(), open);
  if (prices_->places().used) sum += of_places(open);
  return sum;
}

void PlaceBound::add_lines_of_successors(const PlacePrices::Lines& lines, SetView open,
                                         std::span<const Action> actions,
                                         std::span<double> bounds) {
  const double here = of_lines(lines, open);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    const double takes = lines.takes[c];
    PairCosts then = costs_;
    for (const std::uint32_t number : lines.pairs.from[c]) {
      const PlacePrices::Pair& pair = lines.pairs.all[number];
      if (!contains(open, pair.second)) continue;
      then.both -= pair.price * takes;
      then.second += pair.price;
    }
    for (const std::uint32_t number : lines.pairs.to[c]) {
      const PlacePrices::Pair& pair = lines.pairs.all[number];
      if (contains(open, pair.first)) {
        then.both -= pair.price * lines.takes[pair.first];
      } else {
        then.second -= pair.price;
      }
    }
    // What stood before c comes later by what c takes, what stood after it when it did.
    bounds[i] += here - lines.at[c] - lines.slope[c] * (time_ + takes_before_[c]) +
                 takes * slope_before_[c] + (costs_.both - then.both) + costs_.second * time_ -
                 then.second * (time_ + takes);
  }
}

void PlaceBound::add_places_of_successors(SetView open, std::span<const Action> actions,
                                          std::span<double> bounds) const {
  const PlacePrices::Places& places = prices_->places();
  const std::size_t done = num_steps_ - count(open);
  const auto time = static_cast<double>(done);
  const PairCosts now = costs(places.pairs, open, {});
  double here = places.of_rest[done + 1];
  for_each_connection(open, [&](ConnectionIndex c) { here += places.of_connection[c]; });
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    PairCosts then = now;
    for (const std::uint32_t number : places.pairs.from[c]) {
      const PlacePrices::Pair& pair = places.pairs.all[number];
      if (!contains(open, pair.second)) continue;
      then.both -= pair.price;
      then.second += pair.price;
    }
    for (const std::uint32_t number : places.pairs.to[c]) {
      const PlacePrices::Pair& pair = places.pairs.all[number];
      (contains(open, pair.first) ? then.both : then.second) -= pair.price;
    }
    bounds[i] += here - places.of_connection[c] - then.both - then.second * (time + 1);
  }
}

void PlaceBound::of_successors(SetView open, double here, std::span<const Action> actions,
                               std::span<double> bounds) {
  static_cast<void>(here);
  const std::size_t left = count(open);
  if (!known() || left <= 1) {
    std::ranges::fill(bounds, known() ? 0.0 : kInfinity);
    return;
  }
  std::ranges::fill(bounds, completes_first_ ? 0.0 : prices_->last_surplus());
  if (prices_->by_place().used) add_lines_of_successors(prices_->by_place(), open, actions, bounds);
  if (prices_->by_seconds().used)
    add_lines_of_successors(prices_->by_seconds(), open, actions, bounds);
  if (prices_->places().used) add_places_of_successors(open, actions, bounds);
}

}  // namespace orasp
