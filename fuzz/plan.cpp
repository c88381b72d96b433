// Fuzz target: the bytes are a plan file, or a bare list of connection ids, for one robot.
//
// Whatever they are, parse_plan accepts them or refuses them in one sentence. A sequence that it
// accepts is judged against four problems: it is valid or has violations, each said in one
// sentence, and a valid one is written as a plan file that reads back as the same sequence.
#include <array>
#include <utility>
#include <vector>

#include "fuzz/property.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/validate.h"

namespace orasp::fuzz {
namespace {

/// 4piece, where parts stand in each other's way.
Problem blocked_4piece() {
  ProblemSpec spec = load_scenario("4piece").spec();
  spec.blocking = Blocking{{"+x", "-x", {"slant", Vector3{0, 3, 4}}},
                           {{spec.parts[0].id, spec.parts[1].id, {"+x", "-slant"}},
                            {spec.parts[2].id, spec.parts[1].id, {"-x", "slant"}}}};
  return Problem(std::move(spec));
}

const std::array<Problem, 4>& problems() {
  static const std::array<Problem, 4> kProblems = {
      load_scenario("4piece"), load_scenario("lattice"),
      load_scenario("lattice").with_direction(Direction::Assembly), blocked_4piece()};
  return kProblems;
}

void check_written(const Problem& problem, const PlanFile& plan, double reward) {
  Result result;
  result.method = "fuzz";
  result.status = Status::Feasible;
  result.reward = reward;
  for (const std::string& id : plan.sequence)
    result.sequence.push_back(problem.find_connection(id, ""));
  const PlanFile again = parse_plan(plan_text(problem, result, {}), problem.direction());
  require(again.sequence == plan.sequence, "writing a plan keeps its sequence");
  require(again.problem_digest == problem_digest(problem), "a plan names its problem");
  require(evaluate(problem, again.sequence, again.directions).valid,
          "the directions of a plan are free");
}

}  // namespace
}  // namespace orasp::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace orasp;
  using namespace orasp::fuzz;
  for (const Problem& problem : problems()) {
    const std::optional<PlanFile> plan =
        accepted([&] { return parse_plan(text_of(data, size), problem.direction()); });
    if (!plan) continue;
    const Evaluation replay = evaluate(problem, plan->sequence, plan->directions);
    require(replay.valid == replay.violations.empty(), "a plan is valid or has violations");
    for (const StepViolation& violation : replay.violations)
      require(is_one_sentence(violation.violation.message), "a violation is one sentence");
    if (replay.valid) check_written(problem, *plan, replay.reward);
  }
  return 0;
}
