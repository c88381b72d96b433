#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

#include "orasp/bounds/part_units.h"
#include "orasp/bounds/small_pieces.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// Bounds what the cuts of a piece gain by prices of its parts, where the gain of a cut depends on
/// what is moved.
///
/// Problem.    A piece is cut until only units are left (PartUnits). Each cut moves one side off
///             the other. The bound must hold whatever is cut off in which order.
/// Idea.       Follow the side that stays: every unit of the piece but one ends as the last of what
///             was moved in some cut, a different cut for each unit. So each part p gets a price
///             y(p) <= 0, the most that a cut can gain that moves a piece with p in it, and the
///             piece gains at most the sum of the prices of its parts, less the least of them.
///
///             Where at most three parts ever move, better prices are found. Let w(M) be what
/// moving
///             the set M gains, and what M gains on its own from there on; M runs over all
/// connected
///             sets of up to three parts. If the prices of each M add up to w(M) or more, then what
///             is taken off a piece gains at most its prices, so all of it at most the sum without
///             the part that stays last. The least such prices are a linear program, the dual of
///             covering the parts with moved pieces. They are found nearly, by subgradients, and
///             then repaired, so that they are always valid. Pieces of up to three parts have their
///             exact value, which keeps the bound consistent.
///             A part that is heavier than max_moved_mass never moves: it is what stays of its
///             piece, and all others pay. Nor does a base part, and there may be several in a
///             piece: each cut between two of them moves nothing, and gains nothing.
/// Reference.  Subgradients: Held and Karp (1971), Mathematical Programming 1, 6-25.
/// Guarantee.  Never below what the cuts of a piece can gain.
/// Cost.       O(connected sets of three parts) once, and half a second at most for the
/// subgradients;
///             O(parts) a piece.
/// Limit.      Not known where an objective sees more of a cut than what it moves.
class PiecePrices {
 public:
  /// What a cut into a smaller side of `moved` parts and a larger one of `kept` gains at most.
  using GainBySizes = std::function<double(std::size_t moved, std::size_t kept)>;

  PiecePrices() = default;
  /// `most_moved`: the most parts that a cut may move. `effort`: of SmallPieces.
  /// The system must outlive it.
  PiecePrices(const TransitionSystem& system, Expander& expander, const PartUnits& units,
              std::size_t most_moved, const GainBySizes& gain, const ListingEffort& effort);

  /// Whether every part has a price.
  [[nodiscard]] bool known() const { return known_; }
  /// The most that the cuts of `piece` gain. `units` are those that the prices were made for.
  [[nodiscard]] double bound(std::span<const PartIndex> piece, const PartUnits& units) const;
  /// Whether with a greater effort more sets would be listed.
  [[nodiscard]] bool more_could_be_listed() const { return pieces_.more_could_be_listed(); }
  /// What the bound takes from small pieces, where it does.
  [[nodiscard]] const SmallPieces& small_pieces() const { return pieces_; }
  /// Whether that is the sum of the prices less the least of them for every piece, and the price of
  /// a part.
  [[nodiscard]] bool plain() const { return fixed_.empty() && stays_.empty() && small_.empty(); }
  [[nodiscard]] double price(PartIndex part) const { return prices_[part]; }

 private:
  bool known_ = false;
  /// The price of each part.
  std::vector<double> prices_;
  /// By part, whether it is fixed; empty where nothing is.
  std::vector<unsigned char> fixed_;
  /// By part, whether it can never move; empty without max_moved_mass.
  std::vector<unsigned char> stays_;
  /// The exact values of connected sets of two and three parts, by a number for the set. Empty
  /// where only the simple prices are used.
  std::unordered_map<std::uint64_t, double> small_;
  /// Where more than three parts may move and no cut gains more than 0.
  SmallPieces pieces_;
};

}  // namespace orasp
