#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "orasp/bounds/departures.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// The most that a plan earns from the start where all that costs is what moves, by its mass
/// (`fuel`, and sums of it), and where blocking makes parts leave together (Departures).
///
/// Idea.       A step that moves M earns -k - w m(M), k and w the same for all. Follow the side
///             that stays: every part p of a piece but one, s, ends as the last of what was moved
///             in some cut, which is a cut for each part, and costs at least k + w m(p) (so far
///             PiecePrices). Now s is the part at the end, never moved, and M moved off it. The
///             cuts of M move all of it but one part, so M costs, beyond that sum for its parts,
///
///                 w (m(M) - the greatest mass in M),
///
///             and that is at least the sum of the same over the groups of companions in M, which
///             are all in one such M. So a piece costs at least
///
///                 min over s of  sum over p other than s of (k + w m(p))
///                                + w * sum over groups of (their mass - their greatest mass).
///
///             A base part is s. Where a piece has several, no groups are counted.
/// Guarantee.  Admissible. Exact where each group of companions leaves alone and then comes apart
///             part by part. Limits and precedence only take plans away.
/// Cost.       Departures for each part of a piece that may stay; those which are light are seldom
///             asked, since what they leave to others costs too much. After about half a second the
///             rest is bounded without.
/// Limit.      Known where every step takes one connection away, none is kept, no more than
///             kMostParts parts have blocking between them, and every term of the objective says
///             what a kilogram costs (ObjectiveTerm::cost_of_mass).
class CompanionBound {
 public:
  static constexpr std::size_t kMostParts = 512;

  explicit CompanionBound(const TransitionSystem& system);

  [[nodiscard]] bool known() const { return world_ != nullptr; }
  /// The most that a plan earns from the start; infinite where it is not known.
  [[nodiscard]] double most() const { return most_; }
  /// The best that may become of a piece.
  struct Best {
    double most = 0;                         ///< what its cuts earn at most
    std::optional<Departures> departures{};  ///< by which part stays; empty where none is known
  };
  /// Of a piece of the start, or of parts of one that hang together. If known().
  [[nodiscard]] Best of_piece(std::span<const PartIndex> piece) const;
  /// About how many words Departures of a piece of all parts look at.
  [[nodiscard]] double work_of_a_look() const;
  /// What `group` costs beyond its parts one by one, if it is moved at once.
  [[nodiscard]] double cost_of_moving_together(std::span<const PartIndex> group) const;
  /// The same of all groups of companions.
  [[nodiscard]] double cost_of_companions(const Departures& departures) const;

 private:
  const Problem& problem_;
  std::shared_ptr<const Departures::World> world_;
  double cost_of_mass_ = 0;
  std::vector<double> gains_;  ///< by part, of moving it alone
  double most_ = kInfinity;
};

}  // namespace orasp
