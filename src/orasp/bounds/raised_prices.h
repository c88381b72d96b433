#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "orasp/bounds/small_pieces.h"
#include "orasp/model/index.h"

namespace orasp {

/// Bounds what the cuts of one piece gain more closely than the prices of SmallPieces, which must
/// fit all pieces.
///
/// Idea.       The conditions on prices are one for each small connected set M. For the pieces that
///             are cut from a piece S only those with M within S matter: where the conditions that
///             hold a part down all reach beyond S, the part costs more. So parts are taken one
///             after the other, and each costs as much more as the conditions within S let it. What
///             the prices then say of S is a bound by the proof of SmallPieces, as all that is cut
///             from S lies within S.
///             What fits S fits what is cut from S too. There only the parts need be looked at
///             again that were held down by a condition with a part that is gone.
///             Conditions with much room left are not looked at: all parts together cost no more
///             than these have left.
/// Reference.  A potential function for each state, in place of one that fits all of them: Seipp,
///             Pommerening and Helmert (2015), New optimization functions for potential heuristics,
///             ICAPS, 193-201. The raise is a greedy dual ascent.
/// Guarantee.  Never more than what the cuts of the piece gain less than SmallPieces::bound().
/// Cost.       O(near rows / 64) for each part that is gone, and a look at some near rows for each
///             part that is held down no longer: some microseconds for forty parts.
class RaisedPrices {
 public:
  /// How much more the parts of a piece cost.
  class Raise {
   public:
    [[nodiscard]] double sum() const { return sum_; }

   private:
    friend class RaisedPrices;
    double sum_ = 0;
    std::vector<PartIndex> parts_;  ///< of the piece, rising
    std::vector<double> of_part_;
    /// By part, the row that holds it down; kNoRow where none was looked for yet.
    std::vector<std::uint32_t> held_by_;
    std::vector<std::uint64_t> within_;  ///< the near rows within the piece, as bits
  };

  RaisedPrices(const SmallPieces& pieces, std::size_t parts);

  /// Nothing more for all parts of the problem.
  [[nodiscard]] const Raise& none() const { return none_; }
  /// Writes to `into` what the parts of `piece`, in rising order, cost more; all of them are in the
  /// piece of `from`. By `into.sum()` the cuts of the piece gain less than SmallPieces::bound()
  /// says, where that is by prices. What is more than `enough` need not be found.
  void fit(const Raise& from, std::span<const PartIndex> piece, double enough, Raise& into) const;

 private:
  static constexpr std::uint32_t kNoRow = std::numeric_limits<std::uint32_t>::max();

  /// A near row in few bytes.
  struct Row {
    std::array<std::uint16_t, PriceRow::kMostParts> parts;
    std::uint16_t size;
  };
  void raise_part(PartIndex part, Raise& raise) const;
  [[nodiscard]] static bool contains(const std::uint64_t* rows, std::uint32_t row) {
    return (rows[row / 64] >> row % 64 & 1U) != 0;
  }

  double left_beyond_;
  std::size_t words_;
  std::vector<Row> rows_;
  std::vector<double> left_;  ///< of the room of each row
  /// By part: the near rows that hold it, as bits.
  std::vector<std::uint64_t> rows_with_;
  Raise none_;
};

}  // namespace orasp
