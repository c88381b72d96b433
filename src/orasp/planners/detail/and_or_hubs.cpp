#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// A lower bound on the loss of a piece of memo_ before any of its cuts is looked at; what is more
/// than `enough` need not be found. `bound` is that of the piece.
template <std::size_t kWords>
double AndOrSearch<kWords>::first_loss(std::uint32_t number, std::size_t parts, double bound,
                                       double enough) {
  const Set piece = set_of(number);
  const bool completes = (memo_.key(number)[kWords] & kCompletes) != 0;
  const double least = loss_by_shape(piece, parts, bound, completes);
  if (!has_own_prices(parts)) return least;
  list_parts(piece, parts_);
  const double above = above_prices(parts_, bound, tree(piece));
  const std::size_t depth = path_of_pieces_.size();
  if (raises_.size() <= depth) raises_.resize(depth + 1);
  // Other sides of the piece that this one is cut from are looked at soon.
  if (depth > 0 && raises_[depth - 1].number != path_of_pieces_.back())
    raise_on_path(depth - 1, path_of_pieces_.back(), kInfinity);
  raise_on_path(depth, number, enough - above);
  return std::max(least, above + raises_[depth].raise.sum());
}

/// By how much the bound of a piece is above what the prices say that fit all pieces: negative
/// where another bound is closer. What the parts of the piece cost more is loss beyond that. `tree`
/// is what the bound counts for connections.
template <std::size_t kWords>
double AndOrSearch<kWords>::above_prices(std::span<const PartIndex> piece, double bound,
                                         double tree) const {
  return bound - (gains_.prices().small_pieces().bound(piece) - tree) - slack(scale_);
}

/// Fits prices to a piece at `depth`, by those of the nearest piece above it that is there.
template <std::size_t kWords>
void AndOrSearch<kWords>::raise_on_path(std::size_t depth, std::uint32_t number, double enough) {
  std::size_t above = depth;
  while (above > 0 && raises_[above - 1].number != path_of_pieces_[above - 1]) --above;
  list_parts(set_of(number), parts_);
  raised_->fit(above > 0 ? raises_[above - 1].raise : raised_->none(), parts_, enough,
               raises_[depth].raise);
  raises_[depth].number = number;
}

/// A hub costs more than sizes tell.
template <std::size_t kWords>
double AndOrSearch<kWords>::loss_by_hubs(const Set& piece, std::size_t parts, double bound) {
  if (!gains_.sizes_known() || parts < 3) return unknown_loss();
  const double here = bound + tree(piece);
  // A star has the most arms; where even that loses nothing, they need not be counted.
  const double of_star = gains_.by_arms(parts, parts - 1);
  if (std::isfinite(of_star) && here <= of_star) return 0;
  // Nor where no part has so many neighbours that it could matter.
  std::size_t neighbours = 1;
  piece.for_each([&](std::size_t part) {
    neighbours = std::max(neighbours, (links_.neighbours[part] & piece).size());
  });
  const Hubs at_most{neighbours, (parts - 1 + neighbours - 1) / neighbours};
  const double enough = most_with(parts, at_most);
  if (std::isfinite(enough) && here - enough - slack(scale_) <= 0) return 0;
  const Hubs found = graph_.is_forest() ? hubs_of_tree(piece, parts) : hubs(piece, parts);
  return std::max(0.0, here - most_with(parts, found) - slack(scale_));
}

/// What the cuts of a piece gain at most that has such hubs.
template <std::size_t kWords>
double AndOrSearch<kWords>::most_with(std::size_t parts, const Hubs& found) {
  const double by_arms = gains_.by_arms(parts, found.arms);
  if (parts > kMostPartsWithReach || 2 * found.reach >= parts) return by_arms;
  return std::min(by_arms, by_reach(parts, found.reach));
}

/// The bound by sizes of a piece that has a part v without which no component has more than
/// `reach` parts. The side of a cut without v lies in one of them, so
///
///     h(n) = max over a <= reach of gain(a, n - a) + g(a) + h(n - a),   h(1) = 0.
///
/// O(parts * reach), once for each `reach`.
template <std::size_t kWords>
double AndOrSearch<kWords>::by_reach(std::size_t parts, std::size_t reach) {
  if (by_reach_.size() <= reach) by_reach_.resize(reach + 1);
  std::vector<double>& best = by_reach_[reach];
  if (best.empty()) best.assign(2, 0.0);
  for (std::size_t n = best.size(); n <= parts; ++n) {
    best.push_back(-kInfinity);
    for (std::size_t a = 1; a <= std::min(reach, n - 1); ++a) {
      const double gain = gains_.gain(std::min(a, n - a), std::max(a, n - a));
      best[n] = std::max(best[n], gain + gains_.by_size(a) + best[n - a]);
    }
  }
  return best[parts];
}

/// The same as hubs() where the connections form no cycle.
template <std::size_t kWords>
auto AndOrSearch<kWords>::hubs_of_tree(const Set& piece, std::size_t parts) -> Hubs {
  Hubs found{1, parts - 1};
  piece.for_each([&](std::size_t part) {
    const Set around = links_.neighbours[part] & piece;
    found.arms = std::max(found.arms, around.size());
    const std::size_t below = (links_.below[part] & piece).size();
    std::size_t largest = parts - below;
    around.for_each([&](std::size_t other) {
      if (links_.parent[other] == part)
        largest = std::max(largest, (links_.below[other] & piece).size());
    });
    found.reach = std::min(found.reach, largest);
  });
  return found;
}

/// Reference: articulation points by depth-first search, Hopcroft and Tarjan (1973), Comm. ACM
/// 16(6), 372-378.
template <std::size_t kWords>
auto AndOrSearch<kWords>::hubs(const Set& piece, std::size_t parts) -> Hubs {
  Hubs found{1, parts - 1};
  constexpr std::uint32_t kUnmet = 0;
  met_.assign(problem_.num_parts(), kUnmet);
  low_.resize(problem_.num_parts());
  std::vector<HubFrame>& path = path_;
  path.clear();
  std::uint32_t time = 0;
  const auto enter = [&](PartIndex part, PartIndex from) {
    met_[part] = low_[part] = ++time;
    path.push_back({part, from, 0, 0, 0, 0, 1});
  };
  enter(static_cast<PartIndex>(piece.first()), SpanningForest::kNoPart);
  while (!path.empty()) {
    HubFrame& frame = path.back();
    const auto around = graph_.around(frame.part);
    if (frame.next < around.size()) {
      const PartIndex other = around[frame.next++].other;
      if (!piece.contains(other) || other == frame.from) continue;
      if (met_[other] == kUnmet) {
        enter(other, frame.part);
      } else {
        low_[frame.part] = std::min(low_[frame.part], met_[other]);
      }
      continue;
    }
    const HubFrame done = frame;
    const std::size_t others = parts - 1 - done.cut_off;
    found.arms = std::max(found.arms, done.arms + (others > 0 ? 1 : 0));
    found.reach = std::min(found.reach, std::max(done.largest, others));
    path.pop_back();
    if (path.empty()) break;
    HubFrame& above = path.back();
    above.below += done.below;
    low_[above.part] = std::min(low_[above.part], low_[done.part]);
    if (low_[done.part] < met_[above.part]) continue;
    ++above.arms;
    above.cut_off += done.below;
    above.largest = std::max(above.largest, done.below);
  }
  return found;
}

template double AndOrSearch<1>::above_prices(std::span<const PartIndex>, double, double) const;
template double AndOrSearch<2>::above_prices(std::span<const PartIndex>, double, double) const;
template double AndOrSearch<4>::above_prices(std::span<const PartIndex>, double, double) const;
template double AndOrSearch<8>::above_prices(std::span<const PartIndex>, double, double) const;
template double AndOrSearch<16>::above_prices(std::span<const PartIndex>, double, double) const;
template double AndOrSearch<1>::loss_by_hubs(const Set&, std::size_t, double);
template double AndOrSearch<1>::first_loss(std::uint32_t, std::size_t, double, double);
template double AndOrSearch<2>::loss_by_hubs(const Set&, std::size_t, double);
template double AndOrSearch<2>::first_loss(std::uint32_t, std::size_t, double, double);
template double AndOrSearch<4>::loss_by_hubs(const Set&, std::size_t, double);
template double AndOrSearch<4>::first_loss(std::uint32_t, std::size_t, double, double);
template double AndOrSearch<8>::loss_by_hubs(const Set&, std::size_t, double);
template double AndOrSearch<8>::first_loss(std::uint32_t, std::size_t, double, double);
template double AndOrSearch<16>::loss_by_hubs(const Set&, std::size_t, double);
template double AndOrSearch<16>::first_loss(std::uint32_t, std::size_t, double, double);

}  // namespace orasp::detail
