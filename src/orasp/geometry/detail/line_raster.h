#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "orasp/geometry/detail/frame.h"
#include "orasp/geometry/detail/triangle_tree.h"

namespace orasp::detail {

/// A stretch along a line.
struct Interval {
  double low = 0.0;
  double high = 0.0;
};

/// A rectangle across the lines of sight.
struct Rectangle {
  double low_u, high_u, low_v, high_v;

  [[nodiscard]] double width() const { return high_u - low_u; }
  [[nodiscard]] double height() const { return high_v - low_v; }
};

/// Square cells over a rectangle; the centre of each is a line of sight.
struct Grid {
  double low_u = 0.0;
  double low_v = 0.0;
  double side = 1.0;
  double per_mm = 1.0;  ///< 1 / side
  int columns = 0;
  int rows = 0;

  /// The grid of cells of this side that just covers a rectangle. It begins a crooked share of a
  /// cell outside, for lines through the middle of a part meet more edges and corners than others.
  [[nodiscard]] static Grid over(const Rectangle& rectangle, double side);
  [[nodiscard]] std::size_t cells() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// The same rectangle with each cell cut into times x times.
  [[nodiscard]] Grid finer(int times) const {
    return {low_u, low_v, side / times, times / side, columns * times, rows * times};
  }
  [[nodiscard]] double centre_u(int column) const { return low_u + (column + 0.5) * side; }
  [[nodiscard]] double centre_v(int row) const { return low_v + (row + 0.5) * side; }
  /// The first column or row whose centre is not below a place, from 0 to the number of them.
  [[nodiscard]] int first_column(double u) const { return first((u - low_u) * per_mm, columns); }
  [[nodiscard]] int first_row(double v) const { return first((v - low_v) * per_mm, rows); }
  /// The cell that holds a place, pressed into the grid.
  [[nodiscard]] int column_of(double u) const { return cell((u - low_u) * per_mm, columns); }
  [[nodiscard]] int row_of(double v) const { return cell((v - low_v) * per_mm, rows); }

 private:
  // Written so that a number that is none gives some place as well.
  [[nodiscard]] static double within(double place, double last) {
    return std::max(0.0, std::min(last, place));
  }
  [[nodiscard]] static int first(double place, int size) {
    const double from = within(place - 0.5, size);
    const int whole = static_cast<int>(from);
    return whole + (static_cast<double>(whole) < from ? 1 : 0);
  }
  [[nodiscard]] static int cell(double place, int size) {
    return static_cast<int>(within(place, size - 1.0));
  }
};

/// A part as seen along a direction: its vertices in the frame of that direction, w along it.
struct View {
  const TriangleTree* tree = nullptr;
  const std::vector<Vector3>* points = nullptr;  ///< turned, by number of vertex; or none yet
  Box box;                                       ///< of the turned triangles
};

/// The triangles of a part whose shadow may reach into a rectangle, found through its tree and
/// turned.
void gather(const View& view, const Frame& frame, const Rectangle& rectangle,
            std::vector<Corners>& triangles);

/// Twice the area of the shadow; positive where the triangle faces along the direction.
[[nodiscard]] inline double twice_shadow(const Corners& c) {
  return (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (c[1][1] - c[0][1]);
}

/// A triangle prepared for sampling: the height over (u, v) is that of its plane, held between the
/// heights of its corners, so that a steep triangle gives no wild numbers.
struct Slope {
  double u, v, w, along_u, along_v, low_w, high_w;

  explicit Slope(const Corners& c) : u(c[0][0]), v(c[0][1]), w(c[0][2]) {
    const Vector3 p = minus(c[1], c[0]);
    const Vector3 q = minus(c[2], c[0]);
    const double twice = twice_shadow(c);
    along_u = (p[2] * q[1] - q[2] * p[1]) / twice;
    along_v = (p[0] * q[2] - q[0] * p[2]) / twice;
    low_w = std::min({c[0][2], c[1][2], c[2][2]});
    high_w = std::max({c[0][2], c[1][2], c[2][2]});
    if (!std::isfinite(along_u + along_v)) {
      along_u = along_v = 0;
      w = (low_w + high_w) / 2;
    }
  }
  [[nodiscard]] double at(double at_u, double at_v) const {
    return std::clamp(w + (at_u - u) * along_u + (at_v - v) * along_v, low_w, high_w);
  }
};

/// Where the line at height v meets the outline of a triangle, [low, high), and whether the
/// triangle faces along the direction there. All of it follows from where the edges cross the line,
/// and each edge is walked from its lower end, so that two triangles at an edge agree on it to the
/// last bit: no line of sight slips between them or meets both, and it leaves a closed surface as
/// often as it enters it, however thin the triangles are.
struct Span {
  double low = 0.0;
  double high = 0.0;
  bool up = false;
};
[[nodiscard]] inline Span span_at(const Corners& c, double v) {
  double found[2] = {0, 0};
  bool first_rises = false;
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3 && count < 2; ++k) {
    const Vector3* low = &c[k];
    const Vector3* high = &c[k == 2 ? 0 : k + 1];
    const bool rises = (*low)[1] < (*high)[1];
    if (!rises) std::swap(low, high);
    if (v < (*low)[1] || v >= (*high)[1]) continue;
    if (count == 0) first_rises = rises;
    found[count++] =
        (*low)[0] + (v - (*low)[1]) * (((*high)[0] - (*low)[0]) / ((*high)[1] - (*low)[1]));
  }
  if (count < 2) return {};
  if (found[0] < found[1]) return {found[0], found[1], !first_rises};
  return {found[1], found[0], first_rises};
}

/// Calls meet(row, first column, end column, slope, up) for each run of lines that a triangle
/// meets.
template <class Meet>
void for_runs(const Grid& grid, const Corners& c, Meet&& meet) {
  const int begin = grid.first_row(std::min({c[0][1], c[1][1], c[2][1]}));
  const int end = grid.first_row(std::max({c[0][1], c[1][1], c[2][1]}));
  if (begin >= end) return;
  const int left = grid.first_column(std::min({c[0][0], c[1][0], c[2][0]}));
  const int right = grid.first_column(std::max({c[0][0], c[1][0], c[2][0]}));
  if (left >= right) return;
  const Slope slope(c);
  for (int row = begin; row < end; ++row) {
    const Span span = span_at(c, grid.centre_v(row));
    const int first = grid.first_column(span.low);
    const int last = grid.first_column(span.high);
    if (first < last) meet(row, first, last, slope, span.up);
  }
}

/// Bounds on the heights of a triangle over the cells of a grid.
class CellBounds {
 public:
  CellBounds(const Grid& grid, const Corners& c)
      : grid_(grid),
        slope_(c),
        reach_((std::abs(slope_.along_u) + std::abs(slope_.along_v)) * grid.side / 2),
        upright_(twice_shadow(c) == 0 || !std::isfinite(reach_)) {}

  [[nodiscard]] Interval over(int column, int row) const {
    double low = slope_.low_w;
    double high = slope_.high_w;
    if (!upright_) {
      const double middle = slope_.w + (grid_.centre_u(column) - slope_.u) * slope_.along_u +
                            (grid_.centre_v(row) - slope_.v) * slope_.along_v;
      low = std::max(low, std::min(high, middle - reach_));
      high = std::min(high, std::max(low, middle + reach_));
    }
    return {low, high};
  }

 private:
  const Grid& grid_;
  Slope slope_;
  double reach_;
  bool upright_;
};

/// What a triangle covers along u of the row of cells from low_v to high_v; empty where low > high.
[[nodiscard]] inline Interval reach_in_row(const Corners& c, double low_v, double high_v) {
  Interval reach{1e300, -1e300};
  const auto reach_to = [&](double u) {
    reach.low = std::min(reach.low, u);
    reach.high = std::max(reach.high, u);
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3& p = c[k];
    const Vector3& q = c[k == 2 ? 0 : k + 1];
    if (p[1] >= low_v && p[1] <= high_v) reach_to(p[0]);
    for (const double v : {low_v, high_v}) {
      if ((p[1] < v) != (q[1] < v)) reach_to(p[0] + (v - p[1]) / (q[1] - p[1]) * (q[0] - p[0]));
    }
  }
  return reach;
}

/// No line.
inline constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// All cells of a grid, one line each.
class AllCells {
 public:
  explicit AllCells(const Grid& grid) : grid_(grid) {}

  [[nodiscard]] const Grid& grid() const { return grid_; }
  [[nodiscard]] const Grid& coarse_grid() const { return grid_; }
  [[nodiscard]] int times() const { return 1; }
  [[nodiscard]] std::size_t lines() const { return grid_.cells(); }
  [[nodiscard]] int column(std::size_t line) const {
    return static_cast<int>(line % static_cast<std::size_t>(grid_.columns));
  }
  [[nodiscard]] int row(std::size_t line) const {
    return static_cast<int>(line / static_cast<std::size_t>(grid_.columns));
  }
  [[nodiscard]] std::size_t line_at(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid_.columns) +
           static_cast<std::size_t>(column);
  }
  template <class Meet>
  void for_lines(const Corners& c, Meet&& meet) const {
    for_runs(grid_, c, [&](int row, int first, int last, const Slope& slope, bool up) {
      const std::size_t base = line_at(0, row);
      const double v = grid_.centre_v(row);
      for (int column = first; column < last; ++column) {
        meet(base + static_cast<std::size_t>(column), slope.at(grid_.centre_u(column), v), up);
      }
    });
  }
  /// Calls meet(cell, bounds of heights there) for each cell that a triangle reaches into. One that
  /// stands upright reaches into the cells below it.
  template <class Meet>
  void for_cells(const Corners& c, Meet&& meet) const {
    const CellBounds bounds(grid_, c);
    const int end = grid_.row_of(std::max({c[0][1], c[1][1], c[2][1]}));
    for (int row = grid_.row_of(std::min({c[0][1], c[1][1], c[2][1]})); row <= end; ++row) {
      const double low_v = grid_.low_v + row * grid_.side;
      const Interval reach = reach_in_row(c, low_v, low_v + grid_.side);
      if (reach.low > reach.high || reach.high < grid_.low_u ||
          reach.low > grid_.low_u + grid_.side * grid_.columns) {
        continue;
      }
      const int last = grid_.column_of(reach.high);
      for (int column = grid_.column_of(reach.low); column <= last; ++column) {
        meet(line_at(column, row), bounds.over(column, row));
      }
    }
  }

 private:
  Grid grid_;
};

/// Chosen cells of a grid, each cut into times x times lines, which are numbered cell by cell.
class FineCells {
 public:
  void reset(const Grid& coarse, int times, const std::vector<std::uint8_t>& chosen);

  [[nodiscard]] const Grid& grid() const { return fine_; }
  [[nodiscard]] const Grid& coarse_grid() const { return coarse_; }
  [[nodiscard]] int times() const { return times_; }  ///< fine cells along the side of a coarse one
  [[nodiscard]] std::size_t lines() const { return cells_.size() * per_cell_; }
  /// Column and row in the fine grid of a line.
  [[nodiscard]] int column(std::size_t line) const;
  [[nodiscard]] int row(std::size_t line) const;
  /// The line of a column and row; kNone where its cell is not chosen.
  [[nodiscard]] std::size_t line_at(int column, int row) const;

  /// Calls meet(line, height, up) for each line that a triangle meets.
  template <class Meet>
  void for_lines(const Corners& c, Meet&& meet) const;
  /// Calls meet(line, bounds of heights there) for each fine cell that a triangle reaches into.
  template <class Meet>
  void for_cells(const Corners& c, Meet&& meet) const;

 private:
  // Calls work(coarse row, first chosen cell, end of the row's cells) for the rows of cells that a
  // triangle from column `left` to `right` and row `begin` to `last` may reach into.
  template <class Work>
  void for_chosen(int left, int right, int begin, int last, Work&& work) const;

  Grid coarse_;
  Grid fine_;
  int times_ = 1;
  std::size_t per_cell_ = 1;
  std::vector<std::uint32_t> cells_;      // chosen cells, by row and column
  std::vector<std::uint32_t> row_begin_;  // of each coarse row in cells_
};

template <class Work>
void FineCells::for_chosen(int left, int right, int begin, int last, Work&& work) const {
  const auto columns = static_cast<std::uint32_t>(coarse_.columns);
  for (int row = begin / times_; row <= last / times_; ++row) {
    const auto* const first = cells_.data() + row_begin_[static_cast<std::size_t>(row)];
    const auto* const end = cells_.data() + row_begin_[static_cast<std::size_t>(row) + 1];
    const auto base = static_cast<std::uint32_t>(row) * columns;
    const auto* const from =
        std::lower_bound(first, end, base + static_cast<std::uint32_t>(left / times_));
    if (from == end || *from > base + static_cast<std::uint32_t>(right / times_)) continue;
    work(row, from, end);
  }
}

template <class Meet>
void FineCells::for_lines(const Corners& c, Meet&& meet) const {
  const int begin = fine_.first_row(std::min({c[0][1], c[1][1], c[2][1]}));
  const int end = fine_.first_row(std::max({c[0][1], c[1][1], c[2][1]}));
  const int left = fine_.first_column(std::min({c[0][0], c[1][0], c[2][0]}));
  const int right = fine_.first_column(std::max({c[0][0], c[1][0], c[2][0]}));
  if (begin >= end || left >= right) return;
  const Slope slope(c);
  for_chosen(
      left, right - 1, begin, end - 1, [&](int coarse_row, const auto* from, const auto* to) {
        const int first_row = coarse_row * times_;
        const auto base = static_cast<std::uint32_t>(coarse_row * coarse_.columns);
        for (int row = std::max(begin, first_row); row < std::min(end, first_row + times_); ++row) {
          const double v = fine_.centre_v(row);
          const Span span = span_at(c, v);
          const int span_begin = fine_.first_column(span.low);
          const int span_end = fine_.first_column(span.high);
          if (span_begin >= span_end) continue;
          for (const auto* cell = from; cell != to; ++cell) {
            const int cell_begin = static_cast<int>(*cell - base) * times_;
            if (cell_begin >= span_end) break;
            const int run_end = std::min(span_end, cell_begin + times_);
            const std::size_t row_line =
                static_cast<std::size_t>(cell - cells_.data()) * per_cell_ +
                static_cast<std::size_t>((row - first_row) * times_);
            for (int column = std::max(span_begin, cell_begin); column < run_end; ++column) {
              meet(row_line + static_cast<std::size_t>(column - cell_begin),
                   slope.at(fine_.centre_u(column), v), span.up);
            }
          }
        }
      });
}

template <class Meet>
void FineCells::for_cells(const Corners& c, Meet&& meet) const {
  const CellBounds bounds(fine_, c);
  const int begin = fine_.row_of(std::min({c[0][1], c[1][1], c[2][1]}));
  const int last = fine_.row_of(std::max({c[0][1], c[1][1], c[2][1]}));
  const int left = fine_.column_of(std::min({c[0][0], c[1][0], c[2][0]}));
  const int right = fine_.column_of(std::max({c[0][0], c[1][0], c[2][0]}));
  for_chosen(left, right, begin, last, [&](int coarse_row, const auto* from, const auto* to) {
    const int first_row = coarse_row * times_;
    const auto base = static_cast<std::uint32_t>(coarse_row * coarse_.columns);
    for (int row = std::max(begin, first_row); row <= std::min(last, first_row + times_ - 1);
         ++row) {
      const double low_v = fine_.low_v + row * fine_.side;
      const Interval reach = reach_in_row(c, low_v, low_v + fine_.side);
      if (reach.low > reach.high) continue;
      const int reach_begin = fine_.column_of(reach.low);
      const int reach_last = fine_.column_of(reach.high);
      for (const auto* cell = from; cell != to; ++cell) {
        const int cell_begin = static_cast<int>(*cell - base) * times_;
        if (cell_begin > reach_last) break;
        const int run_last = std::min(reach_last, cell_begin + times_ - 1);
        const std::size_t row_line = static_cast<std::size_t>(cell - cells_.data()) * per_cell_ +
                                     static_cast<std::size_t>((row - first_row) * times_);
        for (int column = std::max(reach_begin, cell_begin); column <= run_last; ++column) {
          meet(row_line + static_cast<std::size_t>(column - cell_begin), bounds.over(column, row));
        }
      }
    }
  });
}

}  // namespace orasp::detail
