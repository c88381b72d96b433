#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// Whether what is left still comes off a base part by part (limits.grounded, one base part).
///
/// Idea.       What hangs on the base by one part alone has to go before that part, now and for
///             ever, since joints only grow fewer. And a part leaves along a direction only when
///             all that stands in its way there is gone. So parts are taken away that nothing hangs
///             on and whose way is free, as if none of them were ever in the wrong order; what is
///             left in the end never comes off: its parts wait for each other.
/// Guarantee.  That the way is shut is a proof; that it is open is none, since a part that goes in
///             front of another may leave it hanging on what it blocks.
/// Cost.       O(parts + connections + rounds * facts) a state; rounds are few.
/// Reference.  Articulation points: Hopcroft and Tarjan (1973), Comm. ACM 16(6), 372-378. Leaving
///             out the order in which harm is done is the delete relaxation of planning (Bonet and
///             Geffner 2001, Planning as heuristic search, Artificial Intelligence 129, 5-33).
class GroundedOutlook {
 public:
  explicit GroundedOutlook(const TransitionSystem& system);

  /// Whether it has anything to say: parts come off one base part by part, all of them in the end.
  [[nodiscard]] bool applies() const { return applies_; }
  /// Whether no plan goes on from a state of what is taken apart. Only if applies().
  [[nodiscard]] bool is_shut(SetView open);

 private:
  void find_holders(SetView open);
  [[nodiscard]] bool leaves(PartIndex part);

  const TransitionSystem& system_;
  bool applies_ = false;
  PartIndex base_{};
  // Scratch, by part.
  std::vector<unsigned char> there_;
  std::vector<std::uint32_t> number_;   ///< in the order of the visit, from 1; 0: not visited
  std::vector<std::uint32_t> low_;      ///< the lowest number that its subtree touches
  std::vector<PartIndex> holder_;       ///< the nearest part through which alone it hangs
  std::vector<std::uint32_t> hanging_;  ///< how many hang on it so, and are there
  std::vector<PartIndex> visited_;
  struct Visit {
    PartIndex part;
    PartIndex from;
    std::size_t next;
  };
  std::vector<Visit> visits_;
  std::vector<std::uint64_t> free_;
};

}  // namespace orasp::detail
