#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// More sides of one piece than this are not kept.
constexpr std::uint64_t kMostSidesKept = 20'000;

/// The number of a piece in memo_, where cuts are kept; it comes in where it is not there.
template <std::size_t kWords>
std::uint32_t AndOrSearch<kWords>::node_of(const Set& set, std::size_t parts) {
  const auto [number, is_new] = memo_.insert(key(set, 0).data());
  if (is_new) {
    loss_.push_back(parts == 1 ? 0 : unknown_loss());
    exact_.push_back(parts == 1 ? 1 : 0);
    upper_.push_back(upper(set, parts));
    lists_.push_back({});
  }
  return number;
}

/// As search(), for a piece of memo_.
template <std::size_t kWords>
double AndOrSearch<kWords>::search_stored(std::uint32_t number, double limit) {
  if (exact_[number] != 0 || loss_[number] > limit || must_stop()) return loss_[number];
  if (++visits_ % 4096 == 0) poll();
  const StoredCuts& list = lists_[number];
  double best = kInfinity;
  double next = kInfinity;
  const bool there = list.kept && list.limit >= limit;
  if (there || (!list.too_many && store_cuts(number, limit))) {
    std::tie(best, next) = least_stored_loss(number, limit);
  } else if (!must_stop()) {
    const Set piece = set_of(number);
    std::tie(best, next) = least_listed_loss(piece, piece.size(), kMostAllowed, limit);
  }
  return settled_loss(number, limit, best, next);
}

/// Lists and keeps the cuts of a piece whose own loss is within what any plan worth looking at may
/// lose. False where they are too many to keep, or the search has to stop.
template <std::size_t kWords>
bool AndOrSearch<kWords>::store_cuts(std::uint32_t number, double limit) {
  const Set piece = set_of(number);
  const std::size_t parts = piece.size();
  if (!lists_[number].kept) loss_[number] = std::max(loss_[number], first_loss(piece, parts));
  ++result_.statistics.expanded;
  if (result_.statistics.expanded % 256 == 0) poll();
  if (result_.statistics.expanded >= run_ends_at_) run_is_over_ = true;
  const double most = std::max(limit, most_loss_);
  const std::uint64_t begin = stored_.size();
  const std::uint64_t looks_before = looks_;
  double skipped = kInfinity;
  const auto stop = [&] {
    if (++looks_ % 4096 == 0) poll();
    if (looks_ >= looks_end_at_) run_is_over_ = true;
    return must_stop() || looks_ - looks_before > kMostSidesKept;
  };
  if (along_forest_) {
    piece.for_each([&](std::size_t part) {
      if (parent_[part] == SpanningForest::kNoPart || !piece.contains(parent_[part])) return;
      const Set side = below_[part] & piece;
      store_cut(piece, upper_[number], side, piece - side, most, skipped);
    });
  } else {
    sides_->list(
        piece,
        [&](const Set& side, const Set& rest) {
          store_cut(piece, upper_[number], side, rest, most, skipped);
        },
        stop);
  }
  const bool room = (stored_.size() + memo_.size()) * sizeof(StoredCut) < allowed_bytes_ / 4;
  if (must_stop() || looks_ - looks_before > kMostSidesKept || !room) {
    stored_.resize(begin);
    lists_[number].too_many = !must_stop();
    return false;
  }
  lists_[number] = {begin,  static_cast<std::uint32_t>(stored_.size() - begin), true, false, most,
                    skipped};
  return true;
}

/// Keeps the cut of `piece` into `side` and `rest` if it is legal and loses at most `limit` itself.
/// `here` is the bound of the piece.
template <std::size_t kWords>
void AndOrSearch<kWords>::store_cut(const Set& piece, double here, const Set& side, const Set& rest,
                                    double limit, double& skipped) {
  const std::size_t side_parts = side.size();
  const std::size_t rest_parts = rest.size();
  if (std::min(side_parts, rest_parts) > gains_.most_moved()) return;
  const std::optional<double> gain = gain_of(piece, side, rest, side_parts, rest_parts);
  if (!gain) return;
  const std::uint32_t side_number = node_of(side, side_parts);
  const std::uint32_t rest_number = node_of(rest, rest_parts);
  const double own = here - *gain - upper_[side_number] - upper_[rest_number];
  if (own > limit) {
    skipped = std::min(skipped, own);
    return;
  }
  stored_.push_back({side_number, rest_number, own});
}

/// As least_loss(), for a piece whose cuts are kept.
template <std::size_t kWords>
std::pair<double, double> AndOrSearch<kWords>::least_stored_loss(std::uint32_t number,
                                                                 double limit) {
  const StoredCuts list = lists_[number];
  const auto estimate = [&](const StoredCut& cut) {
    return cut.own_loss + loss_[cut.side] + loss_[cut.rest];
  };
  const double tie = slack(scale_);
  const std::size_t begin = promising_.size();
  double best = kInfinity;
  double next = list.skipped;
  for (std::uint64_t i = list.begin; i < list.begin + list.size; ++i) {
    const double least = estimate(stored_[i]);
    if (least <= limit) {
      promising_.emplace_back(least, i);
    } else {
      next = std::min(next, least);
    }
  }
  std::sort(promising_.begin() + static_cast<std::ptrdiff_t>(begin), promising_.end());
  const std::size_t end = promising_.size();
  for (std::size_t i = begin; i < end && !must_stop(); ++i) {
    const StoredCut cut = stored_[promising_[i].second];
    const double most = std::min(limit, best - tie);
    const double least = estimate(cut);
    if (least > most) {
      next = std::min(next, least);
      continue;
    }
    ++result_.statistics.generated;
    const double side_limit = most - cut.own_loss - loss_[cut.rest];
    const double side_loss = search_stored(cut.side, side_limit);
    bool solved = side_loss <= side_limit && exact_[cut.side] != 0;
    if (solved) {
      const double rest_limit = most - cut.own_loss - side_loss;
      const double rest_loss = search_stored(cut.rest, rest_limit);
      solved = rest_loss <= rest_limit && exact_[cut.rest] != 0;
    }
    if (must_stop()) break;
    const double total = estimate(cut);
    if (solved) {
      best = total;
    } else {
      next = std::min(next, total);
    }
  }
  promising_.resize(begin);
  return {best, next};
}

template <std::size_t kWords>
bool AndOrSearch<kWords>::keeps_all_cuts() const {
  return stores_ && std::ranges::all_of(pieces_, [&](const Set& piece) {
           const std::uint32_t number = memo_.find(key(piece, 0).data());
           return number != StateTable<kWords + 1>::kAbsent && lists_[number].kept;
         });
}

/// As next_cut(), where cuts are kept.
template <std::size_t kWords>
auto AndOrSearch<kWords>::next_stored_cut(const Set& piece, std::size_t parts, bool dive)
    -> std::optional<Cut> {
  const std::uint32_t number = node_of(piece, parts);
  const bool known = exact_[number] != 0;
  if (!known && !dive) return std::nullopt;
  if (!lists_[number].kept && !store_cuts(number, most_loss_)) return std::nullopt;
  const StoredCuts list = lists_[number];
  const StoredCut* best = nullptr;
  double least = kInfinity;
  for (std::uint64_t i = list.begin; i < list.begin + list.size; ++i) {
    const StoredCut& cut = stored_[i];
    const double estimate = cut.own_loss + loss_[cut.side] + loss_[cut.rest];
    // Where the loss of the piece is exact, so are those of the sides of a best cut.
    const bool solved = exact_[cut.side] != 0 && exact_[cut.rest] != 0;
    if (estimate >= least || (known && !solved)) continue;
    best = &cut;
    least = estimate;
  }
  if (best == nullptr) return std::nullopt;
  return Cut{.side = set_of(best->side),
             .own_loss = best->own_loss,
             .estimate = least,
             .order = 0,
             .side_waits = false};
}

template std::uint32_t AndOrSearch<1>::node_of(const Set&, std::size_t);
template double AndOrSearch<1>::search_stored(std::uint32_t, double);
template bool AndOrSearch<1>::keeps_all_cuts() const;
template auto AndOrSearch<1>::next_stored_cut(const Set&, std::size_t, bool) -> std::optional<Cut>;
template std::uint32_t AndOrSearch<2>::node_of(const Set&, std::size_t);
template double AndOrSearch<2>::search_stored(std::uint32_t, double);
template bool AndOrSearch<2>::keeps_all_cuts() const;
template auto AndOrSearch<2>::next_stored_cut(const Set&, std::size_t, bool) -> std::optional<Cut>;
template std::uint32_t AndOrSearch<4>::node_of(const Set&, std::size_t);
template double AndOrSearch<4>::search_stored(std::uint32_t, double);
template bool AndOrSearch<4>::keeps_all_cuts() const;
template auto AndOrSearch<4>::next_stored_cut(const Set&, std::size_t, bool) -> std::optional<Cut>;
template std::uint32_t AndOrSearch<8>::node_of(const Set&, std::size_t);
template double AndOrSearch<8>::search_stored(std::uint32_t, double);
template bool AndOrSearch<8>::keeps_all_cuts() const;
template auto AndOrSearch<8>::next_stored_cut(const Set&, std::size_t, bool) -> std::optional<Cut>;
template std::uint32_t AndOrSearch<16>::node_of(const Set&, std::size_t);
template double AndOrSearch<16>::search_stored(std::uint32_t, double);
template bool AndOrSearch<16>::keeps_all_cuts() const;
template auto AndOrSearch<16>::next_stored_cut(const Set&, std::size_t, bool) -> std::optional<Cut>;

}  // namespace orasp::detail
