#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "orasp/bounds/place_prices.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// Improves plans whose rewards depend on when steps come, by moving steps about.
///
/// Idea.       A step, together with those right after it that wait for it, goes on to a later
///             place (or, with those that it waits for, to an earlier one), or two steps change
///             places, where that earns more by what is known of each step at each place
///             (PlacePrices::Values) and precedence allows it. What comes of it is walked through
///             with the rules: it counts if it is legal and earns more. Where rules judge steps
///             beyond plain precedence, each move is walked through, from its first step to its
///             last. Once no move helps, a few steps are moved at random and all begins anew from
///             there, on and on.
/// Reference.  Lin and Kernighan (1973) for exchanges as long as they help; Lourenço, Martin and
///             Stützle (2003) for beginning anew close by.
/// Guarantee.  The plan is legal and none that earns less than the one given.
/// Cost.       O(connections^2) for all moves of a plan; at most `rounds` times. Where each move is
///             walked through, some ten thousand steps of the rules.
class OrderSearch {
 public:
  OrderSearch(const TransitionSystem& system, std::shared_ptr<const PlacePrices> prices);
  ~OrderSearch();
  OrderSearch(const OrderSearch&) = delete;
  OrderSearch& operator=(const OrderSearch&) = delete;

  /// Improves the plan of `result`, or finds one if it holds none. Returns whether it did.
  bool improve(const Budget& budget, std::uint64_t rounds, Result& result);

 private:
  class Order;
  class Walk;
  bool improve_unguarded(const Budget& budget, std::uint64_t rounds, Result& result);
  bool improve_guarded(const Budget& budget, std::uint64_t rounds, Result& result);
  [[nodiscard]] std::vector<std::uint32_t> numbered(const Result& result) const;
  [[nodiscard]] std::vector<ConnectionIndex> named(const std::vector<std::uint32_t>& steps) const;
  [[nodiscard]] bool try_order(const std::vector<ConnectionIndex>& order, Result& result);

  const TransitionSystem& system_;
  std::shared_ptr<const PlacePrices> prices_;
  Expander expander_;
  bool guarded_;        ///< rules judge steps beyond plain precedence
  bool begun_ = false;  ///< the order of the prices was tried
};

}  // namespace orasp::detail
