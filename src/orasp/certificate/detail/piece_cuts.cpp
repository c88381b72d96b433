#include "orasp/certificate/detail/piece_cuts.h"

#include <algorithm>

namespace orasp::detail {

PieceCuts::PieceCuts(const Problem& problem)
    : problem_(problem),
      removals_(problem),
      around_(problem.num_parts()),
      before_(problem.num_connections()),
      in_piece_(problem.num_parts(), false),
      in_side_(problem.num_parts(), false),
      excluded_(problem.num_parts(), false),
      in_component_(problem.num_parts(), false),
      met_(problem.num_parts(), false),
      gone_(problem.num_connections(), false) {
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto [a, b] = problem.ends(c);
    if (a == b) continue;
    around_[a].push_back(c);
    around_[b].push_back(c);
  }
  std::vector<std::vector<ConnectionIndex>> after(problem.num_connections());
  for (const PrecedenceClause& clause : problem.precedence()) {
    auto& list = after[clause.connection];
    list.insert(list.end(), clause.after.begin(), clause.after.end());
    some_before_ = some_before_ || !clause.after.empty();
  }
  // What must be gone before what must be gone before it, must be gone before it.
  for (ConnectionIndex c = 0; some_before_ && c < problem.num_connections(); ++c) {
    std::vector<bool> seen(problem.num_connections(), false);
    std::vector<ConnectionIndex>& all = before_[c];
    const auto add = [&](ConnectionIndex of) {
      for (const ConnectionIndex other : after[of]) {
        if (seen[other]) continue;
        seen[other] = true;
        all.push_back(other);
      }
    };
    add(c);
    for (std::size_t i = 0; i < all.size(); ++i) add(all[i]);
  }
}

std::vector<PieceCuts::Side> PieceCuts::pieces_of(const ConnectionSet& present) const {
  std::vector<bool> seen(problem_.num_parts(), false);
  std::vector<Side> pieces;
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    if (seen[part]) continue;
    seen[part] = true;
    Side piece{part};
    for (std::size_t i = 0; i < piece.size(); ++i) {
      for (const ConnectionIndex c : around_[piece[i]]) {
        if (!present.contains(c)) continue;
        for (const PartIndex end : problem_.ends(c)) {
          if (seen[end]) continue;
          seen[end] = true;
          piece.push_back(end);
        }
      }
    }
    if (piece.size() < 2) continue;
    std::ranges::sort(piece);
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

// How many parts of the side, or of the rest, hang together with `from`.
std::size_t PieceCuts::reach(PartIndex from, bool among_side, bool without_gone) {
  queue_.assign(1, from);
  met_[from] = true;
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    for (const ConnectionIndex c : around_[queue_[i]]) {
      if (without_gone && gone_[c]) continue;
      for (const PartIndex end : problem_.ends(c)) {
        if (met_[end] || !in_piece_[end] || in_side_[end] != among_side) continue;
        met_[end] = true;
        queue_.push_back(end);
      }
    }
  }
  for (const PartIndex part : queue_) met_[part] = false;
  return queue_.size();
}

bool PieceCuts::for_each(std::span<const PartIndex> piece, const std::vector<bool>& wanted,
                         std::uint64_t most,
                         const std::function<bool(const Side&, const Side&)>& offer) {
  piece_.assign(piece.begin(), piece.end());
  for (const PartIndex part : piece_) in_piece_[part] = true;
  wanted_ = &wanted;
  offer_ = &offer;
  most_ = most;
  std::size_t largest = 0;
  for (std::size_t n = 1; n <= piece_.size() / 2; ++n) {
    if (wanted[n]) largest = n;
  }
  // Each connected set once: by its first part, all earlier ones being left out.
  bool all = true;
  for (std::size_t i = 0; all && largest > 0 && i < piece_.size(); ++i) {
    const PartIndex first = piece_[i];
    side_.assign(1, first);
    in_side_[first] = true;
    std::vector<PartIndex> candidates;
    for (const ConnectionIndex c : around_[first]) {
      for (const PartIndex end : problem_.ends(c)) {
        if (in_piece_[end] && !in_side_[end] && !excluded_[end] &&
            std::ranges::find(candidates, end) == candidates.end())
          candidates.push_back(end);
      }
    }
    all = grow(largest, std::move(candidates));
    in_side_[first] = false;
    excluded_[first] = true;
  }
  for (const PartIndex part : piece_) in_piece_[part] = excluded_[part] = in_side_[part] = false;
  return all;
}

// The sides that hold all of side_ and further parts, of which at least one is a candidate or is
// reached by way of one; none that is excluded.
bool PieceCuts::grow(std::size_t largest, std::vector<PartIndex> candidates) {
  bool on = side_.size() < largest;
  if (!look(largest, on)) return false;
  if (!on) return true;
  std::vector<PartIndex> tried;
  bool all = true;
  while (all && !candidates.empty()) {
    const PartIndex part = candidates.back();
    candidates.pop_back();
    std::vector<PartIndex> next = candidates;
    side_.push_back(part);
    in_side_[part] = true;
    for (const ConnectionIndex c : around_[part]) {
      for (const PartIndex end : problem_.ends(c)) {
        if (in_piece_[end] && !in_side_[end] && !excluded_[end] &&
            std::ranges::find(next, end) == next.end())
          next.push_back(end);
      }
    }
    all = grow(largest, std::move(next));
    side_.pop_back();
    in_side_[part] = false;
    excluded_[part] = true;
    tried.push_back(part);
  }
  for (const PartIndex part : tried) excluded_[part] = false;
  return all;
}

// Offers side_, where it is of a wanted size and the cut may be made. Clears `on` where no larger
// side has a rest that hangs together: of the pieces of the rest all but one must still join the
// side, which those that hold an excluded part cannot, and for which there may be no room.
bool PieceCuts::look(std::size_t largest, bool& on) {
  if (++looked_ > most_) return false;
  const bool wanted = (*wanted_)[side_.size()];
  if (!wanted && !on) return true;
  rest_.clear();
  for (const PartIndex part : piece_) {
    if (!in_side_[part]) rest_.push_back(part);
  }
  std::size_t left = rest_.size();
  std::size_t biggest = 0;
  std::size_t excluded = 0;
  for (const PartIndex part : rest_) {
    if (in_component_[part]) continue;
    const std::size_t parts = reach(part, false, false);
    bool holds = false;
    for (const PartIndex member : queue_) {
      in_component_[member] = true;
      holds = holds || excluded_[member];
    }
    biggest = std::max(biggest, parts);
    excluded += holds ? 1 : 0;
    left -= parts;
    if (left == 0) break;
  }
  for (const PartIndex part : rest_) in_component_[part] = false;
  if (excluded > 1 || side_.size() + rest_.size() - biggest > largest) on = false;
  if (!wanted || biggest != rest_.size() || !may_be_made()) return true;
  Side side = side_;
  std::ranges::sort(side);
  if (!removals_.cut_allowed(side, rest_)) return true;
  return (*offer_)(side, Side(rest_));
}

// When the cut is made all that joins its sides is gone, and so is what had to go before that.
bool PieceCuts::may_be_made() {
  if (!some_before_) return true;
  std::vector<ConnectionIndex> gone;
  bool possible = true;
  PartIndex rest = piece_.front();
  for (const PartIndex part : piece_) {
    if (!in_side_[part]) rest = part;
  }
  for (const PartIndex part : side_) {
    for (const ConnectionIndex c : around_[part]) {
      const auto [a, b] = problem_.ends(c);
      if (!in_piece_[a] || !in_piece_[b] || in_side_[a] == in_side_[b]) continue;
      for (const ConnectionIndex other : before_[c]) {
        // What waits for itself is never removed.
        if (other == c) possible = false;
        if (!gone_[other]) {
          gone_[other] = true;
          gone.push_back(other);
        }
      }
    }
  }
  possible = possible && reach(side_.front(), true, true) == side_.size() &&
             reach(rest, false, true) == piece_.size() - side_.size();
  for (const ConnectionIndex c : gone) gone_[c] = false;
  return possible;
}

}  // namespace orasp::detail
