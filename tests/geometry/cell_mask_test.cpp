#include "orasp/geometry/detail/cell_mask.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "orasp/model/random.h"

namespace orasp::detail {
namespace {

// The same by looking from each cell at each other one.
double widest_by_hand(const CellMask& mask) {
  double widest = 0;
  for (int row = 0; row < mask.rows(); ++row) {
    for (int column = 0; column < mask.columns(); ++column) {
      double nearest = 1e300;
      for (int y = -1; y <= mask.rows(); ++y) {
        for (int x = -1; x <= mask.columns(); ++x) {
          if (!mask.has(x, y)) nearest = std::min(nearest, std::hypot(x - column, y - row));
        }
      }
      widest = std::max(widest, nearest);
    }
  }
  return widest;
}

TEST(WidestPlace, OfTheEmptySetIsNone) {
  CellMask mask;
  mask.reset(100, 3);
  EXPECT_EQ(widest_place(mask).radius, 0);
}

TEST(WidestPlace, OfAStripLiesInItsMiddle) {
  CellMask mask;
  mask.reset(200, 100);
  for (int row = 40; row < 47; ++row) {
    for (int column = 0; column < 200; ++column) mask.add(column, row);
  }
  const WidestPlace place = widest_place(mask);
  EXPECT_EQ(place.radius, 4);
  EXPECT_EQ(place.row, 43);
  EXPECT_EQ(place.column, 3);  // the first one that is as far from the grid's border
}

TEST(WidestPlace, IsThatOfALookFromEachCellAtEachOther) {
  SplitMix64 random(11);
  for (int round = 0; round < 60; ++round) {
    CellMask mask;
    const int columns = 1 + static_cast<int>(random.below(round % 2 == 0 ? 40 : 140));
    mask.reset(columns, 1 + static_cast<int>(random.below(30)));
    // Filled, but for some discs and some single cells.
    const double holes = random.uniform() * 0.02;
    const double u = random.uniform() * columns;
    const double v = random.uniform() * mask.rows();
    for (int row = 0; row < mask.rows(); ++row) {
      for (int column = 0; column < columns; ++column) {
        if (random.uniform() < holes || std::hypot(column - u, row - v) < 5) continue;
        mask.add(column, row);
      }
    }
    EXPECT_NEAR(widest_place(mask).radius, widest_by_hand(mask), 1e-9) << round;
  }
}

}  // namespace
}  // namespace orasp::detail
