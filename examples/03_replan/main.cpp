// 03: replanning. The work stands in the middle, something happens, and the question is what is
// best from here. A Replanner answers it again and again, in microseconds once it holds the graph
// of the problem.
#include <iostream>
#include <string>

#include "orasp/orasp.h"

namespace {

void print(const std::string& heading, const orasp::Problem& problem, const orasp::Result& plan) {
  std::cout << heading << ": " << orasp::status_name(plan.status);
  if (plan.has_plan()) {
    std::cout << ", reward " << plan.reward << ", " << plan.sequence.size() << " steps";
    std::cout << ", next " << problem.connection_id(plan.sequence.front());
  }
  std::cout << '\n';
}

}  // namespace

int main() {
  const orasp::Problem problem = orasp::load_scenario("hubble");
  orasp::Replanner replanner(problem);
  orasp::Result plan = replanner.plan();
  print("at first", problem, plan);

  // The cell works off five steps.
  for (std::size_t step = 0; step < 5; ++step) replanner.done(plan.sequence[step]);
  plan = replanner.plan();
  print("five steps later", problem, plan);

  // The gripper cannot reach the next connection for now. Any other may be next.
  replanner.set_possible_next(plan.sequence.front(), false);
  print("next one out of reach", problem, replanner.plan());

  // Worse: the connection 5-14 is stuck for good. It stays, and the rest is planned around it.
  const orasp::ConnectionIndex stuck = problem.find_connection("5-14", "");
  replanner.set_accessible(stuck, false);
  print("5-14 is stuck", problem, replanner.plan());

  // Somebody oils it. Taking a change back is as easy as making it.
  replanner.set_accessible(stuck, true);
  print("5-14 is free again", problem, replanner.plan());

  // The crane fails, and what is left of it carries single parts alone.
  orasp::Limits weak;
  weak.max_moved_parts = 1;
  replanner.set_limits(weak);
  print("one part at a time", problem, replanner.plan());
}
