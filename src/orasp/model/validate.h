#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// A violation and the step (from 1) at which it happens.
struct StepViolation {
  std::size_t step;
  std::string connection;  ///< id as given, even if the problem has no such connection
  Violation violation;
};

/// A plan replayed.
struct Evaluation {
  bool valid = false;
  /// Of a plan with a goal: the connections that stay, ascending.
  std::vector<ConnectionIndex> stays;
  double reward = 0;        ///< sum over the steps that could be made
  std::vector<Step> steps;  ///< in the order of the problem's direction
  std::vector<StepViolation> violations;
};

/// Replays `sequence` (connection ids in the order of the problem's direction) and reports
/// everything that is wrong with it: unknown ids, repeated connections, missing ones, every
/// violated constraint. What is valid, the facts of steps and their rewards come from the replay
/// behind check_plan (model/plan_check.h), which shares no formula with the planners. The words for
/// a violation come from Expander::violations. `directions` is empty or has the name of the
/// direction that the plan states for each step, "" for none: to state one that is not free is a
/// violation, where the step moves something and the problem has blocking. Each step has the
/// direction that is stated, or one that is chosen (model/step_directions.h). O(steps * parts), the
/// size of the steps' lists, and O(parts + connections) more for each step that breaks a rule.
/// @throws std::logic_error if the two disagree about what a step breaks, InputError as check_plan.
[[nodiscard]] Evaluation evaluate(const Problem& problem, std::span<const std::string> sequence,
                                  std::span<const std::string> directions = {});
[[nodiscard]] Evaluation evaluate(const Problem& problem,
                                  std::span<const ConnectionIndex> sequence);
/// The same for a plan where there is more to steps (TransitionSystem::wide): what each takes, and
/// the direction in which it leaves.
[[nodiscard]] Evaluation evaluate(const TransitionSystem& system, std::span<const PlanStep> steps);
/// The same for what is left of the work: `sequence` holds the steps still to come.
[[nodiscard]] Evaluation evaluate(const TransitionSystem& system,
                                  std::span<const std::string> sequence,
                                  std::span<const std::string> directions = {});
[[nodiscard]] Evaluation evaluate(const TransitionSystem& system,
                                  std::span<const ConnectionIndex> sequence);

}  // namespace orasp
