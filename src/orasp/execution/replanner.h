#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/model/transition_system.h"
#include "orasp/model/vector3.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

struct ReplannerOptions {
  /// H is held where it is estimated to have no more actions than this (and to fit in memory).
  double most_actions = 2e7;
};

/// Answers, again and again, what the best plan is from where the work stands, while things change:
/// connections are done, become inaccessible or accessible again, cannot be next; parts are lost,
/// replaced, late, arrive; limits change.
///
///     Replanner replanner(problem);
///     Result plan = replanner.plan();                            // as solve
///     replanner.done(plan.sequence[0]);                          // the cell works ...
///     replanner.set_accessible(plan.sequence[1], false);         // ... and the next one is stuck
///     plan = replanner.plan();                                   // microseconds: all but that one
///     replanner.set_accessible(plan.sequence[1], true);          // the repair; as quick to undo
///     plan = replanner.plan();
///
/// Problem.    The problem that is left is that of TransitionSystem with situation(): the goal is
///             that everything accessible is done, the last step towards it completes, rewards are
///             those of the steps still to come.
/// Idea.       H is built once and every state's best reward still to come is kept. While
///             everything is accessible and nothing is late, an answer is read off. Otherwise only
///             the part of H that can be reached from the state at hand without inaccessible
///             connections is gone through again, last layer first: legality and rewards are those
///             of H, but for the reward of the last step, which the rules give anew. After k of n
///             steps that are at most 2^(n - k - 1) states. Where H is too large, or the state is
///             none of H's, `auto` solves the problem that is left. Where attempts may fail, the
///             stochastic shortest path of what is left is solved anew
/// (planners/uncertain_value_iteration.h).
/// Reference.  The paper, section on replanning; Bellman (1957).
/// Guarantee.  Status, bound and reward are those of solving the problem that is left from the
///             beginning. With H held always Optimal or Infeasible.
/// Cost.       Building H; then O(states and actions reached), no memory taken but for the first
///             queries.
/// Not for several threads at once: one Replanner for each.
class Replanner {
 public:
  /// Copies the problem. @throws InputError as TransitionSystem. Where `budget` ends building H, it
  /// goes on without.
  explicit Replanner(const Problem& problem, const ReplannerOptions& options = {},
                     const Budget& budget = {});
  ~Replanner();
  Replanner(Replanner&&) noexcept;
  Replanner& operator=(Replanner&&) noexcept;

  /// The problem with the limits of now.
  [[nodiscard]] const Problem& problem() const;
  /// Everything below, put together.
  [[nodiscard]] Situation situation() const;

  /// `connection` was handled (removed; in assembly, made), by the plan or not; or it was not after
  /// all. When something is done, what could not be next may be again.
  void set_done(ConnectionIndex connection, bool done = true);
  void done(ConnectionIndex connection) { set_done(connection); }
  void set_accessible(ConnectionIndex connection, bool accessible);
  void set_possible_next(ConnectionIndex connection, bool possible);
  /// None of the open connections of a lost part can be handled until it is replaced, and what
  /// comes after them or would shut them out waits too (execution/waiting.h). Where the job could
  /// not be finished even with the part, they are given up.
  void set_lost(PartIndex part, bool lost);
  /// Connections of a late part are handled only when nothing else can be.
  void set_late(PartIndex part, bool late);
  /// Up to four limits are held, so going back to one of the last is quick. @throws InputError as
  /// Problem.
  void set_limits(const Limits& limits, const Budget& budget = {});

  /// The same assembly under another objective, or with other durations or masses: the rewards of
  /// the H that is held are replaced (StateGraph::reweigh); where legal actions differ, or none is
  /// held, H is generated. Returns whether it was replaced. Where the work stands and what has
  /// changed stays. @throws InputError if the ids of parts or connections differ.
  bool reweigh(const Problem& problem, const Budget& budget = {});

  /// The best plan from here: `sequence` holds the steps still to come and `reward` is theirs.
  [[nodiscard]] Result plan(const Budget& budget = {});

  /// Whether H is held for the limits of now; its states, and the seconds that generating it, or
  /// replacing its rewards, and its values took.
  [[nodiscard]] bool holds_graph() const;
  [[nodiscard]] std::uint64_t held_states() const;
  [[nodiscard]] double seconds_to_build() const;

 private:
  struct Held;
  [[nodiscard]] ConnectionSet unreachable() const;

  ReplannerOptions options_;
  /// What is held for each of the last choices of limits, that of now first.
  std::vector<std::unique_ptr<Held>> held_;
  /// What the steps done so far have left behind.
  [[nodiscard]] Situation situation_of_steps() const;

  std::map<std::string, std::string> in_force_;
  std::optional<Vector3> last_place_;
  std::vector<PlanStep> planned_;  ///< of the last plan, where there is more to steps
  ConnectionSet open_;
  ConnectionSet inaccessible_;
  ConnectionSet not_next_;
  std::set<PartIndex> lost_;
  std::set<PartIndex> late_;
};

}  // namespace orasp
