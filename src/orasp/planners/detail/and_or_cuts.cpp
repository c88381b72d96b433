#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// Appends the legal cuts of `piece` whose estimate is within `limit` to cuts_. Returns the least
/// estimate of the others, as far as it is known.
template <std::size_t kWords>
double AndOrSearch<kWords>::list_cuts(const Set& piece, std::size_t parts, std::size_t allowed,
                                      double limit) {
  const double here = upper(piece, parts);
  double skipped = kInfinity;
  std::size_t largest = mark_wanted_sizes(parts, here + tree(piece), limit, skipped);
  if (peeling_ && !along_forest_) largest = std::min(largest, kMostPeeled);
  if (largest == 0) return skipped;
  const auto offer = [&](const Set& side, std::size_t side_parts) {
    offer_cut(piece, parts, allowed, limit, here, side, side_parts, skipped);
  };
  if (along_forest_) {
    piece.for_each([&](std::size_t part) {
      if (parent_[part] == SpanningForest::kNoPart || !piece.contains(parent_[part])) return;
      const Set side = below_[part] & piece;
      const std::size_t side_parts = side.size();
      if (wanted_[std::min(side_parts, parts - side_parts)] != 0) offer(side, side_parts);
    });
  } else {
    list_sides(piece, parts, largest, offer);
  }
  return skipped;
}

/// Marks in wanted_ the sizes of a smaller side with which a cut may stay within `limit`, and
/// returns the largest of them (0 if there is none). `here` is the bound of the piece by its parts:
/// what its tree costs, the trees of the sides and the cut cost at least.
template <std::size_t kWords>
std::size_t AndOrSearch<kWords>::mark_wanted_sizes(std::size_t parts, double here, double limit,
                                                   double& skipped) {
  wanted_.assign(parts / 2 + 1, 0);
  std::size_t largest = 0;
  const std::size_t most_moved = gains_.most_moved();
  for (std::size_t a = 1; a <= std::min(parts / 2, most_moved); ++a) {
    double least = unknown_loss();
    if (gains_.sizes_known())
      least = here - gains_.gain(a, parts - a) - gains_.by_size(a) - gains_.by_size(parts - a);
    if (least > limit) {
      skipped = std::min(skipped, least);
    } else {
      wanted_[a] = 1;
      largest = a;
    }
  }
  return largest;
}

/// Appends the cut of `piece` into `side` and the rest to cuts_ if it is legal and its estimate is
/// within `limit`: once for each side that may wait where that makes a difference.
template <std::size_t kWords>
void AndOrSearch<kWords>::offer_cut(const Set& piece, std::size_t parts, std::size_t allowed,
                                    double limit, double here, const Set& side,
                                    std::size_t side_parts, double& skipped) {
  const Set rest = piece - side;
  const std::size_t rest_parts = parts - side_parts;
  const std::optional<double> gain = gain_of(piece, side, rest, side_parts, rest_parts);
  if (!gain) return;
  const Set side_form = form_of(side, side_parts);
  const Set rest_form = form_of(rest, rest_parts);
  const double own = here - *gain - upper(side_form, side_parts) - upper(rest_form, rest_parts);
  add_cut(side, side_form, side_parts, rest_form, rest_parts, allowed, own, limit, skipped);
}

/// Appends a cut that loses `own_loss` itself, as offer_cut() says.
template <std::size_t kWords>
void AndOrSearch<kWords>::add_cut(const Set& side, const Set& side_form, std::size_t side_parts,
                                  const Set& rest_form, std::size_t rest_parts, std::size_t allowed,
                                  double own_loss, double limit, double& skipped) {
  const auto add = [&](std::size_t side_allowed, std::size_t rest_allowed, bool side_waits) {
    if ((side_allowed == 0 && side_parts > 1) || (rest_allowed == 0 && rest_parts > 1)) return;
    const double estimate = own_loss + known_loss(side_form, side_parts, side_allowed) +
                            known_loss(rest_form, rest_parts, rest_allowed);
    if (estimate > limit) {
      skipped = std::min(skipped, estimate);
      return;
    }
    const std::uint64_t order = salt_ == 0 ? cuts_.size() : mixed(hash_value(side.words) + salt_);
    cuts_.push_back({side, own_loss, estimate, order, side_waits});
    if (cuts_.size() * sizeof(Cut) > allowed_bytes_ / 2) run_is_over_ = true;
  };
  if (limited_ && side_parts >= 2 && rest_parts >= 2) {
    add(allowed - 1, allowed, false);
    add(allowed, allowed - 1, true);
  } else {
    add(allowed, allowed, false);
  }
}

/// Calls offer(side, parts) for every connected side of a wanted size, of at most half of the
/// piece, whose rest is connected. Reference for listing connected sets once each: Wernicke
/// (2006), IEEE/ACM Trans. Computational Biology and Bioinformatics 3(4), 347-359.
template <std::size_t kWords>
template <class Offer>
void AndOrSearch<kWords>::list_sides(const Set& piece, std::size_t parts, std::size_t largest,
                                     Offer&& offer) {
  Set excluded;
  const std::size_t lowest = piece.first();
  piece.for_each([&](std::size_t root) {
    Set side;
    side.insert(root);
    Set mine = excluded;
    grow(piece, parts, largest, side, 1, neighbours_[root] & (piece - mine), mine, lowest, offer);
    excluded.insert(root);
  });
}

/// Lists the sides that hold all of `side` and further parts of `frontier`, but none of `excluded`.
template <std::size_t kWords>
template <class Offer>
void AndOrSearch<kWords>::grow(const Set& piece, std::size_t parts, std::size_t largest,
                               const Set& side, std::size_t side_parts, Set frontier, Set excluded,
                               std::size_t lowest, Offer&& offer) {
  if (must_stop()) return;
  if (++looks_ % 4096 == 0) poll();
  if (looks_ >= looks_end_at_) run_is_over_ = true;
  // The rest must become connected: all but one of its components must still join the side, and
  // those that hold an excluded part cannot.
  const Set rest = piece - side;
  const Set component = flood(rest, rest.first());
  if (component == rest) {
    if (wanted_[side_parts] != 0 && (2 * side_parts != parts || side.contains(lowest)))
      offer(side, side_parts);
  } else {
    std::size_t with_excluded = 0;
    std::size_t biggest = 0;
    Set left = rest;
    while (!left.empty()) {
      const Set one = flood(left, left.first());
      biggest = std::max(biggest, one.size());
      if (!(one & excluded).empty()) ++with_excluded;
      left = left - one;
    }
    if (with_excluded > 1) return;
    if (side_parts + (parts - side_parts - biggest) > largest) return;
  }
  if (side_parts == largest) return;
  Set mine = excluded;
  frontier.for_each([&](std::size_t part) {
    Set larger = side;
    larger.insert(part);
    const Set next = (frontier | (neighbours_[part] & piece)) - larger - mine;
    grow(piece, parts, largest, larger, side_parts + 1, next, mine, lowest, offer);
    mine.insert(part);
  });
}

/// The connected part of `within` that holds the part `start`.
template <std::size_t kWords>
auto AndOrSearch<kWords>::flood(const Set& within, std::size_t start) const -> Set {
  Set reached;
  reached.insert(start);
  Set front = reached;
  while (!front.empty()) {
    Set next;
    front.for_each([&](std::size_t part) { next = next | neighbours_[part]; });
    front = (next & within) - reached;
    reached = reached | front;
  }
  return reached;
}

/// What the cut of a piece into `side` and `rest` gains at best; empty where it cannot be legal.
template <std::size_t kWords>
std::optional<double> AndOrSearch<kWords>::gain_of(const Set& piece, const Set& side,
                                                   const Set& rest, std::size_t side_parts,
                                                   std::size_t rest_parts) {
  if (!precedence_.empty() && !may_precede(side, rest)) return std::nullopt;
  if (by_sizes_)
    return gains_.gain(std::min(side_parts, rest_parts), std::max(side_parts, rest_parts));
  list_parts(side, side_list_);
  list_parts(rest, rest_list_);
  std::optional<double> best;
  const bool by_side = side_parts <= rest_parts;
  for (const PartIndex part : by_side ? side_list_ : rest_list_) {
    if ((neighbours_[part] & (by_side ? rest : side)).empty()) continue;
    for (const auto& half : graph_.around(part)) {
      if (!piece.contains(half.other) || side.contains(half.other) == side.contains(part)) continue;
      const auto gain = listed_gain(side, half.connection);
      if (!gain) return std::nullopt;
      if (!best || *gain > *best) best = *gain;
      if (!by_connection_) return best;
    }
  }
  return best;
}

/// Whether precedence allows the cut. Before the last connection between the two sides goes, all
/// that must precede it is gone, and each side must still hang together without that.
template <std::size_t kWords>
bool AndOrSearch<kWords>::may_precede(const Set& side, const Set& rest) {
  gone_.assign(problem_.num_connections(), 0);
  bool any = false;
  side.for_each([&](std::size_t part) {
    for (const auto& half : graph_.around(static_cast<PartIndex>(part))) {
      if (!rest.contains(half.other)) continue;
      for (const ConnectionIndex c : precedence_[half.connection]) {
        gone_[c] = 1;
        any = true;
      }
    }
  });
  if (!any) return true;
  const auto hangs_together = [&](const Set& set) {
    Set reached;
    reached.insert(set.first());
    std::vector<PartIndex>& queue = queue_;
    queue.assign(1, static_cast<PartIndex>(set.first()));
    for (std::size_t i = 0; i < queue.size(); ++i) {
      for (const auto& half : graph_.around(queue[i])) {
        if (gone_[half.connection] != 0 || !set.contains(half.other) ||
            reached.contains(half.other))
          continue;
        reached.insert(half.other);
        queue.push_back(half.other);
      }
    }
    return queue.size() == set.size();
  };
  return hangs_together(side) && hangs_together(rest);
}

template double AndOrSearch<1>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<1>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                      std::size_t, double, double, double&);
template double AndOrSearch<2>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<2>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                      std::size_t, double, double, double&);
template double AndOrSearch<4>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<4>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                      std::size_t, double, double, double&);
template double AndOrSearch<8>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<8>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                      std::size_t, double, double, double&);
template double AndOrSearch<16>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<16>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                       std::size_t, double, double, double&);

}  // namespace orasp::detail
