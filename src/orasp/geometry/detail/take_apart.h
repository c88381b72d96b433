#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace orasp::detail {

/// That `part` cannot leave `by` along the direction with this number; 2 k and 2 k + 1 are
/// opposites.
struct BlockedAlong {
  std::uint32_t part = 0;
  std::uint32_t by = 0;
  std::uint32_t direction = 0;
};

/// How a product comes apart by straight motions, whatever else rules its plans.
struct TakenApart {
  /// The most parts that had to move at once; 1 where all came off one by one.
  std::size_t moved = 1;
  /// Whether each set that moved hangs together. If not, a plan whose steps move sets that do may
  /// need larger ones.
  bool hangs_together = true;
  /// Groups of parts of which none and no subassembly can leave the others. Empty: all comes apart.
  std::vector<std::vector<std::uint32_t>> stuck;
};

/// Takes a product apart: parts that nothing of their piece blocks go first; where there are none,
/// the smallest subassembly that can go.
///
/// Idea.      Along one direction, parts that block each other in a ring must move together, and
///            with them all that blocks them: the sinks of the strong components of the blocking
///            graph are the least sets that can leave (Wilson and Latombe 1994, Geometric reasoning
///            about mechanical assembly, Artificial Intelligence 71, 371-396).
/// Guarantee. What is stuck has no plan: taking other parts off first never hinders, so the order
///            does not matter. `moved` is a lower bound where a set does not hang together.
/// Cost.      O(directions * facts) for each part or set that goes where none was free; counting
///            blockers makes free parts cheap.
/// Ties.      By direction, then by part.
///
/// `joined` are the pairs that touch; `fixed` the parts that never move, empty for none.
[[nodiscard]] TakenApart take_apart(std::size_t parts, std::size_t directions,
                                    std::span<const BlockedAlong> blocked,
                                    std::span<const std::pair<std::uint32_t, std::uint32_t>> joined,
                                    const std::vector<bool>& fixed);

}  // namespace orasp::detail
