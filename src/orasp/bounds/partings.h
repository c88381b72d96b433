#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "orasp/bounds/departures.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// Which sets of parts may come off a large piece, in some plan.
///
/// Problem.    A bound that prices parts by the sets that might move pays attention to sets that
///             blocking never lets move: the ball bearings of a wheel that is still on its rail.
/// Idea.       A set M comes off a piece S in some cut. Take a part r of S that is not in M, and
///             follow what holds r from the start on: Departures says who has left it whenever M
///             leaves, along which direction, and so how many parts S has at most. Where that is
///             too few for each r, M comes off small pieces alone. Whether M moves or the rest of S
///             does makes no difference: what blocks one along a direction blocks the other along
///             its opposite, and each direction is there with its opposite.
/// Guarantee.  Whatever is said not to be possible is so in no plan; precedence and limits are not
///             looked at.
/// Cost.       Departures for each part, O(parts^3 * directions * words) at least; so only for
///             kMostWork of that.
class Partings {
 public:
  static constexpr double kMostWork = 3e7;  ///< a fifth of a second

  /// Nothing where all sets may move for all that is known, or where it would take too long.
  static std::optional<Partings> of(const TransitionSystem& system);

  /// Whether `set` may come off a piece of more than `parts` parts.
  [[nodiscard]] bool may_leave(std::span<const PartIndex> set, std::size_t parts);

 private:
  explicit Partings(const TransitionSystem& system);

  std::shared_ptr<const Departures::World> world_;
  std::vector<std::size_t> piece_of_;            ///< by part
  std::vector<std::vector<PartIndex>> pieces_;   ///< of the start
  std::vector<std::optional<Departures>> from_;  ///< by the part that stays
  std::vector<PartIndex>
      last_;  ///< by the first part of a set: from which part such a set may come
};

}  // namespace orasp
