#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// Appends the legal cuts of `piece` whose estimate is within `limit` to cuts_. Returns the least
/// estimate of the others, as far as it is known.
template <std::size_t kWords>
double AndOrSearch<kWords>::list_cuts(const Set& piece, std::size_t parts, std::size_t allowed,
                                      double limit) {
  double skipped = kInfinity;
  const double without_tree = lister_.upper_without_tree(piece, parts);
  std::size_t largest = mark_wanted_sizes(parts, without_tree, limit, skipped);
  if (peeling_ && !links_.along_forest) largest = std::min(largest, kMostPeeled);
  if (largest == 0) return skipped;
  const double here = without_tree - build_tree(piece);
  const auto offer = [&](const Set& side, std::size_t side_parts) {
    offer_cut(piece, parts, allowed, limit, here, side, side_parts, skipped);
  };
  if (links_.along_forest) {
    links_.for_each_branch(piece, [&](const Set& side) {
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
  const std::optional<double> gain = lister_.gain(piece, side, rest, side_parts, rest_parts);
  if (!gain) return;
  const Set side_form = form_of(side, side_parts);
  const Set rest_form = form_of(rest, rest_parts);
  double own = here - *gain - uppers(side_form, side_parts, rest_form, rest_parts);
  if ((allowed & kCompletes) != 0 && parts == 2) own += *gain - gain_of_last(side, rest);
  add_cut(side, side_form, side_parts, rest_form, rest_parts, allowed, own, limit, skipped);
}

/// Makes piece_tree_ that of `piece`. @returns what it costs.
template <std::size_t kWords>
double AndOrSearch<kWords>::build_tree(const Set& piece) {
  if (!lister_.sees_trees()) return 0;
  list_parts(piece, parts_);
  piece_tree_.build(lister_.trees(), parts_);
  return piece_tree_.cost();
}

/// The bounds of both sides of a cut of the piece that piece_tree_ is of.
template <std::size_t kWords>
double AndOrSearch<kWords>::uppers(const Set& side, std::size_t side_parts, const Set& rest,
                                   std::size_t rest_parts) {
  if (lister_.sees_trees() && !form_) {
    const Set& smaller = side_parts <= rest_parts ? side : rest;
    list_parts(smaller, parts_);
    const std::optional<double> crossing =
        piece_tree_.only_crossing(parts_, [&](PartIndex part) { return smaller.contains(part); });
    if (crossing) {
      return lister_.upper_without_tree(side, side_parts) +
             lister_.upper_without_tree(rest, rest_parts) - (piece_tree_.cost() - *crossing);
    }
  }
  return upper(side, side_parts) + upper(rest, rest_parts);
}

/// Appends a cut that loses `own_loss` itself, as offer_cut() says. Both sides may be the one that
/// waits where that makes a difference.
template <std::size_t kWords>
void AndOrSearch<kWords>::add_cut(const Set& side, const Set& side_form, std::size_t side_parts,
                                  const Set& rest_form, std::size_t rest_parts, std::size_t allowed,
                                  double own_loss, double limit, double& skipped) {
  const auto add = [&](bool side_waits) {
    const auto [side_allowed, rest_allowed] =
        allowed_to_halves(side_parts, rest_parts, allowed, side_waits);
    if (side_parts > 1 && (side_allowed & kMostAllowed) == 0) return;
    if (rest_parts > 1 && (rest_allowed & kMostAllowed) == 0) return;
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
  add(false);
  const bool completes = (allowed & kCompletes) != 0;
  if ((limited_ || completes) && side_parts >= 2 && rest_parts >= 2) add(true);
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
    const Set rest = piece - side;
    grow(piece, parts, largest, side, 1, links_.neighbours[root] & (piece - mine), mine, lowest,
         hangs_together_without(rest, root, true), offer);
    excluded.insert(root);
  });
}

/// Whether `rest` hangs together, which did or not (`before`) with one more part.
template <std::size_t kWords>
bool AndOrSearch<kWords>::hangs_together_without(const Set& rest, std::size_t part,
                                                 bool before) const {
  // A part with one neighbour holds nothing else together.
  if (before && (links_.neighbours[part] & rest).size() <= 1) return true;
  return flood(rest, rest.first()) == rest;
}

/// Lists the sides that hold all of `side` and further parts of `frontier`, but none of `excluded`.
/// `whole`: whether the rest hangs together.
template <std::size_t kWords>
template <class Offer>
void AndOrSearch<kWords>::grow(const Set& piece, std::size_t parts, std::size_t largest,
                               const Set& side, std::size_t side_parts, Set frontier, Set excluded,
                               std::size_t lowest, bool whole, Offer&& offer) {
  if (must_stop()) return;
  if (++looks_ % 4096 == 0) poll();
  if (looks_ >= looks_end_at_) run_is_over_ = true;
  const Set rest = piece - side;
  if (whole) {
    if (wanted_[side_parts] != 0 && (2 * side_parts != parts || side.contains(lowest)))
      offer(side, side_parts);
  } else {
    // The rest must become connected: all but one of its components must still join the side, and
    // those that hold an excluded part cannot.
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
    const Set next = (frontier | (links_.neighbours[part] & piece)) - larger - mine;
    grow(piece, parts, largest, larger, side_parts + 1, next, mine, lowest,
         hangs_together_without(piece - larger, part, whole), offer);
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
    front.for_each([&](std::size_t part) { next = next | links_.neighbours[part]; });
    front = (next & within) - reached;
    reached = reached | front;
  }
  return reached;
}

template double AndOrSearch<1>::build_tree(const Set&);
template double AndOrSearch<1>::uppers(const Set&, std::size_t, const Set&, std::size_t);
template double AndOrSearch<1>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<1>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                      std::size_t, double, double, double&);
template double AndOrSearch<2>::build_tree(const Set&);
template double AndOrSearch<2>::uppers(const Set&, std::size_t, const Set&, std::size_t);
template double AndOrSearch<2>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<2>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                      std::size_t, double, double, double&);
template double AndOrSearch<4>::build_tree(const Set&);
template double AndOrSearch<4>::uppers(const Set&, std::size_t, const Set&, std::size_t);
template double AndOrSearch<4>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<4>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                      std::size_t, double, double, double&);
template double AndOrSearch<8>::build_tree(const Set&);
template double AndOrSearch<8>::uppers(const Set&, std::size_t, const Set&, std::size_t);
template double AndOrSearch<8>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<8>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                      std::size_t, double, double, double&);
template double AndOrSearch<16>::build_tree(const Set&);
template double AndOrSearch<16>::uppers(const Set&, std::size_t, const Set&, std::size_t);
template double AndOrSearch<16>::list_cuts(const Set&, std::size_t, std::size_t, double);
template void AndOrSearch<16>::add_cut(const Set&, const Set&, std::size_t, const Set&, std::size_t,
                                       std::size_t, double, double, double&);

}  // namespace orasp::detail
