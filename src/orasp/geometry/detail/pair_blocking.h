#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "orasp/geometry/detail/cell_mask.h"
#include "orasp/geometry/detail/frame.h"
#include "orasp/geometry/detail/line_intervals.h"
#include "orasp/geometry/detail/line_raster.h"

namespace orasp::detail {

/// Two parts seen along one direction.
struct PairView {
  const View* a = nullptr;
  const View* b = nullptr;
  Frame frame;
  std::array<bool, 2> closed = {false, false};
  std::array<bool, 2> inside_out = {false, false};
  bool overlap = false;      ///< they touch, and both are closed: what both cover counts for none
  double tolerance = 0.1;    ///< mm
  double width_limit = 0.2;  ///< mm: a region no wider than this blocks nothing
};

/// What one part meets of the other.
struct PairVerdict {
  bool blocked = false;
  double width = 0.0;  ///< mm, of the widest blocked region
  double depth = 0.0;  ///< mm, how far the other lies beyond it there at most
};

/// Decides whether one of two parts can leave the other along a direction and against it, both from
/// one raster of lines of sight; keeps its buffers from pair to pair. See find_blocking for how.
class PairBlocking {
 public:
  /// The first is whether b blocks a along the direction, the second whether a blocks b.
  [[nodiscard]] std::array<PairVerdict, 2> decide(const PairView& pair);

 private:
  // Where each line first and last meets a part.
  struct Extremes {
    std::vector<double> first, last;
  };
  // The widest blocked region on one raster.
  struct Region {
    WidestPlace place;
    double cell = 0.0;  // side, mm
    double depth = 0.0;

    // Between lines: its middle lies a radius from the nearest free line, and its border on average
    // half a cell before that.
    [[nodiscard]] double width() const {
      return place.radius > 0 ? (2 * place.radius - 0.5) * cell : 0.0;
    }
  };

  template <class Cells>
  void look(const Cells& cells, const PairView& pair, const std::array<bool, 2>& open);
  template <class Cells>
  Region judge(const Cells& cells, const PairView& pair, int side, double narrowest);
  template <class Cells>
  void subtract(const Cells& cells, const PairView& pair, int side);
  template <class Cells>
  double depth_at(const Cells& cells, int side, const WidestPlace& place) const;
  [[nodiscard]] double beyond(int side, std::size_t line) const;
  template <class Cells>
  Region sharpened(const Cells& cells, const PairView& pair, int side, double narrowest);
  template <class Cells>
  std::size_t choose_cells(const Cells& cells, const PairView& pair,
                           const std::array<bool, 2>& open);
  void choose_lines(const AllCells& coarse, const PairView& pair, const std::array<bool, 2>& open,
                    double finest);

  std::vector<Corners> triangles_[2];
  Extremes extremes_[2];        // of a and b, on the lines of the present look
  Extremes aside_[2];           // those of the look before, while a narrow place is sharpened
  std::vector<double> low_[2];  // bounds of heights in each cell, of a and b
  std::vector<double> high_[2];
  std::vector<std::uint8_t> chosen_;
  FineCells middle_;
  FineCells fine_;
  FineCells sharp_;
  CellMask mask_;
  CellMask without_[2];  // blocked lines where a lacks b, and where b lacks a
  std::vector<std::uint32_t> slots_;
  std::vector<std::uint32_t> lines_;
  Crossings crossings_[2];
  std::vector<Interval> intervals_[2];
};

}  // namespace orasp::detail
