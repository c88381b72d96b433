#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "orasp/bounds/cut_trees.h"
#include "orasp/bounds/part_units.h"
#include "orasp/bounds/piece_prices.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// What the cuts of one piece can gain, for objectives that see the piece only
/// (TransitionSystem::sees_piece_only), where steps take connections away: in disassembly, and in
/// assembly backwards. There the step that completes is the first one, whose state is known, and
/// what it earns more is left to who uses this class.
///
/// Under such an objective a plan earns
///
///     sum over open connections of own(c)  +  sum over pieces of what their cuts gain  +  what
///     completing adds once,
///
/// and each piece of n parts is cut exactly n - 1 times, whatever becomes of the others. So a bound
/// on what the cuts of one piece gain is all that a bound on a plan needs. This class has several:
/// by the sizes of the pieces, by what is moved (PiecePrices), and by how a piece hangs together.
/// From each of them what the connections themselves cost (CutTrees) may be subtracted.
class PieceGains {
 public:
  /// Up to so many parts the gains of all pairs of sizes stand in a table. Beyond, bounds by sizes
  /// are known where rewards are sums of costs by size (SizeCosts), which take no table, and bounds
  /// by what is moved where moving more costs more.
  static constexpr std::size_t kMostPartsInTable = 4096;

  /// `effort`: of SmallPieces. The system must outlive it.
  explicit PieceGains(const TransitionSystem& system, const ListingEffort& effort = {});

  /// False where the objective sees more than the piece, and where steps make connections.
  [[nodiscard]] bool known() const { return known_; }
  /// What handling `connection` earns whatever it separates.
  [[nodiscard]] double own(ConnectionIndex connection) const { return own_[connection]; }
  /// The most that completing adds to the last step; 0 where it is the first that completes.
  [[nodiscard]] double last_surplus() const { return last_surplus_; }
  /// The most that the last step earns above what the bounds of its connection and its two parts
  /// are. It is less than last_surplus() where those are above what their cut would gain.
  [[nodiscard]] double surplus_of_last_pair() const { return surplus_of_last_pair_; }
  /// Whether every size has a finite bound. It has none where a limit forbids every cut of a piece
  /// of that size; such problems are left to the searches.
  [[nodiscard]] bool sizes_known() const { return sizes_known_; }
  /// Whether by_parts() is known.
  [[nodiscard]] bool parts_known() const { return prices_.known(); }

  /// Whether pieces may end as units of more than one part (PartUnits).
  [[nodiscard]] bool has_units() const { return units_.any(); }
  /// The parts of a piece less the units that it ends as.
  [[nodiscard]] std::size_t excess(std::span<const PartIndex> piece) const {
    return units_.excess(piece);
  }
  /// The bound by sizes for a piece of n parts that ends as n - d units and so is cut n - d - 1
  /// times, whatever the sizes of its units:
  ///
  ///     g(n, d) = max over a + b = n, i + j = d of gain(a, b) + g(a, i) + g(b, j),   i < a, j < b,
  ///     g(n, n - 1) = 0.
  [[nodiscard]] double by_size(std::size_t parts, std::size_t excess) const {
    return excess == 0 ? by_size_[parts] : by_excess_[excess - 1][parts];
  }

  /// The same where the last cut of the piece is the last step of all, which adds S to it. S
  /// depends on the two units that this cut parts, whose sizes are known:
  ///
  ///     g*(a + b, a + b - 2) = gain(a, b) + S(a, b),
  ///     g*(n, d) = max over cuts of gain(a, b) + max(g*(a, i) + g(b, j), g(a, i) + g*(b, j)).
  ///
  /// It is -infinity for a piece that is one unit.
  [[nodiscard]] double last_by_size(std::size_t parts, std::size_t excess) const {
    return last_by_excess_[excess][parts];
  }
  /// The most that completing adds to a last step that separates nothing, and to one that separates
  /// two units; -infinity where there is no such step. Known only if has_units().
  [[nodiscard]] double surplus_without_cut() const { return surplus_without_cut_; }
  [[nodiscard]] double surplus_of_cut() const { return surplus_of_cut_; }

  /// The bound by sizes alone: g(n) = max over a + b = n of gain(a, b) + g(a) + g(b), g(1) = 0, the
  /// smaller of a and b at most max_moved_parts. This is Bellman's recursion over sizes, p^2 / 4
  /// additions for p parts: 0.1 s for 16,384.
  [[nodiscard]] double by_size(std::size_t parts) const { return by_size_[parts]; }
  /// The same for a piece that falls into `arms` components when some part v is taken out of it.
  /// Each side of a cut that does not hold v lies within one component, so v sees at least as many
  /// cuts as there are components:
  ///
  ///     g(n, k) = max over a + b = n of gain(a, b) + g(a) + g(b, k - 1),   b > k - 1,   v in the
  ///     side of b.
  ///
  /// It tells a hub from a chain. More than kMostArms components count as kMostArms; in problems of
  /// more than 512 parts this is by_size(parts).
  static constexpr std::size_t kMostArms = 64;
  [[nodiscard]] double by_arms(std::size_t parts, std::size_t arms) const;

  /// The most that a cut into a smaller side of `moved` parts and a larger one of `kept` gains;
  /// -infinity where max_moved_parts forbids it.
  [[nodiscard]] double gain(std::size_t moved, std::size_t kept) const;
  /// The most parts of a smaller side that a cut may have.
  [[nodiscard]] std::size_t most_moved() const { return most_moved_; }
  /// The bound by what is moved (PiecePrices).
  [[nodiscard]] double by_parts(std::span<const PartIndex> piece) const {
    return prices_.bound(piece, units_);
  }
  /// What the connections at which pieces are cut cost beyond these bounds. Each thread needs a
  /// copy of its own.
  [[nodiscard]] const CutTrees& trees() const { return trees_; }
  [[nodiscard]] const PiecePrices& prices() const { return prices_; }

 private:
  static constexpr std::size_t kMostPartsWithArms = 512;
  [[nodiscard]] double by_sizes_and_parts(std::span<const PartIndex> piece) const {
    const double bound = sizes_known_ ? by_size_[piece.size()] : kInfinity;
    return parts_known() ? std::min(bound, by_parts(piece)) : bound;
  }
  void measure_last_step(const TransitionSystem& system, Expander& expander);
  void measure_surpluses(const TransitionSystem& system, Expander& expander);
  void measure_sizes(const TransitionSystem& system, Expander& expander);
  void measure_sizes_by_costs(const TransitionSystem& system);
  void measure_sizes_with_excess();
  void measure_arms(const Problem& problem);

  bool known_ = false;
  bool sizes_known_ = false;
  double last_surplus_ = 0;
  double surplus_of_last_pair_ = 0;
  std::size_t most_moved_ = 0;
  std::vector<double> own_;
  PartUnits units_;
  PiecePrices prices_;
  CutTrees trees_;
  /// gain(moved, kept) for moved <= kept: row moved + kept of a triangle, then by `moved`. Empty
  /// beyond kMostPartsInTable.
  std::vector<double> gains_;
  /// There, what a cut costs whatever its sides are, and what a side costs by its size.
  double cost_of_cut_ = 0;
  std::vector<double> cost_of_side_;
  /// g, by parts.
  std::vector<double> by_size_;
  /// g(n, d), by d - 1 and n.
  std::vector<std::vector<double>> by_excess_;
  /// g*(n, d), by d and n.
  std::vector<std::vector<double>> last_by_excess_;
  /// S, by the sizes of the smaller unit and the larger.
  std::map<std::array<std::size_t, 2>, double> surplus_;
  double surplus_without_cut_ = 0;
  double surplus_of_cut_ = 0;
  /// g(n, k), by k - 2 and n.
  std::vector<std::vector<double>> by_arms_;
};

}  // namespace orasp
