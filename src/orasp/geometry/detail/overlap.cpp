#include "orasp/geometry/detail/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "orasp/geometry/detail/frame.h"
#include "orasp/geometry/detail/line_intervals.h"
#include "orasp/geometry/detail/line_raster.h"

namespace orasp::detail {
namespace {

constexpr double kFewLines = 2304;      // of the raster along one axis that looks for an overlap
constexpr double kLines = 16384;        // of the one that measures it
constexpr std::size_t kMiddles = 1000;  // places along one axis whose depth is looked at

// A place in the middle of a stretch that both parts cover, and half the length of the stretch.
struct Middle {
  Vector3 point;
  double half;
};

// What is seen along one axis.
struct AxisMap {
  Grid grid;
  double volume = 0.0;
  std::size_t lines = 0;  // with something of both
  std::vector<std::uint8_t> covered;
  std::vector<Middle> middles;
};

Vector3 turned_back(const Frame& frame, const Vector3& p) {
  return plus(times(frame.u, p[0]), plus(times(frame.v, p[1]), times(frame.w, p[2])));
}

// Adds the stretches that both parts cover on one line.
void add_line(AxisMap& map, const Frame& frame, std::size_t line, const std::vector<Interval>& a,
              const std::vector<Interval>& b, double tolerance) {
  const AllCells cells(map.grid);
  const double shared = shared_length(a, b);
  if (shared <= 0) return;
  ++map.lines;
  map.volume += shared * map.grid.side * map.grid.side;
  if (shared > tolerance) map.covered[line] = 1;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    const double low = std::max(a[i].low, b[j].low);
    const double high = std::min(a[i].high, b[j].high);
    if (high - low > tolerance) {
      const Vector3 point = {map.grid.centre_u(cells.column(line)),
                             map.grid.centre_v(cells.row(line)), (low + high) / 2};
      map.middles.push_back({turned_back(frame, point), (high - low) / 2});
    }
    a[i].high < b[j].high ? ++i : ++j;
  }
}

AxisMap look_along(std::size_t axis, const PartShape& a, const PartShape& b, const Box& box,
                   double wanted, double tolerance) {
  Vector3 direction{};
  direction[axis] = 1;
  const Frame frame = frame_along(direction);
  const Vector3 low = frame.turned(box.low);
  const Vector3 high = frame.turned(box.high);
  const Rectangle shadow = {low[0], high[0], low[1], high[1]};
  AxisMap map;
  map.grid = Grid::over(shadow, std::sqrt(shadow.width() * shadow.height() / wanted));
  const AllCells cells(map.grid);
  map.covered.assign(cells.lines(), 0);
  // Only lines between whose ends in both parts something is shared can hold an overlap.
  std::array<std::vector<Corners>, 2> triangles;
  std::array<std::vector<Interval>, 2> ends;
  for (std::size_t part = 0; part < 2; ++part) {
    const View view = {part == 0 ? &a.tree : &b.tree, nullptr, box};
    gather(view, frame, shadow, triangles[part]);
    ends[part].assign(cells.lines(), {1e300, -1e300});
    for (const Corners& c : triangles[part]) {
      cells.for_lines(c, [&](std::size_t line, double height, bool) {
        Interval& range = ends[part][line];
        range = {std::min(range.low, height), std::max(range.high, height)};
      });
    }
  }
  std::vector<std::uint32_t> slots(cells.lines(), Crossings::kNoSlot);
  std::vector<std::uint32_t> lines;
  for (std::size_t line = 0; line < cells.lines(); ++line) {
    const double shared = std::min(ends[0][line].high, ends[1][line].high) -
                          std::max(ends[0][line].low, ends[1][line].low);
    if (!(shared > 1e-3 * tolerance)) continue;
    slots[line] = static_cast<std::uint32_t>(lines.size());
    lines.push_back(static_cast<std::uint32_t>(line));
  }
  if (lines.empty()) return map;
  std::array<Crossings, 2> crossings;
  crossings[0].collect(cells, triangles[0], slots, lines.size(), a.inside_out);
  crossings[1].collect(cells, triangles[1], slots, lines.size(), b.inside_out);
  std::array<std::vector<Interval>, 2> intervals;
  for (std::size_t slot = 0; slot < lines.size(); ++slot) {
    for (std::size_t part = 0; part < 2; ++part) crossings[part].intervals(slot, intervals[part]);
    add_line(map, frame, lines[slot], intervals[0], intervals[1], tolerance);
  }
  return map;
}

// Whether the covered lines run round some that are not: a walk over the others from the border
// does not come to all of them.
bool has_hole(const AxisMap& map) {
  const int columns = map.grid.columns;
  const int rows = map.grid.rows;
  std::vector<std::uint8_t> seen = map.covered;
  std::vector<std::uint32_t> stack;
  const auto visit = [&](int column, int row) {
    if (column < 0 || row < 0 || column >= columns || row >= rows) return;
    const auto cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                      static_cast<std::size_t>(column);
    if (seen[cell] != 0) return;
    seen[cell] = 1;
    stack.push_back(static_cast<std::uint32_t>(cell));
  };
  for (int column = 0; column < columns; ++column) {
    visit(column, 0);
    visit(column, rows - 1);
  }
  for (int row = 0; row < rows; ++row) {
    visit(0, row);
    visit(columns - 1, row);
  }
  while (!stack.empty()) {
    const auto cell = static_cast<int>(stack.back());
    stack.pop_back();
    const int column = cell % columns;
    const int row = cell / columns;
    visit(column - 1, row);
    visit(column + 1, row);
    visit(column, row - 1);
    visit(column, row + 1);
  }
  // A few lines that slip through a thin place are no hole.
  const auto enclosed = std::count(seen.begin(), seen.end(), std::uint8_t{0});
  return enclosed > columns * rows / 50;
}

// The greatest distance of a middle from both surfaces, if it is more than `deepest`.
double deepest_of(const std::array<AxisMap, 3>& maps, const TriangleTree& a, const TriangleTree& b,
                  double deepest) {
  for (const AxisMap& map : maps) {
    const std::size_t step = map.middles.size() / kMiddles + 1;
    for (std::size_t i = 0; i < map.middles.size(); i += step) {
      const Middle& middle = map.middles[i];
      if (middle.half <= deepest) continue;
      const double from_a = distance_above(a, middle.point, deepest);
      if (from_a <= deepest) continue;
      const double from_both = std::min(from_a, distance_above(b, middle.point, deepest));
      // Where a surface has a slit, a line may seem to run on inside.
      if (from_both > deepest && contains(a, middle.point) && contains(b, middle.point)) {
        deepest = from_both;
      }
    }
  }
  return deepest;
}

}  // namespace

std::optional<FoundOverlap> find_overlap(const PartShape& a, const PartShape& b, double tolerance) {
  if (!a.closed || !b.closed) return std::nullopt;
  Box box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.low[k] = std::max(a.tree.box(1).low[k], b.tree.box(1).low[k]);
    box.high[k] = std::min(a.tree.box(1).high[k], b.tree.box(1).high[k]);
    if (!(box.high[k] - box.low[k] > tolerance)) return std::nullopt;
  }
  // Most parts that touch do not overlap: few lines say so.
  std::array<AxisMap, 3> maps;
  bool any = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    maps[axis] = look_along(axis, a, b, box, kFewLines, tolerance);
    any = any || !maps[axis].middles.empty();
  }
  double deepest = tolerance / 2;
  if (any) deepest = deepest_of(maps, a.tree, b.tree, deepest);
  if (deepest <= tolerance / 2) return std::nullopt;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    maps[axis] = look_along(axis, a, b, box, kLines, tolerance);
  }
  deepest = deepest_of(maps, a.tree, b.tree, deepest);
  const auto best =
      std::max_element(maps.begin(), maps.end(), [](const AxisMap& x, const AxisMap& y) {
        return static_cast<double>(x.lines) * x.grid.side * x.grid.side * 1.0001 <
               static_cast<double>(y.lines) * y.grid.side * y.grid.side;
      });
  FoundOverlap found;
  found.overlap.volume = best->volume;
  found.overlap.thickness = 2 * deepest;
  found.overlap.share = best->volume / std::min(a.volume, b.volume);
  found.ring = std::any_of(maps.begin(), maps.end(), has_hole);
  return found;
}

}  // namespace orasp::detail
