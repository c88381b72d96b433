#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "orasp/model/index.h"

namespace orasp {

/// A row of the linear program of SmallPieces: what the parts cost together is at most `room`.
struct PriceRow {
  static constexpr std::size_t kMostParts = 12;
  using Parts = std::array<PartIndex, kMostParts>;
  Parts parts{};
  std::size_t size = 0;
  double room = 0;
  /// Whether what the parts reserve was taken from the room.
  bool reserves = false;
  /// The parts whose reserves were added to the room, if any.
  Parts lenders{};
  std::size_t num_lenders = 0;

  [[nodiscard]] std::span<const PartIndex> all() const { return {parts.data(), size}; }
  [[nodiscard]] std::span<const PartIndex> all_lenders() const {
    return {lenders.data(), num_lenders};
  }
};

/// Looks for the greatest costs of parts, minus their prices, that fit into each row.
///
/// Idea.       Subgradients of the penalty form: all costs go up, and those of a row that is
///             broken go down again, by as much for each such row. Rows that are far from being
///             broken do not matter to the next steps, so only a share of them, the nearest, is
///             looked at, chosen anew now and then. What is answered was made valid: it fits into
///             every row, however far that went.
/// Reference.  Held and Karp (1971), Mathematical Programming 1, 6-25.
/// Cost.       A step O(kLeastNear + rows / 32), a choice and a repair O(rows).
class PackedCosts {
 public:
  using Costs = std::vector<double>;
  static constexpr std::size_t kLeastNear = 4000;

  /// What parts cost, each and all together.
  struct Answer {
    Costs costs;
    double sum;
  };

  PackedCosts(std::vector<PriceRow> rows, std::size_t parts);

  /// Without reserves. Ends early once `is_over()`.
  [[nodiscard]] Answer find(const std::function<bool()>& is_over);
  /// The costs made valid.
  [[nodiscard]] Answer made_valid(const Costs& costs) const;
  /// Moves costs and reserves up along the subgradient, `steps` times by `step`.
  void climb(Costs& costs, Costs& reserves, std::size_t steps, double step);

 private:
  void choose_rows(const Costs& costs);
  void step_up(Costs& costs, Costs& slope, double step) const;
  [[nodiscard]] Costs repaired(Costs costs) const;

  std::vector<PriceRow> rows_;
  /// By part: the rows that hold it.
  std::vector<std::vector<std::uint32_t>> rows_with_;
  /// The rows that have least room left.
  std::vector<std::uint32_t> near_;
};

}  // namespace orasp
