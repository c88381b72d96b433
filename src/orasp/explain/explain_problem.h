#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// A constraint that takes part in a conflict.
struct ConflictItem {
  Constraint constraint = Constraint::NotOpen;
  /// The place in the problem file, such as "precedence[2]" or "blocking.blocked[5]".
  std::string where;
  /// One sentence that names what of the entry matters.
  std::string message;
};

/// Why a problem has no plan.
struct ProblemExplanation {
  /// Feasible, Infeasible (which is then proved) or Unknown.
  Status status = Status::Unknown;
  /// What ended the search early, if anything did. The conflict may then not be a smallest one.
  Stop stop = Stop::None;
  /// Constraints that together allow no plan, in the order precedence, limits, blocking,
  /// inaccessible, and each by its place in the file. Empty unless infeasible.
  std::vector<ConflictItem> conflict;
  /// Whether it is proved that none of them can be left out of the conflict.
  bool minimal = true;
  /// How many smaller problems were tried.
  std::uint64_t tests = 0;
  /// Where the problem is feasible: some plan, in the order of the problem's direction.
  std::vector<ConnectionIndex> plan;
};

/// Finds a smallest set of constraints that conflict: together they allow no plan, and without any
/// one of them the others alone (no other constraint of the problem) allow one. There may be
/// further conflicts in the problem.
///
/// Idea.       A test drops constraints and asks find_order() whether a plan exists. First whole
///             groups are dropped one by one (all blocking, all precedence, each limit), then the
///             entries that are left are halved again and again, and last the ids and directions
///             inside the entries that remain, for the sentences.
/// Reference.  Deletion filter: Chinneck and Dravnieks (1991), ORSA J. Computing 3(2), 157-168.
///             Halving (QuickXplain): Junker (2004), AAAI, 167-172.
/// Guarantee.  The conflict is proved. It is irreducible, not of least size, if `minimal`; a test
///             that is not decided in its share of the budget keeps what it would have dropped, and
///             `minimal` is then false.
/// Cost.       O(k log(n/k) + k) tests for k constraints found among n, each with a limit on
///             states; Unknown only if the first one, which may take the whole budget, is not
///             decided.
/// Repeatable. Of several conflicts, that of what stands earlier in the file: what stands later is
/// dropped first.
[[nodiscard]] ProblemExplanation explain_problem(const Problem& problem, const Budget& budget);
/// The same for what is left of the work (TransitionSystem): inaccessible connections are
/// constraints too, each of which could be dropped. What cannot be next or is late is named in
/// whole, not `minimal`, where it alone rules out a plan.
[[nodiscard]] ProblemExplanation explain_problem(const Problem& problem, const Situation& situation,
                                                 const Budget& budget);

}  // namespace orasp
