#pragma once

#include <optional>
#include <span>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// What became of the steps of the old plan that were still to come.
struct PlanChanges {
  std::vector<ConnectionIndex> kept;     ///< in the order of both plans
  std::vector<ConnectionIndex> moved;    ///< in both plans, in the order of the new one
  std::vector<ConnectionIndex> dropped;  ///< of the old plan alone
  std::vector<ConnectionIndex> added;    ///< of the new plan alone
  std::optional<double>
      before;  ///< what the old steps would have earned; empty where they break a rule
  std::optional<double> price;  ///< that less what the new plan earns
};

/// Compares a new plan for what is left with the steps of an old one, done ones among them. As many
/// steps count as kept as can be.
[[nodiscard]] PlanChanges changes_between(const Problem& problem, const Situation& now,
                                          std::span<const PlanStep> old, const Result& result);

/// Where a goal cannot be reached any more: of what it asks for, connections that can still be
/// taken off together, as many as are found when they are added one by one; fewer, where the budget
/// ends. A greedy plan for each of them.
[[nodiscard]] std::vector<ConnectionIndex> still_reachable(const Problem& problem,
                                                           const Situation& now,
                                                           const Budget& budget);

}  // namespace orasp
