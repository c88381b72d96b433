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

std::vector<MatchingSplit> matching_splits(FleetExpander& expander, PartMask piece,
                                           FleetExpander::Locks locks,
                                           std::span<const PartMask> after) {
  std::vector<PartMask> wanted;
  for (const PartMask block : after) {
    if ((block & piece) != 0) wanted.push_back(block);
  }
  std::vector<MatchingSplit> found;
  std::vector<Motion> motions(expander.fleet().num_parts(), kStay);
  const auto try_staying = [&](PartMask stays) {
    std::vector<PartMask> moved;
    FleetSplit split{.stays = stays, .freed = piece, .moved = {}, .held = 0};
    for (const PartMask block : wanted) {
      split.freed &= ~block;
      if (block == stays) continue;
      moved.push_back(block);
      split.held += static_cast<std::size_t>(std::popcount(block));
    }
    split.moved = moved;
    if (split.robots() <= expander.fleet().robots() &&
        expander.motions(piece, locks, split, motions))
      found.push_back({stays, split.robots()});
  };
  for (const PartMask block : wanted) try_staying(block);
  try_staying(0);
  return found;
}

FleetPlan build_fleet_plan(FleetExpander& expander,
                           const std::vector<std::vector<PlacedPiece>>& states) {
  const FleetProblem& fleet = expander.fleet();
  std::vector<PlacedPiece> now = states.front();
  std::vector<bool> used(fleet.num_places(), false);
  std::vector<PlaceIndex> places(fleet.num_parts(), kDepot);
  for (PlacedPiece& piece : now) {
    piece.site = take_site(fleet, piece.site, used);
    for_each_part(piece.parts, [&](std::size_t part) { places[part] = piece.site; });
  }
  FleetPlan plan{.start = places, .steps = {}};
  FleetState state = fleet_start(fleet, places);

  std::vector<Motion> motions(fleet.num_parts());
  for (std::size_t t = 1; t < states.size(); ++t) {
    std::vector<PartMask> before;
    std::vector<PartMask> after;
    for (const PlacedPiece& piece : now) before.push_back(piece.parts);
    for (const PlacedPiece& piece : states[t]) after.push_back(piece.parts);
    const auto target = [&](PartMask block) {
      return std::ranges::find(states[t], block, &PlacedPiece::parts)->site;
    };
    std::ranges::fill(motions, kStay);
    std::vector<PlacedPiece> moved;
    std::vector<PlacedPiece> next;
    used.assign(used.size(), false);
    for (const PlacedPiece& piece : now) {
      const auto locks = expander.locks(before, piece.parts);
      const MatchingSplit* chosen = nullptr;
      const std::vector<MatchingSplit> ways = matching_splits(expander, piece.parts, locks, after);
      for (const MatchingSplit& way : ways) {
        const bool fits =
            way.stays == 0 || fleet.place(target(way.stays)) == fleet.place(piece.site);
        if (fits && (chosen == nullptr || way.robots < chosen->robots)) chosen = &way;
      }
      assert(chosen != nullptr);
      FleetSplit split{.stays = chosen->stays, .freed = piece.parts, .moved = {}, .held = 0};
      std::vector<PartMask> blocks;
      for (const PartMask block : after) {
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
    for (PlacedPiece& piece : moved) {
      piece.site = take_site(fleet, piece.site, used);
      for_each_part(piece.parts, [&](std::size_t part) { places[part] = piece.site; });
      next.push_back(piece);
    }
    plan.steps.push_back(fleet_step(fleet, state, motions, places));
    now = std::move(next);
  }
  return plan;
}

}  // namespace orasp::detail
