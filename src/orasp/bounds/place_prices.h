#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// What handling each connection at each place of the order can earn, and prices that bound what
/// any order earns. Rewards that depend on when a step comes are of two kinds:
///
/// Lines.   The reward of c lies at or below a line in time: a + s t, where t is the number of
///          steps before (`before`, `after`) or how long they took (`elapsed`). Without precedence
///          the best order is by s over the time that the step takes: W. E. Smith (1956).
/// Places.  Anything else: a table of the greatest reward of c at place k, and the best assignment
///          of connections to places, with its dual prices u(c) + v(k) >= reward(c, k): Kuhn
///          (1955), Jonker and Volgenant (1987). A place is possible for c if as many others come
///          before it as precedence asks for, and after it.
///
/// Precedence is paid for by prices as well (Fisher 1981; van de Velde 1995): where i must come
/// before j, t(j) - t(i) - takes(i) >= 0, so a price times that may be added to what a plan earns,
/// and the plan of the sum that pays no heed to precedence bounds all plans that do. The prices are
/// found by subgradients (Held and Karp 1971; Polyak 1969), and any prices that are not negative
/// give a bound.
///
/// Immutable, and shared by the bounds of all threads (PlaceBound).
class PlacePrices {
 public:
  /// Which terms of the objective are priced.
  enum class Terms { All, NotOfPiecesAlone };
  /// With more connections a table of places is not made; each connection then has one price.
  static constexpr std::size_t kMostPlaces = 400;

  PlacePrices(const TransitionSystem& system, Terms terms);

  [[nodiscard]] bool known() const { return known_; }
  /// The best bound of the start; at most that of the prices.
  [[nodiscard]] double most_of_start() const { return most_of_start_; }
  /// An order that obeys precedence and earns much by the prices; empty where there is none. Other
  /// rules may forbid it.
  [[nodiscard]] const std::vector<ConnectionIndex>& order() const { return order_; }

  /// A price of one connection before another.
  struct Pair {
    std::uint32_t first;
    std::uint32_t second;
    double price;
  };
  /// What pairs of connections cost, for a state: as long as both are open price times `takes` of
  /// the first, then, as long as the second is, price times the time that has passed.
  struct Pairs {
    std::vector<Pair> all;
    /// By connection: the pairs of which it is the first, and the second.
    std::vector<std::vector<std::uint32_t>> from;
    std::vector<std::vector<std::uint32_t>> to;
  };
  /// Rewards below lines in the same time.
  struct Lines {
    bool used = false;
    std::vector<double> at;     ///< by connection, with what its earliest and latest time cost
    std::vector<double> slope;  ///< by connection, with the prices of its pairs
    std::vector<double> takes;  ///< by connection: how far time goes on in its step
    std::vector<ConnectionIndex> order;  ///< all of the start, by slope over `takes`
    Pairs pairs;
  };
  /// The duals of an assignment to places.
  struct Places {
    bool used = false;
    std::vector<double> of_connection;
    std::vector<double> of_rest;  ///< by steps done: the sum of the prices of all places to come
    Pairs pairs;
  };
  /// What steps earn at most when they come, without prices. By the number of a step in `steps`.
  struct Values {
    std::vector<ConnectionIndex> steps;  ///< ascending
    /// Lines in the number of steps before, and in seconds; each empty where there is none.
    std::vector<double> by_place;
    std::vector<double> by_seconds;
    std::vector<double> seconds;
    /// By step and place; empty where there are lines alone.
    std::vector<double> table;
    /// Whether the table is all that a step earns, and not only the most.
    bool exact = false;
    /// By step and place: what a plan falls short of the bound at least that has the step there.
    std::vector<double> slack;
    /// By step: those that must come before it, those that must come after it.
    std::vector<std::vector<std::uint32_t>> waits_for;
    std::vector<std::vector<std::uint32_t>> next;
  };
  [[nodiscard]] const Values& values() const { return values_; }
  [[nodiscard]] const Lines& by_place() const { return by_place_; }
  [[nodiscard]] const Lines& by_seconds() const { return by_seconds_; }
  [[nodiscard]] const Places& places() const { return places_; }
  /// The most that the step that completes earns above its line.
  [[nodiscard]] double last_surplus() const { return last_surplus_; }

 private:
  friend class PlacePricing;
  bool known_ = false;
  double most_of_start_ = 0;
  double last_surplus_ = 0;
  std::vector<ConnectionIndex> order_;
  Values values_;
  Lines by_place_;
  Lines by_seconds_;
  Places places_;
};

}  // namespace orasp
