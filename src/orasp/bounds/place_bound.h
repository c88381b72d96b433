#pragma once

#include <memory>
#include <span>
#include <vector>

#include "orasp/bounds/bound.h"
#include "orasp/bounds/place_prices.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// A bound for objectives that depend on when a step comes: `indexed`, and formulas with `before`,
/// `after`, `elapsed` or `subassemblies`. See PlacePrices.
///
/// For a state with the open connections O at which time T has passed, lines a + s t and prices p
/// of pairs (i before j):
///
///     h = sum over O of a(c)  +  the most that any order of O makes of sum s(c) t(c), from T on
///         - sum over pairs with both open of p takes(i)
///         - sum over pairs with j alone open of p T
///
/// and with places: sum over O of u(c) + sum of v(k) over the places to come, less the same.
///
/// Admissible. Each pair adds p (t(j) - t(i) - takes(i)) >= 0 to what a plan earns, or, once i is
///             done, p (t(j) - T) >= 0; the rest bounds every order, legal or not.
/// Consistent. A legal step of c at T earns at most a(c) + s'(c) T, s' without prices, or u(c) +
///             v(k) without. The order that begins with c is one of those over which the maximum
///             goes. All pairs that end in c have their first done, so that T was paid for them;
///             those that begin in c go over from takes(c) to T + takes(c), as its slope says; and
///             for all other pairs T only grows.
/// Limit.      The bound is infinite where the reward of some connection has no greatest value:
///             functions without a range, formulas that interval arithmetic does not bound.
/// Cost.       Once: some thousand sorts, or hundreds of assignments, O(connections^3) each. A
///             state: O(connections + pairs); a step from there O(pairs of its connection).
class PlaceBound final : public Bound {
 public:
  PlaceBound(const TransitionSystem& system, PlacePrices::Terms terms);
  /// With prices that are known already.
  PlaceBound(const TransitionSystem& system, std::shared_ptr<const PlacePrices> prices);

  [[nodiscard]] bool known() const override { return prices_->known(); }
  [[nodiscard]] double operator()(SetView open) override;
  void of_successors(SetView open, double here, std::span<const Action> actions,
                     std::span<double> bounds) override;
  [[nodiscard]] const std::shared_ptr<const PlacePrices>& prices() const { return prices_; }

 private:
  /// What the pairs of a state cost.
  struct PairCosts {
    double both = 0;    ///< price times `takes` of the first, where both are open
    double second = 0;  ///< price where the second alone is
  };
  [[nodiscard]] static PairCosts costs(const PlacePrices::Pairs& pairs, SetView open,
                                       std::span<const double> takes);
  /// The bound of some lines in the state, and in before_ what stands before each connection.
  [[nodiscard]] double of_lines(const PlacePrices::Lines& lines, SetView open);
  [[nodiscard]] double of_places(SetView open) const;
  void add_lines_of_successors(const PlacePrices::Lines& lines, SetView open,
                               std::span<const Action> actions, std::span<double> bounds);
  void add_places_of_successors(SetView open, std::span<const Action> actions,
                                std::span<double> bounds) const;
  [[nodiscard]] bool completes_later(std::size_t open) const {
    return !completes_first_ || open == num_steps_;
  }

  std::shared_ptr<const PlacePrices> prices_;
  bool completes_first_;
  std::size_t num_steps_;
  // Scratch, of the last state that of_lines saw.
  double time_ = 0;
  PairCosts costs_;
  std::vector<double> takes_before_;  ///< by connection: what comes before it in the best order
  std::vector<double> slope_before_;  ///< and the slopes of that
};

}  // namespace orasp
