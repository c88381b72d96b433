#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "orasp/fleet/fleet_expander.h"

namespace orasp::detail {

/// A subassembly and the site at which it stands.
template <class Parts>
struct PlacedPiece {
  Parts parts = 0;
  PlaceIndex site = 0;

  friend bool operator==(const PlacedPiece&, const PlacedPiece&) = default;
};

/// One way in which a subassembly becomes certain blocks: which of them stays (0: none) and the
/// robots that takes.
template <class Parts>
struct MatchingSplit {
  Parts stays = 0;
  std::size_t robots = 0;
};

/// The ways in which `piece` becomes exactly the blocks of `after` within it; the others of its
/// parts are freed.
template <class Parts>
[[nodiscard]] std::vector<MatchingSplit<Parts>> matching_splits(
    FleetExpander<Parts>& expander, Parts piece, typename FleetExpander<Parts>::Locks locks,
    std::span<const std::type_identity_t<Parts>> after);

/// The plan that leads through these states, the start first, the empty one last. Sites at the same
/// point are taken for one another where needed, so a state may name the same site twice if another
/// lies at its point. Each step must be possible with the robots there are.
template <class Parts>
[[nodiscard]] FleetPlan build_fleet_plan(
    FleetExpander<Parts>& expander, const std::vector<std::vector<PlacedPiece<Parts>>>& states);

}  // namespace orasp::detail
