#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "orasp/certificate/detail/removals.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// The cuts of a piece, told by its parts alone, read once more for certificates: which of them
/// some plan may make, whatever else is there.
///
/// A cut is a step that separates a piece S into A and B. What is asked of it is what must hold in
/// every state in which it is made, and no more: that A and B are each connected, even without all
/// that precedence wants gone before some connection between them; that they are grounded, where
/// that is asked for; that the moved one is within the limits and has a way out. So each cut of a
/// plan is among them, and some that no plan makes.
class PieceCuts {
 public:
  /// @throws InputError as Removals.
  explicit PieceCuts(const Problem& problem);

  /// Calls offer(A, B) for each cut of `piece` one of whose sides has a wanted number of parts,
  /// at most half of the piece: `wanted[n]`. A is that side; where both have half of the parts, the
  /// cut may be offered twice. Parts are ascending. Stops where offer() says false.
  /// @returns false where it was stopped, or where more than `most` sides were looked at in all
  ///          calls so far.
  /// Exponential at worst; O(connections of the piece) a side.
  using Side = std::vector<PartIndex>;
  [[nodiscard]] bool for_each(std::span<const PartIndex> piece, const std::vector<bool>& wanted,
                              std::uint64_t most,
                              const std::function<bool(const Side&, const Side&)>& offer);

  /// The pieces of a state, those of single parts left out.
  [[nodiscard]] std::vector<Side> pieces_of(const ConnectionSet& present) const;

 private:
  [[nodiscard]] bool grow(std::size_t largest, std::vector<PartIndex> candidates);
  [[nodiscard]] bool look(std::size_t largest, bool& on);
  [[nodiscard]] bool may_be_made();
  [[nodiscard]] std::size_t reach(PartIndex from, bool among_side, bool without_gone);

  const Problem& problem_;
  Removals removals_;
  std::vector<std::vector<ConnectionIndex>> around_;  ///< by part; those that join it to another
  /// By connection: all that must be gone before it, whatever the order.
  std::vector<std::vector<ConnectionIndex>> before_;
  bool some_before_ = false;

  // The piece at hand.
  std::vector<PartIndex> piece_;
  std::vector<bool> in_piece_;
  std::vector<bool> in_side_;
  std::vector<bool> excluded_;
  std::vector<bool> in_component_;
  std::vector<PartIndex> side_;
  Side rest_;
  const std::vector<bool>* wanted_ = nullptr;
  const std::function<bool(const Side&, const Side&)>* offer_ = nullptr;
  std::uint64_t looked_ = 0;
  std::uint64_t most_ = 0;
  // Scratch.
  std::vector<bool> met_;
  std::vector<bool> gone_;
  std::vector<PartIndex> queue_;
};

}  // namespace orasp::detail
