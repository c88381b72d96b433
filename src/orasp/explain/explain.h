#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// A constraint that takes part in a conflict.
struct ConflictItem {
  Constraint constraint = Constraint::NotOpen;
  std::string where;    ///< place in the problem file: "precedence[2]", "blocking.blocked[5]"
  std::string message;  ///< one sentence that names what of the entry matters
};

/// Why a problem has no plan.
struct ProblemExplanation {
  Status status = Status::Unknown;  ///< Feasible, Infeasible (proved) or Unknown
  Stop stop = Stop::None;           ///< what ended it early; the conflict may then not be smallest
  /// In the order precedence, limits, blocking, inaccessible, each by place. Together they allow no
  /// plan; empty unless infeasible.
  std::vector<ConflictItem> conflict;
  bool minimal = true;      ///< proved: none of them can be left out of the conflict
  std::uint64_t tests = 0;  ///< smaller problems that were tried
  std::vector<ConnectionIndex>
      plan;  ///< some plan in the order of the problem's direction, if feasible
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

/// One direction in which a piece cannot be taken off, and by what.
struct BlockedDirection {
  std::string direction;              ///< "+x": the way of the moved piece
  std::vector<PartIndex> moved;       ///< parts of the moved piece that are blocked, ascending
  std::vector<PartIndex> in_the_way;  ///< parts of the other piece that block them, ascending
  std::vector<std::size_t> entries;   ///< positions in blocking.blocked, ascending
};

/// What would have to be different for one violated constraint to hold.
struct Remedy {
  Constraint constraint = Constraint::NotOpen;
  std::string where;
  std::string message;                 ///< one sentence
  std::vector<ConnectionIndex> first;  ///< precedence: those to be handled before (assembly: after)
  std::optional<double> least;         ///< limits: the least value that allows it
  std::vector<BlockedDirection> directions;  ///< blocking: fewest entries first
};

/// Why one connection cannot be handled in a state.
struct ConnectionExplanation {
  bool legal = false;
  std::vector<Violation> violations;  ///< all of them; empty if legal
  std::vector<Remedy> remedies;       ///< one for each violation, in the same order
  /// If legal: whether a plan exists that goes on with it. Empty: not decided in the budget.
  std::optional<bool> plan_exists;

  enum class Later { Legal, Never, Unknown };
  /// If illegal: whether it becomes legal after other legal steps.
  Later later = Later::Unknown;
  std::vector<ConnectionIndex> after;  ///< these steps, in order
  bool fewest = false;                 ///< proved: no shorter sequence does
};

/// Explains `connection` in the state `open` (as TransitionSystem: the connections still to be
/// handled).
///
/// Idea.       Violations by definition (Expander::violations), and for each what would have to
///             change. Whether it becomes legal later: breadth first over the states that other
///             legal steps reach, which gives a shortest sequence; where these are too many, the
///             steps of some legal order up to the first state in which the connection may be
///             handled, less those that can be left out (tried last to first, for a second or so).
/// Guarantee.  Never is a proof: all states that can be reached without the connection were looked
///             at.
/// Cost.       At most 20,000 states breadth first and 200,000 depth first, each O(parts +
///             connections).
[[nodiscard]] ConnectionExplanation explain_connection(const Problem& problem,
                                                       const ConnectionSet& open,
                                                       ConnectionIndex connection,
                                                       const Budget& budget);

}  // namespace orasp
