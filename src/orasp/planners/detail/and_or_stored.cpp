#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// The number of a piece in memo_, where cuts are kept; it comes in where it is not there.
template <std::size_t kWords>
std::uint32_t AndOrSearch<kWords>::node_of(const Set& set, std::size_t parts) {
  const std::uint64_t hash = memo_.hash(key(set, 0).data());
  const std::uint32_t number = memo_.find(key(set, 0).data(), hash);
  return number == StateTable<kWords + 1>::kAbsent ? node_of(set, hash, upper(set, parts)) : number;
}

/// The same where its hash and its bound are known.
template <std::size_t kWords>
std::uint32_t AndOrSearch<kWords>::node_of(const Set& set, std::uint64_t hash, double bound) {
  const auto [number, is_new] = memo_.insert(key(set, 0).data(), hash);
  if (is_new) {
    const bool single = set.size() == 1;
    loss_.push_back(single ? 0 : unknown_loss());
    exact_.push_back(single ? 1 : 0);
    upper_.push_back(bound);
    lists_.push_back({});
  }
  return number;
}

/// Works out first_loss() of a piece, once; again where it was enough to know that it is more than
/// a limit.
template <std::size_t kWords>
void AndOrSearch<kWords>::look_at(std::uint32_t number, double limit) {
  if (lists_[number].looked_at) return;
  const double first = first_loss(number, set_of(number).size(), upper_[number], limit);
  loss_[number] = std::max(loss_[number], first);
  lists_[number].looked_at = loss_[number] <= limit;
}

/// As search(), for a piece of memo_.
template <std::size_t kWords>
double AndOrSearch<kWords>::search_stored(std::uint32_t number, double limit) {
  if (exact_[number] != 0 || loss_[number] > limit || must_stop()) return loss_[number];
  if (++visits_ % 4096 == 0) poll();
  look_at(number, limit);
  if (loss_[number] > limit) return loss_[number];
  const StoredCuts& list = lists_[number];
  double best = kInfinity;
  double next = kInfinity;
  path_of_pieces_.push_back(number);
  const bool there = list.kept && list.limit >= limit;
  if (there || (!list.too_many && store_cuts(number, limit))) {
    std::tie(best, next) = least_stored_loss(number, limit);
  } else if (!must_stop()) {
    const Set piece = set_of(number);
    std::tie(best, next) = least_listed_loss(piece, piece.size(), kMostAllowed, limit);
  }
  path_of_pieces_.pop_back();
  return settled_loss(number, limit, best, next);
}

/// Lists and keeps the cuts of a piece whose own loss is within what any plan worth looking at may
/// lose. False where they are too many to keep, or the search has to stop.
template <std::size_t kWords>
bool AndOrSearch<kWords>::store_cuts(std::uint32_t number, double limit) {
  const Set piece = set_of(number);
  if (must_stop()) return false;
  const double most = std::max(limit, most_loss_);
  lister_.list(piece, upper_[number], most, listed_, [&] {
    poll();
    return must_stop();
  });
  count_listed(listed_.looks);
  if (must_stop()) return false;
  hashes_.clear();
  add_hashes(listed_.cuts, hashes_);
  return keep_cuts(number, most, listed_.cuts, hashes_, listed_.skipped, listed_.complete);
}

/// Counts a piece whose cuts were listed.
template <std::size_t kWords>
void AndOrSearch<kWords>::count_listed(std::uint64_t looks) {
  ++result_.statistics.expanded;
  if (result_.statistics.expanded % 256 == 0) poll();
  looks_ += looks;
  if (result_.statistics.expanded >= run_ends_at_ || looks_ >= looks_end_at_) run_is_over_ = true;
}

/// Keeps the cuts of a piece whose own loss is within `limit`, with the hashes of their sides.
/// False where they are not all, or too many to keep.
template <std::size_t kWords>
bool AndOrSearch<kWords>::keep_cuts(std::uint32_t number, double limit,
                                    std::span<const typename CutLister<kWords>::Found> cuts,
                                    std::span<const std::uint64_t> hashes, double skipped,
                                    bool complete) {
  const bool room = (stored_.size() + memo_.size()) * sizeof(StoredCut) < allowed_bytes_ / 4;
  if (!complete || !room) {
    lists_[number].too_many = true;
    return false;
  }
  // The places of all sides in the table are asked for before the first is needed: each is far from
  // the others in memory.
  for (const std::uint64_t hash : hashes) memo_.prefetch(hash);
  const std::uint64_t begin = stored_.size();
  const std::uint64_t* hash = hashes.data();
  for (const auto& cut : cuts) {
    const std::uint32_t side = node_of(cut.side, *hash++, cut.side_bound);
    const std::uint32_t rest = node_of(cut.rest, *hash++, cut.rest_bound);
    stored_.push_back({side, rest, cut.own_loss});
  }
  lists_[number] = {.begin = begin,
                    .size = static_cast<std::uint32_t>(stored_.size() - begin),
                    .kept = true,
                    .too_many = false,
                    .looked_at = true,
                    .limit = limit,
                    .skipped = skipped};
  return true;
}

/// As least_loss(), for a piece whose cuts are kept.
template <std::size_t kWords>
std::pair<double, double> AndOrSearch<kWords>::least_stored_loss(std::uint32_t number,
                                                                 double limit) {
  const StoredCuts list = lists_[number];
  const double tie = slack(scale_);
  const std::size_t begin = promising_.size();
  double best = kInfinity;
  double next = list.skipped;
  for_each_kept(list, [&](std::uint64_t i) {
    const double least = estimate(stored_[i]);
    if (least <= limit) {
      promising_.emplace_back(least, i);
    } else {
      next = std::min(next, least);
    }
  });
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

/// As next_cut(), for a piece whose cuts are kept.
template <std::size_t kWords>
auto AndOrSearch<kWords>::next_stored_cut(std::uint32_t number) const -> std::optional<Cut> {
  const bool known = exact_[number] != 0;
  const StoredCuts list = lists_[number];
  const StoredCut* best = nullptr;
  double least = kInfinity;
  for_each_kept(list, [&](std::uint64_t i) {
    const StoredCut& cut = stored_[i];
    // Where the loss of the piece is exact, so are those of the sides of a best cut.
    if (estimate(cut) >= least || (known && !solved(cut))) return;
    best = &cut;
    least = estimate(cut);
  });
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
template bool AndOrSearch<1>::store_cuts(std::uint32_t, double);
template void AndOrSearch<1>::count_listed(std::uint64_t);
template bool AndOrSearch<1>::keep_cuts(std::uint32_t, double, std::span<const CutLister<1>::Found>,
                                        std::span<const std::uint64_t>, double, bool);
template auto AndOrSearch<1>::next_stored_cut(std::uint32_t) const -> std::optional<Cut>;
template std::uint32_t AndOrSearch<2>::node_of(const Set&, std::size_t);
template double AndOrSearch<2>::search_stored(std::uint32_t, double);
template bool AndOrSearch<2>::keeps_all_cuts() const;
template bool AndOrSearch<2>::store_cuts(std::uint32_t, double);
template void AndOrSearch<2>::count_listed(std::uint64_t);
template bool AndOrSearch<2>::keep_cuts(std::uint32_t, double, std::span<const CutLister<2>::Found>,
                                        std::span<const std::uint64_t>, double, bool);
template auto AndOrSearch<2>::next_stored_cut(std::uint32_t) const -> std::optional<Cut>;
template std::uint32_t AndOrSearch<4>::node_of(const Set&, std::size_t);
template double AndOrSearch<4>::search_stored(std::uint32_t, double);
template bool AndOrSearch<4>::keeps_all_cuts() const;
template bool AndOrSearch<4>::store_cuts(std::uint32_t, double);
template void AndOrSearch<4>::count_listed(std::uint64_t);
template bool AndOrSearch<4>::keep_cuts(std::uint32_t, double, std::span<const CutLister<4>::Found>,
                                        std::span<const std::uint64_t>, double, bool);
template auto AndOrSearch<4>::next_stored_cut(std::uint32_t) const -> std::optional<Cut>;
template std::uint32_t AndOrSearch<8>::node_of(const Set&, std::size_t);
template double AndOrSearch<8>::search_stored(std::uint32_t, double);
template bool AndOrSearch<8>::keeps_all_cuts() const;
template bool AndOrSearch<8>::store_cuts(std::uint32_t, double);
template void AndOrSearch<8>::count_listed(std::uint64_t);
template bool AndOrSearch<8>::keep_cuts(std::uint32_t, double, std::span<const CutLister<8>::Found>,
                                        std::span<const std::uint64_t>, double, bool);
template auto AndOrSearch<8>::next_stored_cut(std::uint32_t) const -> std::optional<Cut>;
template std::uint32_t AndOrSearch<16>::node_of(const Set&, std::size_t);
template double AndOrSearch<16>::search_stored(std::uint32_t, double);
template bool AndOrSearch<16>::keeps_all_cuts() const;
template bool AndOrSearch<16>::store_cuts(std::uint32_t, double);
template void AndOrSearch<16>::count_listed(std::uint64_t);
template bool AndOrSearch<16>::keep_cuts(std::uint32_t, double,
                                         std::span<const CutLister<16>::Found>,
                                         std::span<const std::uint64_t>, double, bool);
template auto AndOrSearch<16>::next_stored_cut(std::uint32_t) const -> std::optional<Cut>;

}  // namespace orasp::detail
