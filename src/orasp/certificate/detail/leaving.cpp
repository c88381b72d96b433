#include "orasp/certificate/detail/leaving.h"

#include <algorithm>

namespace orasp::detail {

Leaving::Leaving(const Problem& problem, std::span<const PartIndex> piece, PartIndex stays)
    : problem_(problem),
      piece_(piece.begin(), piece.end()),
      stays_(stays),
      around_(problem.num_parts()),
      in_piece_(problem.num_parts(), false),
      gone_(problem.num_parts()) {
  for (const PartIndex part : piece_) in_piece_[part] = true;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto [a, b] = problem.ends(c);
    if (a == b || !in_piece_[a]) continue;
    around_[a].push_back(b);
    around_[b].push_back(a);
  }
  for (const PartIndex part : piece_) {
    gone_[part].assign(problem.num_parts(), false);
    gone_[part][part] = true;
  }
  std::vector<std::optional<DirectionIndex>> ways;
  for (const DirectionIndex direction : problem.directions()) ways.emplace_back(direction);
  if (!problem.spec().blocking) ways.emplace_back(std::nullopt);
  for (bool changed = true; changed && possible_;) {
    changed = false;
    for (const PartIndex part : piece_) {
      if (part == stays_) continue;
      std::optional<Set> always;
      for (const auto& way : ways) {
        const std::optional<Set> gone = gone_along(part, way);
        if (!gone) continue;
        if (!always) {
          always = gone;
          continue;
        }
        for (const PartIndex other : piece_) (*always)[other] = (*always)[other] && (*gone)[other];
      }
      if (!always) {
        possible_ = false;
        return;
      }
      changed = changed || *always != gone_[part];
      gone_[part] = *std::move(always);
    }
  }
}

// Who has gone when `part` leaves in that direction; nothing where that would be all.
std::optional<Leaving::Set> Leaving::gone_along(PartIndex part, std::optional<DirectionIndex> way) {
  Set gone = gone_[part];
  if (way) {
    for (const Blocker& blocker : problem_.blockers()[part]) {
      if (in_piece_[blocker.by] && problem_.blocks(blocker, way->value())) gone[blocker.by] = true;
    }
  }
  for (bool more = true; more;) {
    if (gone[stays_]) return std::nullopt;
    const Set before = gone;
    for (const PartIndex other : piece_) {
      if (!before[other]) continue;
      for (const PartIndex third : piece_) gone[third] = gone[third] || gone_[other][third];
    }
    if (gone[stays_]) return std::nullopt;
    take_what_is_loose(gone);
    more = gone != before;
  }
  return gone;
}

// All that no longer hangs together with the part that stays.
void Leaving::take_what_is_loose(Set& gone) {
  Set holds(problem_.num_parts(), false);
  std::vector<PartIndex> reached{stays_};
  holds[stays_] = true;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const PartIndex next : around_[reached[i]]) {
      if (holds[next] || gone[next]) continue;
      holds[next] = true;
      reached.push_back(next);
    }
  }
  for (const PartIndex part : piece_) gone[part] = !holds[part];
}

std::vector<std::vector<PartIndex>> Leaving::groups() const {
  std::vector<std::vector<PartIndex>> groups;
  Set seen(problem_.num_parts(), false);
  if (!possible_) return groups;
  for (const PartIndex part : piece_) {
    if (part == stays_ || seen[part]) continue;
    std::vector<PartIndex> group;
    for (const PartIndex other : piece_) {
      if (other == stays_ || !together(part, other)) continue;
      group.push_back(other);
      seen[other] = true;
    }
    if (group.size() > 1) groups.push_back(std::move(group));
  }
  return groups;
}

}  // namespace orasp::detail
