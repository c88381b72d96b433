#include "orasp/bounds/partings.h"

#include <algorithm>

#include "orasp/model/detail/rules.h"

namespace orasp {

std::optional<Partings> Partings::of(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  const detail::Rules& rules = system.rules();
  if (system.wide() || !system.takes_apart() || !system.kept().empty() || !rules.blocking)
    return std::nullopt;
  // Blocking is not asked for between two base parts.
  if (problem.spec().base.size() > 1) return std::nullopt;
  const auto parts = static_cast<double>(problem.num_parts());
  const auto ways = static_cast<double>(problem.directions().size());
  if (parts * parts * parts * ways * (1 + parts / 64) > kMostWork) return std::nullopt;
  return Partings(system);
}

Partings::Partings(const TransitionSystem& system)
    : world_(std::make_shared<const Departures::World>(system)),
      piece_of_(system.problem().num_parts(), 0),
      from_(system.problem().num_parts()) {
  system.rules().graph.for_each_piece(system.present(system.start().view()).view(),
                                      [&](std::span<const PartIndex> piece) {
                                        for (const PartIndex part : piece)
                                          piece_of_[part] = pieces_.size();
                                        pieces_.emplace_back(piece.begin(), piece.end());
                                      });
  for (const std::vector<PartIndex>& piece : pieces_) {
    for (const PartIndex stays : piece) {
      Departures departures(world_, piece, stays);
      if (departures.possible()) from_[stays] = std::move(departures);
    }
  }
  for (PartIndex part = 0; part < piece_of_.size(); ++part) last_.push_back(part);
}

bool Partings::may_leave(std::span<const PartIndex> set, std::size_t parts) {
  const auto leaves = [&](PartIndex stays) {
    if (std::ranges::find(set, stays) != set.end()) return false;
    return !from_[stays] || from_[stays]->may_leave_more(set, parts);
  };
  PartIndex& last = last_[set.front()];
  if (piece_of_[last] == piece_of_[set.front()] && leaves(last)) return true;
  for (const PartIndex stays : pieces_[piece_of_[set.front()]]) {
    if (!leaves(stays)) continue;
    last = stays;
    return true;
  }
  return false;
}

}  // namespace orasp
