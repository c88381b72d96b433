#include "orasp/execution/waiting.h"

#include "orasp/planners/automatic.h"

namespace orasp {

Waiting waiting_for(const Problem& problem, const Situation& now, const ConnectionSet& missing,
                    const Budget& budget) {
  Situation later = now;
  later.late = ConnectionSet(problem.num_connections());
  Waiting answer{Status::Feasible, ConnectionSet(problem.num_connections())};
  ConnectionSet& waiting = answer.connections;
  for_each_connection(missing.view(), [&](ConnectionIndex c) {
    if (!now.open.contains(c) || now.inaccessible.contains(c)) return;
    later.late.insert(c);
    waiting.insert(c);
  });
  if (waiting.empty()) return answer;
  const TransitionSystem system(problem, later);
  const Result plan = automatic(system, 1, budget);
  if (!plan.has_plan()) {
    answer.status = plan.status;
    return answer;
  }
  bool waits = false;
  for (const ConnectionIndex c : plan.sequence) {
    waits = waits || waiting.contains(c);
    if (waits) waiting.insert(c);
  }
  return answer;
}

}  // namespace orasp
