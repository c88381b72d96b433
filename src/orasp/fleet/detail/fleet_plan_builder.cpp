#include "orasp/fleet/detail/fleet_plan_builder.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace orasp::detail {
namespace {

/// The first site at the point of `site` that is not in use; it becomes used.
PlaceIndex take_site(const FleetProblem& fleet, PlaceIndex site, std::vector<bool>& used) {
  for (PlaceIndex other = 1; other < fleet.num_places(); ++other) {
    if (used[other] || fleet.place(other) != fleet.place(site)) continue;
    used[other] = true;
    return other;
  }
  assert(false);
  return site;
}

}  // namespace

template <class Parts>
std::vector<MatchingSplit<Parts>> matching_splits(
    FleetExpander<Parts>& expander, Parts piece, typename FleetExpander<Parts>::Locks locks,
    std::span<const std::type_identity_t<Parts>> after) {
  std::vector<Parts> wanted;
  for (const Parts& block : after) {
    if ((block & piece) != 0) wanted.push_back(block);
  }
  std::vector<MatchingSplit<Parts>> found;
  std::vector<Motion> motions(expander.fleet().num_parts(), kStay);
  const auto try_staying = [&](Parts stays) {
    std::vector<Parts> moved;
    FleetSplit<Parts> split{.stays = stays, .freed = piece, .moved = {}, .held = 0};
    for (const Parts& block : wanted) {
      split.freed &= ~block;
      if (block == stays) continue;
      moved.push_back(block);
      split.held += size_of(block);
    }
    split.moved = moved;
    if (split.robots() <= expander.fleet().robots() &&
        expander.motions(piece, locks, split, motions))
      found.push_back({stays, split.robots()});
  };
  for (const Parts& block : wanted) try_staying(block);
  try_staying(0);
  return found;
}

template <class Parts>
FleetPlan build_fleet_plan(FleetExpander<Parts>& expander,
                           const std::vector<std::vector<PlacedPiece<Parts>>>& states) {
  const FleetProblem& fleet = expander.fleet();
  std::vector<PlacedPiece<Parts>> now = states.front();
  std::vector<bool> used(fleet.num_places(), false);
  std::vector<PlaceIndex> places(fleet.num_parts(), kDepot);
  for (PlacedPiece<Parts>& piece : now) {
    piece.site = take_site(fleet, piece.site, used);
    for_each_part(piece.parts, [&](std::size_t part) { places[part] = piece.site; });
  }
  FleetPlan plan{.start = places, .steps = {}};
  FleetState state = fleet_start(fleet, places);

  std::vector<Motion> motions(fleet.num_parts());
  for (std::size_t t = 1; t < states.size(); ++t) {
    std::vector<Parts> before;
    std::vector<Parts> after;
    for (const PlacedPiece<Parts>& piece : now) before.push_back(piece.parts);
    for (const PlacedPiece<Parts>& piece : states[t]) after.push_back(piece.parts);
    const auto target = [&](Parts block) {
      return std::ranges::find(states[t], block, &PlacedPiece<Parts>::parts)->site;
    };
    std::ranges::fill(motions, kStay);
    std::vector<PlacedPiece<Parts>> moved;
    std::vector<PlacedPiece<Parts>> next;
    used.assign(used.size(), false);
    for (const PlacedPiece<Parts>& piece : now) {
      const auto locks = expander.locks(before, piece.parts);
      const MatchingSplit<Parts>* chosen = nullptr;
      const std::vector<MatchingSplit<Parts>> ways =
          matching_splits(expander, piece.parts, locks, after);
      for (const MatchingSplit<Parts>& way : ways) {
        const bool fits =
            way.stays == 0 || fleet.place(target(way.stays)) == fleet.place(piece.site);
        if (fits && (chosen == nullptr || way.robots < chosen->robots)) chosen = &way;
      }
      assert(chosen != nullptr);
      FleetSplit<Parts> split{.stays = chosen->stays, .freed = piece.parts, .moved = {}, .held = 0};
      std::vector<Parts> blocks;
      for (const Parts& block : after) {
        if ((block & piece.parts) == 0) continue;
        split.freed &= ~block;
        if (block == chosen->stays) continue;
        blocks.push_back(block);
        moved.push_back({block, target(block)});
      }
      split.moved = blocks;
      [[maybe_unused]] const bool possible = expander.motions(piece.parts, locks, split, motions);
      assert(possible);
      for_each_part(split.freed, [&](std::size_t part) { places[part] = kDepot; });
      if (chosen->stays != 0) {
        next.push_back({chosen->stays, piece.site});
        used[piece.site] = true;
      }
    }
    for (PlacedPiece<Parts>& piece : moved) {
      piece.site = take_site(fleet, piece.site, used);
      for_each_part(piece.parts, [&](std::size_t part) { places[part] = piece.site; });
      next.push_back(piece);
    }
    plan.steps.push_back(fleet_step(fleet, state, motions, places));
    now = std::move(next);
  }
  return plan;
}

#define ORASP_PLAN_BUILDER(Parts)                                                         \
  template std::vector<MatchingSplit<Parts>> matching_splits<Parts>(                      \
      FleetExpander<Parts>&, Parts, FleetExpander<Parts>::Locks, std::span<const Parts>); \
  template FleetPlan build_fleet_plan<Parts>(FleetExpander<Parts>&,                       \
                                             const std::vector<std::vector<PlacedPiece<Parts>>>&)
ORASP_PLAN_BUILDER(PartsIn<1>);
ORASP_PLAN_BUILDER(PartsIn<2>);
ORASP_PLAN_BUILDER(PartsIn<4>);
ORASP_PLAN_BUILDER(PartsIn<16>);

}  // namespace orasp::detail
