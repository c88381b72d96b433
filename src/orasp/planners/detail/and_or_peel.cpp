#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

template <std::size_t kWords>
void AndOrSearch<kWords>::peel(std::size_t width) {
  peeled_.clear();
  peeling_ = true;
  lift_limits();
  for (const Set& piece : pieces_) {
    if (!peel_piece(piece, width)) break;
  }
  peeling_ = false;
}

/// Peels one piece of the problem down to a single part, and appends what it did to peeled_. False
/// where it finds no way.
template <std::size_t kWords>
bool AndOrSearch<kWords>::peel_piece(const Set& root, std::size_t width) {
  const std::size_t parts = root.size();
  std::vector<std::vector<Remainder>> by_size(parts + 1);
  by_size[parts].push_back({root, 0, kNone, {}});
  // Those that were followed, the largest first; a remainder's number is its place here.
  std::vector<Remainder> followed;
  for (std::size_t size = parts; size >= 2 && result_.stop == Stop::None; --size) {
    keep_best(by_size[size], width);
    for (const Remainder& remainder : by_size[size]) {
      followed.push_back(remainder);
      peel_once(remainder, static_cast<std::uint32_t>(followed.size() - 1), width, by_size);
      poll();
    }
    by_size[size] = {};
  }
  if (by_size[1].empty()) return false;
  const Remainder* at = &*std::ranges::min_element(by_size[1], {}, &Remainder::loss);
  while (at->before != kNone) {
    peeled_.emplace_back(followed[at->before].piece, at->side);
    at = &followed[at->before];
  }
  return true;
}

/// Adds to `by_size` everything that can be left of `from`, whose number is `number`, when up to
/// kMostPeeled parts are cut off. What is cut off is finished at once, while the rest waits.
template <std::size_t kWords>
void AndOrSearch<kWords>::peel_once(const Remainder& from, std::uint32_t number, std::size_t width,
                                    std::vector<std::vector<Remainder>>& by_size) {
  const std::size_t size = from.piece.size();
  cuts_.clear();
  static_cast<void>(list_cuts(from.piece, size, allowed_, kInfinity));
  const std::vector<Cut> cuts = cuts_;
  cuts_.clear();
  for (const Cut& cut : cuts) {
    const std::size_t cut_parts = cut.side.size();
    const bool side_stays = 2 * cut_parts > size;
    const Set off = side_stays ? from.piece - cut.side : cut.side;
    const std::size_t off_parts = side_stays ? size - cut_parts : cut_parts;
    const bool rest_waits = side_stays ? cut.side_waits : !cut.side_waits;
    const bool one_waits = limited_ && off_parts >= 2 && size - off_parts >= 2;
    const bool off_is_first = one_waits || (last_ != nullptr && off_parts >= 2);
    if (off_parts > kMostPeeled || (off_is_first && !rest_waits)) continue;
    const std::size_t allowed = allowed_ & kMostAllowed;
    const double off_loss =
        search(form_of(off, off_parts), off_parts, one_waits ? allowed - 1 : allowed, kInfinity);
    if (off_loss == kInfinity || result_.stop != Stop::None) continue;
    std::vector<Remainder>& there = by_size[size - off_parts];
    const Set left = from.piece - off;
    const double loss = from.loss + cut.own_loss + off_loss;
    there.push_back({left, loss + bound_of_form_above(left, size - off_parts), number, off});
    if (there.size() > 1024 + 8 * width) keep_best(there, width);
  }
}

/// Keeps the `width` remainders of least loss, of several that are the same piece only the best.
template <std::size_t kWords>
void AndOrSearch<kWords>::keep_best(std::vector<Remainder>& remainders, std::size_t width) {
  std::ranges::sort(remainders, [](const Remainder& a, const Remainder& b) {
    if (a.piece.words != b.piece.words) return a.piece.words < b.piece.words;
    return a.loss != b.loss ? a.loss < b.loss : a.before < b.before;
  });
  const auto same = std::ranges::unique(
      remainders, {}, [](const Remainder& remainder) { return remainder.piece.words; });
  remainders.erase(same.begin(), same.end());
  std::ranges::stable_sort(remainders, {}, &Remainder::loss);
  if (remainders.size() > width) remainders.resize(width);
}

template void AndOrSearch<1>::peel(std::size_t);
template void AndOrSearch<2>::peel(std::size_t);
template void AndOrSearch<4>::peel(std::size_t);
template void AndOrSearch<8>::peel(std::size_t);
template void AndOrSearch<16>::peel(std::size_t);

}  // namespace orasp::detail
