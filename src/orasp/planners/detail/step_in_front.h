#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "orasp/bounds/place_prices.h"
#include "orasp/model/detail/connectivity.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/feasibility.h"

namespace orasp::detail {

/// Finds states from which one step alone need be followed, where what a step earns is told by when
/// it comes.
///
/// Idea.       Let c be a legal step that does no harm (harmless_steps), and p a plan from here
///             that earns more than one known already. Put c in front: p stays legal, c comes at
///             once instead of at its place m, and all before m come one place later. If that never
///             earns less, whatever p is, no other step need be looked at. Which places the steps
///             of p may have is told by the slack of the assignment: one that costs more than a
///             plan may fall short of the bound is none of them.
/// Guarantee.  If there is a plan that earns more than the one known, there is one that begins so
///             and earns no less.
/// Cost.       O(open connections * places to come) a state, and a look at its pieces.
class StepInFront {
 public:
  /// Whether anything can be said: a table of places that is exact, nothing in the way of single
  /// steps (TransitionSystem::ordered), and steps that take connections away.
  [[nodiscard]] static bool applies(const TransitionSystem& system, const PlacePrices& prices);

  StepInFront(const TransitionSystem& system, std::shared_ptr<const PlacePrices> prices);

  /// `room`: how much what the state promises is above the plan that is known.
  [[nodiscard]] std::optional<ConnectionIndex> find(SetView open, std::span<const Action> legal,
                                                    double room);

 private:
  [[nodiscard]] bool harmless(ConnectionIndex c) const;

  const TransitionSystem& system_;
  std::shared_ptr<const PlacePrices> prices_;
  Harmless kind_;
  AssemblyGraph graph_;
  Connectivity connectivity_;
  std::vector<std::uint32_t> step_of_;  ///< by connection: its number in PlacePrices::Values
  double tolerance_;
  std::vector<std::uint32_t> open_steps_;
  std::vector<ConnectionIndex> candidates_;
};

}  // namespace orasp::detail
