// 02: an objective of your own. A plan's reward is the sum of what its steps earn, and what a step
// earns may be any function of the step.
//
// Here a workshop takes products apart for their modules. A piece of two or more parts that comes
// off whole can be sold and earns 5. A single part that comes off goes to scrap, which costs 1 a
// kilogram. Loosening what does not come off yet earns nothing.
#include <algorithm>
#include <iostream>

#include "orasp/orasp.h"

int main() {
  orasp::Callable modules;
  modules.name = "modules";
  modules.reward = [](const orasp::Step& step) {
    if (!step.separates) return 0.0;
    return step.moved().size() >= 2 ? 5.0 : -step.moved_mass;
  };
  // No step earns more than 5. Methods that search with a bound need to know.
  modules.greatest = 5;

  // The product is a lattice of nine parts of 1 kg that is built into the library.
  const orasp::Problem problem =
      orasp::load_scenario("lattice").with_objective({"callable", modules});

  // Three methods that prove their answers, by ways of their own: they must agree.
  for (const char* method : {"value-iteration", "orasp-search", "dijkstra"}) {
    const orasp::Result result = orasp::solve(problem, method);
    std::cout << method << ": " << orasp::status_name(result.status) << ", reward " << result.reward
              << '\n';
  }

  // The check replays a plan step by step, without the planner.
  const orasp::Result result = orasp::solve(problem, "value-iteration");
  const orasp::Evaluation replay = orasp::evaluate(problem, result.sequence);
  const auto sold = std::ranges::count_if(replay.steps, [](const orasp::Step& step) {
    return step.separates && step.moved().size() >= 2;
  });
  std::cout << (replay.valid ? "valid, " : "not valid, ") << sold << " modules sold\n";
  return replay.valid ? 0 : 1;
}
