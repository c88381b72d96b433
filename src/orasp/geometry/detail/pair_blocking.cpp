#include "orasp/geometry/detail/pair_blocking.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace orasp::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kCoarseCells = 4096;   // lines of a first look
constexpr double kSingleCells = 9216;   // so few fine lines are looked at without a first look
constexpr double kFineLines = 600'000;  // lines of a second look at most
constexpr int kSharper = 4;             // cuts of a fine cell where a width lies near the limit
constexpr double kManyCuts = 12;        // of a cell of the first look: cut in two steps
constexpr double kFineGrid = 64e6;      // cells of the grid that those are chosen from at most

// The side of the cells of a first look: so that no more than about kCoarseCells cover the
// rectangle, and a long narrow one still has a few across.
double coarse_side(const Rectangle& r, double finest) {
  const double by_area = std::sqrt(r.width() * r.height() / kCoarseCells);
  const double by_length = std::max(r.width(), r.height()) / 4096;
  return std::max({finest, by_area, by_length});
}

}  // namespace

double PairBlocking::beyond(int side, std::size_t line) const {
  return extremes_[1 - side].last[line] - extremes_[side].first[line];
}

// Finds the extremes that the open sides need. A line leaves a closed part for the last time where
// the surface faces along it, and enters it first where the surface faces against it: the other
// triangles need no look.
template <class Cells>
void PairBlocking::look(const Cells& cells, const PairView& pair, const std::array<bool, 2>& open) {
  for (std::size_t part = 0; part < 2; ++part) {
    const bool needs_first = open[part] || pair.overlap;
    const bool needs_last = open[1 - part] || pair.overlap;
    Extremes& extremes = extremes_[part];
    if (needs_first) extremes.first.assign(cells.lines(), kInfinity);
    if (needs_last) extremes.last.assign(cells.lines(), -kInfinity);
    double* const first = extremes.first.data();
    double* const last = extremes.last.data();
    const bool turned = pair.inside_out[part];
    for (const Corners& c : triangles_[part]) {
      if (pair.closed[part]) {
        const bool leaves = (twice_shadow(c) > 0) != turned;
        if (leaves ? !needs_last : !needs_first) continue;
        if (leaves) {
          cells.for_lines(c, [=](std::size_t line, double height, bool) {
            last[line] = std::max(last[line], height);
          });
        } else {
          cells.for_lines(c, [=](std::size_t line, double height, bool) {
            first[line] = std::min(first[line], height);
          });
        }
        continue;
      }
      cells.for_lines(c, [=](std::size_t line, double height, bool) {
        if (needs_first) first[line] = std::min(first[line], height);
        if (needs_last) last[line] = std::max(last[line], height);
      });
    }
  }
}

template <class Cells>
double PairBlocking::depth_at(const Cells& cells, int side, const WidestPlace& place) const {
  double depth = 0;
  const int reach = static_cast<int>(place.radius);
  for (int row = place.row - reach; row <= place.row + reach; ++row) {
    for (int column = place.column - reach; column <= place.column + reach; ++column) {
      const double away = std::hypot(row - place.row, column - place.column);
      if (away >= place.radius || row < 0 || column < 0 || row >= cells.grid().rows ||
          column >= cells.grid().columns) {
        continue;
      }
      const std::size_t line = cells.line_at(column, row);
      if (line != kNone) depth = std::max(depth, beyond(side, line));
    }
  }
  return depth;
}

// Marks in without_ the lines that stay blocked where one part gives way to the other. Where the
// mover begins before the other part does, taking that away leaves its beginning, and where the
// other ends after the mover its end: most lines are settled without their intervals.
template <class Cells>
void PairBlocking::subtract(const Cells& cells, const PairView& pair, int side) {
  const auto mover = static_cast<std::size_t>(side);
  const std::size_t other = 1 - mover;
  const double sliver = pair.tolerance / 2;
  slots_.assign(cells.lines(), Crossings::kNoSlot);
  lines_.clear();
  for (CellMask& mask : without_) mask.reset(cells.grid().columns, cells.grid().rows);
  for (std::size_t line = 0; line < cells.lines(); ++line) {
    if (beyond(side, line) <= pair.tolerance) continue;
    const bool begins = extremes_[mover].first[line] < extremes_[other].first[line] - sliver;
    const bool ends = extremes_[other].last[line] > extremes_[mover].last[line] + sliver;
    if (begins && ends) {
      for (CellMask& mask : without_) mask.add(cells.column(line), cells.row(line));
      continue;
    }
    slots_[line] = static_cast<std::uint32_t>(lines_.size());
    lines_.push_back(static_cast<std::uint32_t>(line));
  }
  if (lines_.empty()) return;
  for (std::size_t part = 0; part < 2; ++part) {
    crossings_[part].collect(cells, triangles_[part], slots_, lines_.size(), pair.inside_out[part]);
  }
  for (std::size_t slot = 0; slot < lines_.size(); ++slot) {
    const std::size_t line = lines_[slot];
    for (std::size_t part = 0; part < 2; ++part) {
      crossings_[part].intervals(slot, intervals_[part]);
    }
    const int column = cells.column(line);
    const int row = cells.row(line);
    const Remains moved = remains(intervals_[mover], intervals_[other], sliver);
    if (extremes_[other].last[line] - moved.first > pair.tolerance) without_[0].add(column, row);
    const Remains met = remains(intervals_[other], intervals_[mover], sliver);
    if (met.last - extremes_[mover].first[line] > pair.tolerance) without_[1].add(column, row);
  }
}

// The widest region of lines on which the other part lies beyond the mover. Where it is no wider
// than `narrowest` cells nobody asks what is left of it after subtraction.
template <class Cells>
PairBlocking::Region PairBlocking::judge(const Cells& cells, const PairView& pair, int side,
                                         double narrowest) {
  mask_.reset(cells.grid().columns, cells.grid().rows);
  for (std::size_t line = 0; line < cells.lines(); ++line) {
    if (beyond(side, line) > pair.tolerance) mask_.add(cells.column(line), cells.row(line));
  }
  Region region;
  region.place = widest_place(mask_);
  if (pair.overlap && region.place.radius > 0 && 2 * region.place.radius > narrowest) {
    subtract(cells, pair, side);
    const WidestPlace one = widest_place(without_[0]);
    if (one.radius < region.place.radius) region.place = one;
    const WidestPlace two = widest_place(without_[1]);
    if (two.radius < region.place.radius) region.place = two;
  }
  if (region.place.radius > 0) region.depth = depth_at(cells, side, region.place);
  return region;
}

// The same region on lines kSharper times as close, where blocked lines stand: for a width so near
// the limit that the distance of the lines would decide.
template <class Cells>
PairBlocking::Region PairBlocking::sharpened(const Cells& cells, const PairView& pair, int side,
                                             double narrowest) {
  const Grid& coarse = cells.coarse_grid();
  const int times = cells.times();
  std::vector<std::uint8_t> chosen(coarse.cells(), 0);
  double count = 0;
  for (std::size_t line = 0; line < cells.lines(); ++line) {
    if (beyond(side, line) <= pair.tolerance) continue;
    const int column = cells.column(line);
    const int row = cells.row(line);
    for (int y = std::max(0, row - 1) / times; y <= std::min((row + 1) / times, coarse.rows - 1);
         ++y) {
      for (int x = std::max(0, column - 1) / times;
           x <= std::min((column + 1) / times, coarse.columns - 1); ++x) {
        std::uint8_t& cell =
            chosen[static_cast<std::size_t>(y) * static_cast<std::size_t>(coarse.columns) +
                   static_cast<std::size_t>(x)];
        count += cell == 0 ? 1 : 0;
        cell = 1;
      }
    }
  }
  const double most = std::min(kFineLines / count, kFineGrid / static_cast<double>(coarse.cells()));
  const int sharper = std::min(kSharper, static_cast<int>(std::sqrt(most)) / times);
  if (sharper < 2) return {};
  std::swap(extremes_, aside_);
  sharp_.reset(coarse, times * sharper, chosen);
  std::array<bool, 2> open = {};
  open[static_cast<std::size_t>(side)] = true;
  look(sharp_, pair, open);
  Region region = judge(sharp_, pair, side, narrowest * sharper);
  region.cell = sharp_.grid().side;
  std::swap(extremes_, aside_);
  return region;
}

// Chooses, of the whole of a grid, the cells in which some of the one part may lie beyond some of
// the other, and says how many there are.
template <class Cells>
std::size_t PairBlocking::choose_cells(const Cells& cells, const PairView& pair,
                                       const std::array<bool, 2>& open) {
  for (std::size_t part = 0; part < 2; ++part) {
    low_[part].assign(cells.lines(), kInfinity);
    high_[part].assign(cells.lines(), -kInfinity);
    double* const lows = low_[part].data();
    double* const highs = high_[part].data();
    for (const Corners& c : triangles_[part]) {
      cells.for_cells(c, [=](std::size_t cell, const Interval& heights) {
        lows[cell] = std::min(lows[cell], heights.low);
        highs[cell] = std::max(highs[cell], heights.high);
      });
    }
  }
  const Grid& grid = cells.grid();
  chosen_.assign(grid.cells(), 0);
  std::size_t count = 0;
  for (std::size_t cell = 0; cell < cells.lines(); ++cell) {
    if ((open[0] && high_[1][cell] - low_[0][cell] > pair.tolerance) ||
        (open[1] && high_[0][cell] - low_[1][cell] > pair.tolerance)) {
      chosen_[static_cast<std::size_t>(cells.row(cell)) * static_cast<std::size_t>(grid.columns) +
              static_cast<std::size_t>(cells.column(cell))] = 1;
      ++count;
    }
  }
  return count;
}

// Chooses the lines of the second look, in the cells that may be blocked. Where a cell of the first
// look would be cut into many, it is first cut into some, and only those that may be blocked are
// cut further: along the outline of a shadow they are few.
void PairBlocking::choose_lines(const AllCells& coarse, const PairView& pair,
                                const std::array<bool, 2>& open, double finest) {
  std::size_t count = choose_cells(coarse, pair, open);
  Grid grid = coarse.grid();
  if (count > 0 && grid.side > kManyCuts * finest) {
    const auto cuts = static_cast<int>(std::min(16.0, std::sqrt(grid.side / finest)));
    middle_.reset(grid, cuts, chosen_);
    count = choose_cells(middle_, pair, open);
    grid = middle_.grid();
  }
  const double wanted = std::ceil(grid.side / finest - 1e-9);
  const double most = std::sqrt(std::min(kFineLines / static_cast<double>(count),
                                         kFineGrid / static_cast<double>(grid.cells())));
  const int times = static_cast<int>(std::max(1.0, std::floor(std::min(wanted, most))));
  fine_.reset(grid, times, chosen_);
}

std::array<PairVerdict, 2> PairBlocking::decide(const PairView& pair) {
  std::array<PairVerdict, 2> verdicts;
  const Box& a = pair.a->box;
  const Box& b = pair.b->box;
  const Rectangle shadow = {std::max(a.low[0], b.low[0]), std::min(a.high[0], b.high[0]),
                            std::max(a.low[1], b.low[1]), std::min(a.high[1], b.high[1])};
  std::array<bool, 2> open = {b.high[2] - a.low[2] > pair.tolerance,
                              a.high[2] - b.low[2] > pair.tolerance};
  const double narrow = std::min(shadow.width(), shadow.height());
  if (!(narrow > pair.width_limit) || !std::isfinite(shadow.width() * shadow.height())) {
    return verdicts;
  }
  gather(*pair.a, pair.frame, shadow, triangles_[0]);
  gather(*pair.b, pair.frame, shadow, triangles_[1]);
  if (triangles_[0].empty() || triangles_[1].empty()) return verdicts;
  const double finest = std::max(pair.tolerance / 2, pair.width_limit / 12);
  const bool single = shadow.width() / finest * (shadow.height() / finest) <= kSingleCells;
  const AllCells coarse(Grid::over(shadow, single ? finest : coarse_side(shadow, finest)));

  // Looks at the open sides from one raster, and closes those with a region at least `doubt` cells
  // wider than the limit.
  const auto settle = [&](const auto& cells, double doubt, bool last) {
    const double cell = cells.grid().side;
    look(cells, pair, open);
    for (std::size_t s = 0; s < 2; ++s) {
      if (!open[s]) continue;
      const double narrowest = pair.width_limit / cell - (last ? 1.5 : -doubt);
      Region region = judge(cells, pair, static_cast<int>(s), narrowest);
      region.cell = cell;
      double limit = pair.width_limit + doubt * cell;
      if (last && std::abs(region.width() - limit) < 1.5 * cell) {
        const Region sharp = sharpened(cells, pair, static_cast<int>(s), narrowest);
        // Drawings like widths of just the limit: they count as narrow, however the lines fall.
        if (sharp.cell > 0) region = sharp;
        if (sharp.cell > 0) limit += sharp.cell;
      }
      if (region.width() > limit) {
        verdicts[s] = {true, region.width(), region.depth};
        open[s] = false;
      }
    }
  };
  settle(coarse, single ? 0.0 : 1.5, single);
  if (single || (!open[0] && !open[1])) return verdicts;

  choose_lines(coarse, pair, open, finest);
  if (fine_.lines() == 0) return verdicts;
  settle(fine_, 0.0, true);
  return verdicts;
}

}  // namespace orasp::detail
