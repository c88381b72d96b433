#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "orasp/bounds/piece_gains.h"
#include "orasp/model/transition_system.h"
#include "orasp/symmetry/symmetry.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

inline constexpr std::size_t kAndOrMostParts = 1024;
inline constexpr double kAndOrLeastSaving = 1.5;
inline constexpr double kAndOrLeastSavingOfKept = 16;

/// The search goes in rounds, each twice as long as the one before.
struct AndOrOptions {
  std::uint64_t rounds = std::numeric_limits<std::uint64_t>::max();
  SymmetryUse symmetry = SymmetryUse::Auto;
};

/// Finds an optimal plan piece by piece: AND/OR search over connected sets of parts.
///
/// Problem.    Where the objective sees the piece only (TransitionSystem::sees_piece_only) the
///             pieces of a state no longer matter to each other, except through precedence across
///             pieces and max_subassemblies. So the best gain of a piece S is V(S) = max over legal
///             cuts of S into connected A and B of gain(A, B) + V(A) + V(B): a choice of one cut
///             (OR) that leaves both sides to solve (AND). Connected sets of parts are
///             exponentially fewer than the states of H, where every piece stands beside every
///             state of the others.
/// Idea.       Depth first with a memory. Loss L(S) = g(S) - V(S) >= 0 against the bound g of
///             bounds/piece_gains.h; a cut is followed only while its own loss and the lower bounds
///             on the losses of its sides stay within a budget, which grows from 0 at the root
///             (iterative deepening); sizes of A that lose more are never listed. Where sizes tell
///             little of what a cut gains, the cuts of a piece are listed once and kept, those
///             alone that blocking allows (planners/detail/side_lister.h), and a longer search goes
///             on by layers, in several threads (detail::AndOrSearch::sweep()). Within
///             max_subassemblies one side is finished before the other is begun, which needs the
///             fewest at a time (Sethi and Ullman 1970), so a memory entry is a set of parts and
///             the number allowed to it.
/// Plans.      The best plan that is known is cut anew, window by window, beside the search where
///             there are two threads and else after it; before it where it goes by layers
///             (detail::AndOrSearch::recut(): iterative dynamic programming and iterated local
///             search). The search then begins with a plan that is mostly the best one.
/// Last cuts.  Where connections differ, as with attempts that succeed more often at one than at
///             another, sizes and the spanning tree of a piece (bounds/cut_trees.h) do not tell
///             what its last cuts lose: see detail::AndOrSearch::find_cores(). And where the last
///             step of all earns more at one connection than at another, an entry also says whether
///             its piece has that step.
/// Symmetry.   Pieces that an exchange of equal parts takes into one another have one value, so one
///             of them is searched for all (symmetry/symmetry.h). With SymmetryUse::Auto exchanges
///             are looked for after the first round, and used where there are at least
///             kAndOrLeastSaving times fewer sets of parts up to them, and kAndOrLeastSavingOfKept
///             times where the cuts of pieces are kept, which they are not with symmetry. Random
///             spanning forests are searched without.
/// Reference.  AND/OR search: Nilsson (1980), Principles of Artificial Intelligence, ch. 3; for
///             assembly: Homem de Mello and Sanderson (1991), IEEE Trans. Robotics and Automation
///             7(2), 228-240. Iterative deepening: Korf (1985), Artificial Intelligence 27(1),
///             97-109.
/// Guarantee.  The bound is proved at any time, since what is left out (precedence across pieces;
///             `after_any`; connections removed early) only takes choices away. Where the cut tree
///             found can be carried out as legal steps that earn as much, the plan is Optimal;
///             elsewhere there is no plan of this method's own (Unknown). Infeasible where no piece
///             can be cut.
/// Cost.       Exponential at worst in the parts. A table entry: the set of parts, 8 bytes and 12
///             to 24 of index; where cuts are kept 48 bytes more, and 16 a cut.
/// Assembly.   The same tree, read from its leaves: A and B are put together. The step that
///             completes is then the first one from the root, so at the root alone the steps that
///             can be the last joint are looked at one by one, with what completing adds to each.
/// Parts.      Where steps take parts off (StepKind::Part) each takes a connected set of them, and
///             the rest may fall into many pieces: planners/detail/part_trees.h.
/// Limit.      At most kAndOrMostParts parts, objectives that see the piece only; no goal.
/// Repeatable. Ties go to the cut listed first.
/// @throws Refusal where the objective or the direction does not allow it: and_or_obstacle(); where
/// symmetry was asked for and nothing is known of it: symmetry_obstacle().
[[nodiscard]] Result and_or(const TransitionSystem& system, const AndOrOptions& options,
                            const Budget& budget);

/// and_or() in turns, between which other methods may look for plans. What a turn has proved stays
/// for the next one. Only where and_or_obstacle() has nothing against it, no part steps.
class AndOrTurns {
 public:
  /// Both must outlive it. `gains` are those of the system where they are known already.
  AndOrTurns(const TransitionSystem& system, const Budget& budget,
             std::shared_ptr<const PieceGains> gains = nullptr,
             SymmetryUse symmetry = SymmetryUse::Auto);
  AndOrTurns(const AndOrTurns&) = delete;
  AndOrTurns& operator=(const AndOrTurns&) = delete;
  ~AndOrTurns();

  /// The next rounds, from a plan that is known, where there is one. The expansions in the answer
  /// are those of these rounds; unknown without a bound where the search is of no use.
  [[nodiscard]] Result next(std::uint64_t rounds, const Result& known);

 private:
  struct Work;
  const TransitionSystem& system_;
  const Budget& budget_;
  std::shared_ptr<const PieceGains> gains_;
  SymmetryUse symmetry_;
  std::unique_ptr<Work> work_;
};

/// Why and_or() does not take the problem; empty where it does. A problem that is infeasible at
/// sight and one without connections are answered all the same.
[[nodiscard]] std::optional<std::string> and_or_obstacle(const TransitionSystem& system);

}  // namespace orasp
