// Another table of methods, linked in place of the library's (src/orasp/catalogue_table.cpp): each
// takes the plan of an honest method and spoils it. The program made with it must refuse to say, to
// write or to compare what they answer (tests/cli/false_methods_test.py).

#include <array>

#include "orasp/catalogue.h"
#include "orasp/fleet/fleet_search.h"
#include "orasp/planners/greedy.h"

namespace orasp {
namespace {

/// An honest plan, of one robot or of several.
Result honest(const Request& request) {
  return request.fleet != nullptr
             ? fleet_search(*request.fleet, request.fleet_options(), request.budget)
             : greedy(*request.system, request.budget);
}

/// Leaves the last step out.
Result unfinished(const Request& request) {
  Result result = honest(request);
  if (!result.sequence.empty()) result.sequence.pop_back();
  if (!result.fleet_plan.steps.empty()) result.fleet_plan.steps.pop_back();
  return result;
}

/// Claims half a unit more than the plan earns.
Result boastful(const Request& request) {
  Result result = honest(request);
  result.reward += 0.5;
  return result;
}

/// Makes the steps in the opposite order, which a precedence forbids.
Result backwards(const Request& request) {
  Result result = honest(request);
  result.sequence.assign(result.sequence.rbegin(), result.sequence.rend());
  return result;
}

constexpr std::array kPlanners = {
    Planner{.name = "auto",
            .summary = "what commands use that take no method: it leaves a step out",
            .role = Role::Chooser,
            .fleets = true,
            .run = unfinished},
    Planner{
        .name = "unfinished", .summary = "a step is missing", .fleets = true, .run = unfinished},
    Planner{.name = "boastful", .summary = "the reward is wrong", .fleets = true, .run = boastful},
    Planner{.name = "backwards", .summary = "the order is wrong", .run = backwards},
    Planner{.name = "greedy", .summary = "honest", .fleets = true, .run = honest},
};

}  // namespace

std::span<const Planner> planners() {
  return kPlanners;
}

}  // namespace orasp
