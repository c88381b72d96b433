#include "orasp/geometry/detail/cell_mask.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace orasp::detail {
namespace {

// How far the next cell outside of the set is in this row, up to `limit`; 0 where the cell itself
// is outside.
int gap_in_row(const CellMask& mask, int column, int row, int limit) {
  if (!mask.has(column, row)) return 0;
  int right = 0;
  for (int at = column; right < limit;) {
    if (at >= mask.columns()) break;
    const std::uint64_t rest = ~(mask.word(row, at >> 6) >> (static_cast<unsigned>(at) & 63U));
    const int here = std::min(64 - (at & 63), std::countr_zero(rest));
    right += here;
    at += here;
    if ((at & 63) != 0 || here == 0) break;
  }
  int left = 0;
  const int most = std::min(limit, right);
  for (int at = column; left < most;) {
    if (at < 0) break;
    const std::uint64_t rest =
        ~(mask.word(row, at >> 6) << (63U - (static_cast<unsigned>(at) & 63U)));
    const int here = std::min((at & 63) + 1, std::countl_zero(rest));
    left += here;
    at -= here;
    if ((at & 63) != 63 || here == 0) break;
  }
  return std::min({limit, right, left});
}

// The square of the distance from a cell of the set to the nearest one outside, or something not
// greater than `least` as soon as it is known not to be.
long squared_radius(const CellMask& mask, int column, int row, long least) {
  const int step = static_cast<int>(std::sqrt(static_cast<double>(least)));
  if (step > 0 && !(mask.has(column, row - step) && mask.has(column, row + step) &&
                    mask.has(column - step, row) && mask.has(column + step, row))) {
    return 0;
  }
  long best = std::numeric_limits<long>::max();
  int limit = std::numeric_limits<int>::max();
  for (int dy = 0; static_cast<long>(dy) * dy < best; ++dy) {
    for (const int y : {row - dy, row + dy}) {
      const long gap = gap_in_row(mask, column, y, limit);
      if (const long found = static_cast<long>(dy) * dy + gap * gap; found < best) {
        best = found;
        limit = static_cast<int>(std::sqrt(static_cast<double>(best))) + 1;
      }
      if (dy == 0) break;
    }
    if (best <= least) return best;
  }
  return best;
}

}  // namespace

WidestPlace widest_place(const CellMask& mask) {
  WidestPlace place;
  if (!mask.any()) return place;
  long best = 0;
  // First a coarse lattice, so that a wide region is known early and most cells are passed over.
  constexpr int kLattice = 5;
  for (int row = kLattice / 2; row < mask.rows(); row += kLattice) {
    for (int column = kLattice / 2; column < mask.columns(); column += kLattice) {
      if (mask.has(column, row)) best = std::max(best, squared_radius(mask, column, row, best));
    }
  }
  best = std::max(0L, best - 1);  // the first one in the order of rows is to be found again
  for (int row = 0; row < mask.rows(); ++row) {
    for (int index = 0; index < mask.words(); ++index) {
      const int step = static_cast<int>(std::sqrt(static_cast<double>(best)));
      std::uint64_t left = mask.word(row, index);
      if (left == 0) continue;
      if (row < step || row + step >= mask.rows()) break;
      left &= mask.word(row - step, index) & mask.word(row + step, index);
      for (; left != 0; left &= left - 1) {
        const int column = index * 64 + std::countr_zero(left);
        const long found = squared_radius(mask, column, row, best);
        if (found <= best) continue;
        best = found;
        place = {std::sqrt(static_cast<double>(found)), column, row};
      }
    }
  }
  return place;
}

}  // namespace orasp::detail
