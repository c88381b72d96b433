#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// One direction in which a piece cannot be taken off, and by what.
struct BlockedDirection {
  /// The way of the moved piece, such as "+x".
  std::string direction;
  /// The parts of the moved piece that are blocked, ascending.
  std::vector<PartIndex> moved;
  /// The parts of the other piece that block them, ascending.
  std::vector<PartIndex> in_the_way;
  /// The entries that say so, as positions in blocking.blocked, ascending.
  std::vector<std::size_t> entries;
  /// m; the greatest width that those entries state along this direction, if all of them state one
  /// (Blocked::widths): were it nothing, the direction would be free.
  std::optional<double> width;
};

/// How wide the region is in which two parts meet, for people: "0.19 mm wide, near the tolerance of
/// 0.1 mm". `width` in m.
[[nodiscard]] std::string width_text(const Blocking& blocking, double width);

/// What would have to be different for one violated constraint to hold.
struct Remedy {
  Constraint constraint = Constraint::NotOpen;
  std::string where;
  /// One sentence.
  std::string message;
  /// For precedence: the connections that must be handled before (in assembly: after) this one.
  std::vector<ConnectionIndex> first;
  /// For limits: the least value that allows the step.
  std::optional<double> least;
  /// For blocking: every direction that is blocked, the one with the fewest entries first.
  std::vector<BlockedDirection> directions;
};

/// Why one connection cannot be handled in a state.
struct ConnectionExplanation {
  bool legal = false;
  /// Every reason why the connection cannot be handled; empty if it can.
  std::vector<Violation> violations;
  /// One for each violation, in the same order.
  std::vector<Remedy> remedies;
  /// If legal: whether a plan exists that goes on with it. Empty where the budget did not suffice
  /// to decide that.
  std::optional<bool> plan_exists;

  enum class Later { Legal, Never, Unknown };
  /// If illegal: whether it becomes legal after other legal steps.
  Later later = Later::Unknown;
  /// These other steps, in order.
  std::vector<ConnectionIndex> after;
  /// Whether it is proved that no shorter sequence of steps makes the connection legal.
  bool fewest = false;
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
