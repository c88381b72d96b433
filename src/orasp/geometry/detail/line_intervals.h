#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "orasp/geometry/detail/line_raster.h"

namespace orasp::detail {

/// Where chosen lines meet the surface of a part, as one flat array with the lines' shares of it.
class Crossings {
 public:
  /// `slots[line]` is the number of a chosen line, from 0 to `chosen`, or kNoSlot. A surface that
  /// is drawn inside out is turned.
  template <class Cells>
  void collect(const Cells& cells, const std::vector<Corners>& triangles,
               const std::vector<std::uint32_t>& slots, std::size_t chosen, bool inside_out);

  /// The stretches of a line inside of the part, in their order: where the surface has been entered
  /// more often than left.
  void intervals(std::size_t slot, std::vector<Interval>& found);

  static constexpr std::uint32_t kNoSlot = std::numeric_limits<std::uint32_t>::max();

 private:
  struct Crossing {
    double height;
    bool leaves;
  };
  std::vector<std::uint32_t> begin_;
  std::vector<Crossing> crossings_;
};

template <class Cells>
void Crossings::collect(const Cells& cells, const std::vector<Corners>& triangles,
                        const std::vector<std::uint32_t>& slots, std::size_t chosen,
                        bool inside_out) {
  begin_.assign(chosen + 2, 0);
  for (const Corners& c : triangles) {
    cells.for_lines(c, [&](std::size_t line, double, bool) {
      if (slots[line] != kNoSlot) ++begin_[slots[line] + 2];
    });
  }
  for (std::size_t i = 2; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  crossings_.resize(begin_.back());
  for (const Corners& c : triangles) {
    cells.for_lines(c, [&](std::size_t line, double height, bool up) {
      if (slots[line] != kNoSlot)
        crossings_[begin_[slots[line] + 1]++] = {height, up != inside_out};
    });
  }
}

/// What is left of one part on a line without another.
struct Remains {
  double first = std::numeric_limits<double>::infinity();
  double last = -std::numeric_limits<double>::infinity();
};

/// The ends of `from` without `what`. Pieces that a cut has left no longer than `sliver` are not
/// counted: they come of surfaces that lie on one another and are drawn of different triangles.
[[nodiscard]] Remains remains(std::span<const Interval> from, std::span<const Interval> what,
                              double sliver);

/// The length that two sets of intervals share.
[[nodiscard]] double shared_length(std::span<const Interval> a, std::span<const Interval> b);

}  // namespace orasp::detail
