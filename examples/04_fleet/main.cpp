// 04: several robots. A fleet takes a product apart in steps that all robots make at once: the
// fewest steps, or the least travel within some steps. The problem says so by its objective, and
// the answer comes by the same door as that for one robot.
#include <iostream>

#include "orasp/orasp.h"

namespace {

void print(const orasp::Problem& problem, const orasp::Result& result) {
  const orasp::FleetPlan& plan = result.fleet_plan;
  std::cout << problem.objective().type << ": " << orasp::status_name(result.status) << ", "
            << plan.makespan() << " steps, " << plan.travel() << " m^2\n";
  for (const orasp::FleetStep& step : plan.steps) {
    std::cout << "  " << step.robots_used << " robots cut";
    for (const orasp::ConnectionIndex c : step.cut) std::cout << ' ' << problem.connection_id(c);
    std::cout << '\n';
  }
}

}  // namespace

int main() {
  // A lattice of nine parts, four robots and four sites. Its objective is the makespan: the fewest
  // steps.
  const orasp::Problem lattice = orasp::load_scenario("fleet-lattice");
  print(lattice, orasp::solve(lattice, "fleet-search"));

  // The same product, with one step more than it takes at least, so that the robots travel less.
  const orasp::Problem thrifty = lattice.with_objective(orasp::Objective::named("fleet_travel"));
  orasp::Task task(thrifty);
  task.steps = 5;
  const orasp::Result result = orasp::solve(task, "fleet-search");
  print(thrifty, result);

  // The check replays the plan part by part, without the planner.
  const orasp::FleetProblem fleet(thrifty);
  std::cout << (orasp::evaluate(fleet, result.fleet_plan).valid ? "valid" : "not valid") << '\n';
}
