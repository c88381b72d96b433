#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace orasp::detail {

/// A set of the cells of a grid, one bit each.
class CellMask {
 public:
  CellMask() = default;

  /// An empty set over a grid of this size.
  void reset(int columns, int rows) {
    columns_ = columns;
    rows_ = rows;
    words_ = (static_cast<std::size_t>(columns) + 63) / 64;
    bits_.assign(words_ * static_cast<std::size_t>(rows), 0);
    any_ = false;
  }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] bool any() const { return any_; }

  void add(int column, int row) {
    word(row, column >> 6) |= std::uint64_t{1} << (static_cast<unsigned>(column) & 63U);
    any_ = true;
  }
  /// False outside of the grid.
  [[nodiscard]] bool has(int column, int row) const {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return false;
    return (word(row, column >> 6) >> (static_cast<unsigned>(column) & 63U) & 1U) != 0;
  }
  /// 64 cells of a row at once, the first one lowest.
  [[nodiscard]] std::uint64_t word(int row, int index) const {
    return bits_[static_cast<std::size_t>(row) * words_ + static_cast<std::size_t>(index)];
  }
  [[nodiscard]] int words() const { return static_cast<int>(words_); }

 private:
  std::uint64_t& word(int row, int index) {
    return bits_[static_cast<std::size_t>(row) * words_ + static_cast<std::size_t>(index)];
  }

  int columns_ = 0;
  int rows_ = 0;
  std::size_t words_ = 0;
  std::vector<std::uint64_t> bits_;
  bool any_ = false;
};

/// A cell of a set that is farthest from all cells outside of it, and how far that is, from centre
/// to centre in sides of cells; 0 for the empty set. What lies beyond the grid is outside.
struct WidestPlace {
  double radius = 0.0;
  int column = 0;
  int row = 0;
};

/// The maximum of the exact Euclidean distance transform of a set (Danielsson, "Euclidean distance
/// mapping", 1980), without the transform: each cell asks whether a greater disc than the best one
/// so far fits round it, and nearly all are answered by four bits. The first of equals in the order
/// of rows wins. Fast where few cells are in the set or one region is plainly the widest; at worst
/// O(cells * radius).
[[nodiscard]] WidestPlace widest_place(const CellMask& mask);

}  // namespace orasp::detail
