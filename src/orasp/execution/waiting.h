#pragma once

#include "orasp/model/connection_set.h"
#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// What waits for parts that are not there.
struct Waiting {
  /// Feasible: the rest can be done once the parts are there. Infeasible: it is proved that the job
  /// cannot be finished even then. Unknown: the budget ended before that was known.
  Status status = Status::Unknown;
  /// What waits; unless Feasible, the open ones of what is missing.
  ConnectionSet connections = {};
};

/// What must wait for parts that are not there.
///
/// Problem.    The connections `missing` cannot be handled for now. Others must then wait too:
///             those that come after them by precedence, and those that would shut them out. The
///             answer is what waits, `missing` among it, such that everything else can be done now
///             and, once the parts are there, the rest after it.
/// Idea.       A plan of the whole job in which they are late (Situation::late): what comes before
///             the first of them is done now. There nothing else can be done that leaves a way to
///             the end.
/// Guarantee.  What it names can wait. Where several choices exist it is one of them, with the best
///             reward of the whole job where that is found.
/// Cost.       A plan of what is left of the job (planners/automatic.h).
[[nodiscard]] Waiting waiting_for(const Problem& problem, const Situation& now,
                                  const ConnectionSet& missing, const Budget& budget);

}  // namespace orasp
