#include "orasp/geometry/detail/line_raster.h"

#include <algorithm>
#include <cmath>

namespace orasp::detail {

Grid Grid::over(const Rectangle& rectangle, double side) {
  constexpr double kShiftU = 0.1374;
  constexpr double kShiftV = 0.2917;
  const auto cells = [side](double extent, double shift) {
    return static_cast<int>(std::clamp(std::ceil(extent / side + shift), 1.0, 16384.0));
  };
  Grid grid;
  grid.side = side;
  grid.per_mm = 1 / side;
  grid.columns = cells(rectangle.width(), kShiftU);
  grid.rows = cells(rectangle.height(), kShiftV);
  grid.low_u = rectangle.low_u - kShiftU * side;
  grid.low_v = rectangle.low_v - kShiftV * side;
  return grid;
}

void gather(const View& view, const Frame& frame, const Rectangle& rectangle,
            std::vector<Corners>& triangles) {
  triangles.clear();
  const TriangleTree& tree = *view.tree;
  if (tree.empty()) return;
  const auto reaches = [](double low, double high, double from, double to) {
    return low <= to && high >= from;
  };
  const double slack = 1e-9 * (rectangle.width() + rectangle.height() + view.box.diagonal());
  std::size_t stack[130];
  std::size_t depth = 0;
  stack[depth++] = 1;
  while (depth > 0) {
    const std::size_t node = stack[--depth];
    const Box& box = tree.box(node);
    if (box.low[0] > box.high[0]) continue;
    const Vector3 middle = times(plus(box.low, box.high), 0.5);
    const Vector3 half = times(minus(box.high, box.low), 0.5);
    const auto meets = [&](const Vector3& axis, double from, double to) {
      const double at = dot(axis, middle);
      const double extent = std::abs(axis[0]) * half[0] + std::abs(axis[1]) * half[1] +
                            std::abs(axis[2]) * half[2] + slack;
      return reaches(at - extent, at + extent, from, to);
    };
    if (!meets(frame.u, rectangle.low_u, rectangle.high_u) ||
        !meets(frame.v, rectangle.low_v, rectangle.high_v)) {
      continue;
    }
    if (!tree.is_leaf(node)) {
      stack[depth++] = 2 * node + 1;
      stack[depth++] = 2 * node;
      continue;
    }
    for (std::size_t i = tree.begin(node); i < tree.end(node); ++i) {
      const auto& t = tree.triangle(i);
      Corners c;
      for (std::size_t k = 0; k < 3; ++k) {
        c[k] = view.points != nullptr ? (*view.points)[t[k]] : frame.turned(tree.vertices()[t[k]]);
      }
      if (reaches(std::min({c[0][0], c[1][0], c[2][0]}), std::max({c[0][0], c[1][0], c[2][0]}),
                  rectangle.low_u, rectangle.high_u) &&
          reaches(std::min({c[0][1], c[1][1], c[2][1]}), std::max({c[0][1], c[1][1], c[2][1]}),
                  rectangle.low_v, rectangle.high_v)) {
        triangles.push_back(c);
      }
    }
  }
}

void FineCells::reset(const Grid& coarse, int times, const std::vector<std::uint8_t>& chosen) {
  coarse_ = coarse;
  fine_ = coarse.finer(times);
  times_ = times;
  per_cell_ = static_cast<std::size_t>(times) * static_cast<std::size_t>(times);
  cells_.clear();
  row_begin_.assign(static_cast<std::size_t>(coarse.rows) + 1, 0);
  for (int row = 0; row < coarse.rows; ++row) {
    const std::size_t base =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(coarse.columns);
    for (std::size_t i = 0; i < static_cast<std::size_t>(coarse.columns); ++i) {
      if (chosen[base + i] != 0) cells_.push_back(static_cast<std::uint32_t>(base + i));
    }
    row_begin_[static_cast<std::size_t>(row) + 1] = static_cast<std::uint32_t>(cells_.size());
  }
}

int FineCells::column(std::size_t line) const {
  const std::uint32_t cell = cells_[line / per_cell_];
  const auto within = static_cast<int>(line % per_cell_ % static_cast<std::size_t>(times_));
  return static_cast<int>(cell % static_cast<std::uint32_t>(coarse_.columns)) * times_ + within;
}

int FineCells::row(std::size_t line) const {
  const std::uint32_t cell = cells_[line / per_cell_];
  const auto within = static_cast<int>(line % per_cell_ / static_cast<std::size_t>(times_));
  return static_cast<int>(cell / static_cast<std::uint32_t>(coarse_.columns)) * times_ + within;
}

std::size_t FineCells::line_at(int column, int row) const {
  const auto cell = static_cast<std::uint32_t>(row / times_ * coarse_.columns + column / times_);
  const auto found = std::lower_bound(cells_.begin(), cells_.end(), cell);
  if (found == cells_.end() || *found != cell) return kNone;
  return static_cast<std::size_t>(found - cells_.begin()) * per_cell_ +
         static_cast<std::size_t>(row % times_ * times_ + column % times_);
}

}  // namespace orasp::detail
