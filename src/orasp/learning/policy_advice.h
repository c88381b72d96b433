#pragma once

#include <memory>

#include "orasp/learning/graph_policy.h"
#include "orasp/learning/policy.h"
#include "orasp/planners/step_advice.h"

namespace orasp {

/// What a policy says against steps, for searches that take advice.
///
/// Of a network that values actions: how much less than the best one an action is worth to it, in
/// units of reward. Of a graph policy, whose answers are taken for logarithms of shares as in its
/// training (softmax): minus the logarithm of the action's share.
[[nodiscard]] MakeAdvice advice_of(std::shared_ptr<const Policy> policy);
[[nodiscard]] MakeAdvice advice_of(std::shared_ptr<const GraphPolicy> policy);

}  // namespace orasp
