#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// The units that a disassembly ends with.
///
/// In the middle of the work some connections may be inaccessible: they stay as they are for ever
/// (TransitionSystem::kept). Backwards these are the connections that are made already. The parts
/// that they hold together never come apart. Such a group of parts, and each part that is in no
/// group, is a unit.
class PartUnits {
 public:
  /// Every part is a unit of its own.
  PartUnits() = default;
  explicit PartUnits(const TransitionSystem& system);

  /// Whether some unit has more than one part.
  [[nodiscard]] bool any() const { return !merged_.empty(); }
  /// Whether `part` is in one unit with a part that stands before it in the file.
  [[nodiscard]] bool merged(PartIndex part) const { return any() && merged_[part] != 0; }
  /// The first part of the unit that `part` belongs to. Only if any().
  [[nodiscard]] PartIndex first_of(PartIndex part) const { return first_[part]; }
  /// The parts of a piece less its units: how many cuts the piece is spared.
  [[nodiscard]] std::size_t excess(std::span<const PartIndex> piece) const;
  /// The same for all parts of the problem together.
  [[nodiscard]] std::size_t excess() const;
  /// The number of parts in the unit that begins with each part, 0 for the other parts. Empty
  /// unless any().
  [[nodiscard]] std::vector<std::size_t> sizes() const;

 private:
  /// Both are indexed by part, and empty where every part is a unit of its own.
  std::vector<unsigned char> merged_;
  std::vector<PartIndex> first_;
};

}  // namespace orasp
