#pragma once

#include <functional>
#include <memory>
#include <span>

#include "orasp/model/connection_set.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// Says how much speaks against each step of a state: a policy that was learned. A search may look
/// at it to choose what to look at first; nothing that is proved rests on it.
class StepAdvice {
 public:
  StepAdvice() = default;
  StepAdvice(const StepAdvice&) = delete;
  StepAdvice& operator=(const StepAdvice&) = delete;
  virtual ~StepAdvice() = default;

  /// Writes to `against` a number of 0 or more for each of the legal `actions` of the state `open`,
  /// the least for the one that it would take. Numbers of the steps of a plan are summed.
  /// Deterministic.
  virtual void judge(SetView open, std::span<const Action> actions, std::span<double> against) = 0;
};

/// Makes the advice for a system, one for each thread, which must outlive it.
using MakeAdvice = std::function<std::unique_ptr<StepAdvice>(const TransitionSystem& system)>;

}  // namespace orasp
