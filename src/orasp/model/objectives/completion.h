#pragma once

namespace orasp {

class ObjectiveKind;

/// `completion`: +join if the step separates, -step always, +bonus if it completes.
struct CompletionObjective {
  double join = 100;
  double step = 1;
  double bonus = 1000;
};

[[nodiscard]] const ObjectiveKind& completion_kind();

}  // namespace orasp
