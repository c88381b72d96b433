#include "orasp/learning/policy_advice.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace orasp {

namespace {

class NetworkAdvice final : public StepAdvice {
 public:
  NetworkAdvice(std::shared_ptr<const Policy> policy, const TransitionSystem& system)
      : policy_(std::move(policy)), evaluator_(*policy_, system) {}

  void judge(SetView open, std::span<const Action> actions, std::span<double> against) override {
    if (actions.empty()) return;
    evaluator_.values(open, actions, against);
    const double most = std::ranges::max(against);
    for (double& number : against) number = most - number;
  }

 private:
  std::shared_ptr<const Policy> policy_;
  PolicyEvaluator evaluator_;
};

class GraphAdvice final : public StepAdvice {
 public:
  GraphAdvice(std::shared_ptr<const GraphPolicy> policy, const TransitionSystem& system)
      : policy_(std::move(policy)), observer_(system) {}

  void judge(SetView open, std::span<const Action> actions, std::span<double> against) override {
    if (actions.empty()) return;
    const GraphState state = observer_.observe(open, actions);
    const std::span<const float> worth = network_.worth(*policy_, state);
    const double most = std::ranges::max(worth);
    double sum = 0;
    for (const float number : worth) sum += std::exp(double{number} - most);
    for (std::size_t i = 0; i < worth.size(); ++i)
      against[i] = most + std::log(sum) - double{worth[i]};
  }

 private:
  std::shared_ptr<const GraphPolicy> policy_;
  GraphObserver observer_;
  GraphNetwork network_;
};

}  // namespace

MakeAdvice advice_of(std::shared_ptr<const Policy> policy) {
  return [policy = std::move(policy)](const TransitionSystem& system) {
    return std::make_unique<NetworkAdvice>(policy, system);
  };
}

MakeAdvice advice_of(std::shared_ptr<const GraphPolicy> policy) {
  return [policy = std::move(policy)](const TransitionSystem& system) {
    return std::make_unique<GraphAdvice>(policy, system);
  };
}

}  // namespace orasp
