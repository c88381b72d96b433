#include "orasp/bounds/raised_prices.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace orasp {

RaisedPrices::RaisedPrices(const SmallPieces& pieces, std::size_t parts)
    : left_beyond_(pieces.left_beyond()),
      words_((pieces.near_rows().size() + 63) / 64),
      rows_with_(parts * words_) {
  for (const PriceRow& near : pieces.near_rows()) {
    const std::size_t r = rows_.size();
    Row& row = rows_.emplace_back();
    row.size = static_cast<std::uint16_t>(near.size);
    for (std::size_t i = 0; i < near.size; ++i) {
      row.parts[i] = static_cast<std::uint16_t>(near.parts[i]);
      rows_with_[near.parts[i] * words_ + r / 64] |= std::uint64_t{1} << r % 64;
    }
    left_.push_back(near.room);
  }
  none_.parts_.resize(parts);
  std::iota(none_.parts_.begin(), none_.parts_.end(), PartIndex{0});
  none_.of_part_.assign(parts, 0.0);
  none_.held_by_.assign(parts, kNoRow);
  none_.within_.assign(words_, ~std::uint64_t{0});
}

void RaisedPrices::fit(const Raise& from, std::span<const PartIndex> piece, double enough,
                       Raise& into) const {
  into = from;
  into.parts_.assign(piece.begin(), piece.end());
  auto next = piece.begin();
  for (const PartIndex part : from.parts_) {
    if (next != piece.end() && *next == part) {
      ++next;
      continue;
    }
    // Nothing else stands where the rows within stand: several words at a time.
    const std::uint64_t* __restrict const with = rows_with_.data() + part * words_;
    std::uint64_t* __restrict const within = into.within_.data();
    for (std::size_t w = 0; w < words_; ++w) within[w] &= ~with[w];
    into.sum_ -= into.of_part_[part];
    into.of_part_[part] = 0;
  }
  for (const PartIndex part : piece) {
    if (into.sum_ > enough) return;
    const std::uint32_t holds = into.held_by_[part];
    if (holds == kNoRow || !contains(into.within_.data(), holds)) raise_part(part, into);
  }
}

/// Lets a part cost as much more as the rows within the piece allow.
void RaisedPrices::raise_part(PartIndex part, Raise& raise) const {
  const std::uint64_t* const with = rows_with_.data() + part * words_;
  // A row that holds another part down has nothing left.
  for (const PartIndex other : raise.parts_) {
    const std::uint32_t row = raise.held_by_[other];
    if (row == kNoRow || !contains(with, row) || !contains(raise.within_.data(), row)) continue;
    raise.held_by_[part] = row;
    return;
  }
  double room = left_beyond_ - raise.sum_;
  std::uint32_t holds = kNoRow;
  // Each row has at least as much left as the one before it, before anything is raised.
  for (std::size_t w = 0; w < words_ && room > 0 && left_[w * 64] - raise.sum_ < room; ++w) {
    for (std::uint64_t bits = raise.within_[w] & with[w]; bits != 0; bits &= bits - 1) {
      const std::size_t r = w * 64 + static_cast<std::size_t>(std::countr_zero(bits));
      if (left_[r] - raise.sum_ >= room) break;
      const Row& row = rows_[r];
      double left = left_[r];
      for (std::size_t i = 0; i < row.size; ++i) left -= raise.of_part_[row.parts[i]];
      if (left >= room) continue;
      room = left;
      holds = static_cast<std::uint32_t>(r);
      if (room <= 0) break;
    }
  }
  raise.held_by_[part] = holds;
  // Where no condition holds the part down, no cut is legal: the searches find that.
  if (room <= 0 || !std::isfinite(room)) return;
  raise.of_part_[part] += room;
  raise.sum_ += room;
}

}  // namespace orasp
