#pragma once

#include <optional>
#include <span>
#include <vector>

#include "orasp/model/problem.h"

namespace orasp::detail {

/// Which parts of a piece leave it in one move, in every plan that never moves the part `stays`:
/// the sentences of docs/format.md about blocking and about pieces, read once more for
/// certificates.
///
/// A part that leaves along a direction has what blocks it there gone before, or with it. What is
/// joined to the part that stays through those alone that are gone, is gone with them, since the
/// rest is one piece. And whatever has gone where one of them goes, has gone too. What holds for
/// every direction in which a part may leave, holds for the part. Two parts of which each is gone
/// when the other goes are gone by the same move.
///
/// Piece:     of the whole product; connected.
/// Cost:      O(parts^2 * (parts + connections) * directions * rounds), rounds are few.
class Leaving {
 public:
  Leaving(const Problem& problem, std::span<const PartIndex> piece, PartIndex stays);

  /// False where some part could never leave.
  [[nodiscard]] bool possible() const { return possible_; }
  /// Whether two parts of the piece, neither of which stays, leave in one move.
  [[nodiscard]] bool together(PartIndex a, PartIndex b) const { return gone_[a][b] && gone_[b][a]; }
  /// The largest such sets of two and more parts.
  [[nodiscard]] std::vector<std::vector<PartIndex>> groups() const;

 private:
  using Set = std::vector<bool>;
  [[nodiscard]] std::optional<Set> gone_along(PartIndex part, std::optional<DirectionIndex> way);
  void take_what_is_loose(Set& gone);

  const Problem& problem_;
  std::vector<PartIndex> piece_;
  PartIndex stays_;
  bool possible_ = true;
  std::vector<std::vector<PartIndex>> around_;  ///< by part
  Set in_piece_;
  std::vector<Set> gone_;  ///< by part: who has gone when it has
};

}  // namespace orasp::detail
