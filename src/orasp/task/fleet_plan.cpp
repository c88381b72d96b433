#include "orasp/task/fleet_plan.h"

namespace orasp {

double FleetPlan::travel() const {
  double sum = 0;
  for (const FleetStep& step : steps) sum += step.distance;
  return sum;
}

std::vector<ConnectionIndex> FleetPlan::sequence() const {
  std::vector<ConnectionIndex> order;
  for (const FleetStep& step : steps) order.insert(order.end(), step.cut.begin(), step.cut.end());
  return order;
}

}  // namespace orasp
