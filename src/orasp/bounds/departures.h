#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// Which parts leave a piece in one move, whatever the plan.
///
/// Problem.    A piece is taken apart, and one of its parts, which stays, is never moved. Follow
///             what holds that part: pieces are moved off it one after the other, until it is
///             alone. Each other part leaves in one of these moves.
/// Idea.       For each part and each direction in which it might leave, which parts have left by
///             then, or leave in the same move?
///             * What stands in its way in that direction.
///             * What hangs on the part that stays only through those that have left by then: a
///               cut leaves no third piece.
///             * What has left by then where any of these leaves, in whatever direction: the
///               intersection over its directions.
///             If the part that stays is among them, the direction is closed. These sets grow until
///             nothing is added. Of two parts each of which leaves no later than the other, both
///             leave in the same move: they are companions. A group of companions is moved, and
///             then taken apart, where else each of its parts would be moved once.
/// Guarantee.  Whatever is said holds for every plan: each addition is forced by those before it.
///             What is not said may be so all the same.
/// Reference.  The relation "no later than" under blocking: Wilson and Latombe (1994), Geometric
///             reasoning about mechanical assembly, Artificial Intelligence 71(2), 371-396 (the
///             non-directional blocking graph); what hangs through a set of parts: dominators,
///             Lengauer and Tarjan (1979), ACM TOPLAS 1(1), 121-141.
/// Cost.       O(rounds * parts^2 * directions * words) with words = parts / 64; rounds are few.
///             0.3 ms for 69 parts and 6 directions.
class Departures {
 public:
  /// What all of them share: connections and ways of one system, whose connections are all still to
  /// be handled. The system must outlive it.
  class World;

  /// Of `piece`, whose parts hang together, where `stays` is never moved.
  Departures(std::shared_ptr<const World> world, std::span<const PartIndex> piece, PartIndex stays);

  /// What is left when `group` is moved off; it holds no part that stays.
  [[nodiscard]] Departures without(std::span<const PartIndex> group) const;

  [[nodiscard]] PartIndex stays() const { return stays_; }
  /// The parts, ascending.
  [[nodiscard]] const std::vector<PartIndex>& parts() const { return parts_; }
  /// False where some part could never leave.
  [[nodiscard]] bool possible() const { return possible_; }
  /// Companions, and parts that have none; all but the part that stays, once each. If possible().
  [[nodiscard]] const std::vector<std::vector<PartIndex>>& groups() const { return groups_; }
  /// Whether a group may leave at once, by all that is known.
  [[nodiscard]] bool may_leave(std::span<const PartIndex> group) const;
  /// Whether a group, which does not hold the part that stays, may ever leave while there are more
  /// than so many parts, itself among them. If possible().
  [[nodiscard]] bool may_leave_more(std::span<const PartIndex> group, std::size_t than) const;

 private:
  using Word = std::uint64_t;
  [[nodiscard]] std::span<Word> set_of(PartIndex part, std::size_t way);
  [[nodiscard]] std::span<const Word> set_of(PartIndex part, std::size_t way) const;
  void settle();
  [[nodiscard]] bool grow(std::span<Word> set);
  void find_groups();

  std::shared_ptr<const World> world_;
  PartIndex stays_;
  std::vector<PartIndex> parts_;
  bool possible_ = true;
  std::vector<Word> there_;  ///< parts_
  /// By part and way: who has left when it leaves so; empty where the way is closed.
  std::vector<Word> sets_;
  /// By part: whoever has left when it leaves.
  std::vector<Word> left_;
  /// The same the other way round; by part: those that do not leave before it does.
  std::vector<Word> holds_up_;
  std::vector<std::vector<PartIndex>> groups_;
};

class Departures::World {
 public:
  explicit World(const TransitionSystem& system);

  [[nodiscard]] std::size_t words() const { return words_; }
  /// Directions in which parts leave; one where the problem has no blocking.
  [[nodiscard]] std::size_t ways() const { return ways_; }
  [[nodiscard]] std::size_t num_parts() const { return num_parts_; }
  [[nodiscard]] std::span<const Word> around(PartIndex part) const {
    return std::span(around_).subspan(part * words_, words_);
  }
  [[nodiscard]] std::span<const Word> blockers(PartIndex part, std::size_t way) const {
    return std::span(blockers_).subspan((part * ways_ + way) * words_, words_);
  }

 private:
  std::size_t words_;
  std::size_t ways_;
  std::size_t num_parts_;
  std::vector<Word> around_;    ///< by part: the parts that it is joined to
  std::vector<Word> blockers_;  ///< by part and way
};

}  // namespace orasp
