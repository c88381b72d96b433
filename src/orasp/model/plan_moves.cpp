#include "orasp/model/plan_moves.h"

#include <utility>

#include "orasp/model/detail/plan_replay.h"
#include "orasp/model/step_directions.h"

namespace orasp {

Evaluation evaluate_moves(const TransitionSystem& system,
                          std::span<const ConnectionIndex> sequence) {
  if (system.wide()) return evaluate(system, sequence);
  detail::PlanReplay replay = detail::replay_moves(system.problem(), system.situation(), sequence);
  if (!replay.faults.empty()) return evaluate(system, sequence);
  Evaluation evaluation;
  evaluation.valid = true;
  evaluation.reward = replay.reward;
  evaluation.steps = std::move(replay.steps);
  choose_directions(evaluation.steps, {});
  return evaluation;
}

}  // namespace orasp
