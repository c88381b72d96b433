// Fuzz target: the bytes are a plan file of a fleet, for the built-in problem `fleet-lattice`.
//
// Whatever they are, the reader accepts them or refuses them in one sentence. A plan that it
// accepts is valid or has violations, each said in one sentence, and a valid one is written as a
// file that reads back as the same plan.
#include "fuzz/property.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/io/fleet_plan_json.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/scenarios.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace orasp;
  using namespace orasp::fuzz;
  static const Problem kProblem = load_scenario("fleet-lattice");
  static const FleetProblem kFleet(kProblem);
  const std::string_view text = text_of(data, size);
  static_cast<void>(is_fleet_plan(text));
  const auto file = accepted([&] { return parse_fleet_plan(text, kFleet); });
  if (!file) return 0;
  const FleetEvaluation replay = evaluate(kFleet, file->plan);
  require(replay.valid == replay.violations.empty(), "a plan is valid or has violations");
  for (const FleetViolation& violation : replay.violations)
    require(is_one_sentence(violation.message), "a violation is one sentence");
  if (!replay.valid) return 0;
  Result result;
  result.method = "fuzz";
  result.status = Status::Feasible;
  result.fleet_plan = file->plan;
  result.reward = -static_cast<double>(replay.makespan);
  const FleetPlanFile again = parse_fleet_plan(plan_text(kProblem, result, {}), kFleet);
  require(evaluate(kFleet, again.plan).valid, "writing a valid plan keeps it valid");
  require(again.plan.sequence() == file->plan.sequence(), "writing a plan keeps its sequence");
  return 0;
}
