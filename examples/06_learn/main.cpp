// 06: learning. Tabular Q-learning plays episodes and improves its values after each one. It needs
// no neural network. Its values start at an upper bound on what can be earned, so they explore by
// themselves, and an episode that earns what they promise proves the plan.
//
// The deep Q-network (orasp::train, with libtorch) is for problems too large for a table; `orasp
// train` and docs/learning.md show it.
#include <iostream>

#include "orasp/orasp.h"

int main() {
  const orasp::Problem problem = orasp::load_scenario("hubble");
  const orasp::TransitionSystem system(problem);

  // The better the bound that the values start from, the fewer episodes it takes.
  for (const orasp::BoundKind bound : {orasp::BoundKind::Connections, orasp::BoundKind::Best}) {
    orasp::QLearningOptions options;
    options.seed = 7;
    options.bound = bound;
    const orasp::Result result = orasp::q_learning(system, options, {});
    std::cout << (bound == orasp::BoundKind::Best ? "best bound" : "bound on connections") << ": "
              << orasp::status_name(result.status) << ", reward " << result.reward << ", "
              << result.statistics.sweeps << " episodes\n";
  }

  // Learning and planning must agree.
  std::cout << "value iteration: reward " << orasp::solve(problem, "value-iteration").reward
            << '\n';
}
