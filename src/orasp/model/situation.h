#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include "orasp/model/connection_set.h"
#include "orasp/model/error.h"
#include "orasp/model/vector3.h"

namespace orasp {

/// Where the work stands and what stands in its way: a problem met again in the middle. Like the
/// states of TransitionSystem its sets mean the same thing in both directions: open connections are
/// those still to be handled (disassembly: still present; assembly: still missing).
///
///     Situation now = Situation::whole(problem.num_connections());
///     now.open.erase(problem.find_connection("1-2", ""));          // done
///     now.inaccessible.insert(problem.find_connection("4-5", "")); // stays for ever
///     const TransitionSystem system(problem, now);                 // the problem that is left
struct Situation {
  ConnectionSet open{};  ///< not handled yet, inaccessible ones among them
  /// Never handled from now on; those not open are passed over. The goal is that everything else is
  /// done, and the step that reaches it completes.
  ConnectionSet inaccessible{};
  ConnectionSet not_next{};  ///< cannot be the next step, but may be a later one
  /// Handled only in states in which nothing else can be: connections of a part that arrives late.
  /// What is legal now but leaves no way to the goal, because it shuts something out, is not among
  /// what can be done.
  ConnectionSet late{};
  /// What the last steps before left behind, for objectives that look back: of each attribute, the
  /// direction among them, the last value that a step had, and where the last step was done.
  std::map<std::string, std::string> in_force{};
  std::optional<Vector3> last_place{};

  [[nodiscard]] static Situation whole(std::size_t connections) {
    const ConnectionSet none(connections);
    return {ConnectionSet::all(connections), none, none, none, {}, {}};
  }
  /// @throws InputError where a set is over another number of connections.
  void require_over(std::size_t connections) const {
    for (const ConnectionSet* set : {&open, &inaccessible, &not_next, &late}) {
      if (set->universe() != connections)
        throw InputError("the situation is over " + std::to_string(set->universe()) +
                         " connections, the problem has " + std::to_string(connections));
    }
  }
  friend bool operator==(const Situation&, const Situation&) = default;
};

class Problem;
struct PlanStep;
/// Notes that a step is done: what it took is no longer open, and what it leaves behind.
void note_done(const Problem& problem, const PlanStep& step, Situation& now);

}  // namespace orasp
