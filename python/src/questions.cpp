#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/catalogue.h"
#include "orasp/execution/simulation.h"
#include "orasp/explain/explain_connection.h"
#include "orasp/explain/explain_problem.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/io/explanation_json.h"
#include "orasp/io/fleet_plan_json.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/state_policy_json.h"
#include "orasp/model/validate.h"
#include "orasp/planners/random_rewards.h"
#include "orasp/planners/reward_statistics.h"
#include "orasp/task/task.h"
#include "outcome.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {

void require_one_robot(const Problem& problem, const char* command) {
  if (!problem.objective().of_fleet()) return;
  throw InputError(
      fmt::format("{} answers for one robot, and the objective of this problem is {}, one of "
                  "several; another objective asks about one",
                  command, problem.objective().type));
}

namespace {

/// Violations and conflicts: (constraint, where, message).
template <class Items>
py::list items_as_tuples(const Items& items) {
  py::list list;
  for (const auto& item : items)
    list.append(py::make_tuple(constraint_name(item.constraint), item.where, item.message));
  return list;
}

/// The verdict on a plan with the keys of `orasp evaluate --json`, the steps of one robot and the
/// digest that the plan names.
struct Verdict {
  bool valid = false;
  double reward = 0;
  std::size_t steps = 0;
  std::optional<double> travel;  ///< m^2, of several robots
  struct Fault {
    std::size_t step;
    std::string connection;
    std::string constraint;
    std::string message;
  };
  std::vector<Fault> faults;
  bool of_another_problem = false;
};

Verdict verdict_of_fleet(const Problem& problem, const std::string& text) {
  const FleetProblem fleet(problem);
  const FleetPlanFile file = parse_fleet_plan(text, fleet);
  const FleetEvaluation found = evaluate(fleet, file.plan);
  Verdict verdict{.valid = found.valid,
                  .reward = fleet.objective() == FleetObjective::Makespan
                                ? 0.0 - static_cast<double>(found.makespan)
                                : 0.0 - found.travel,
                  .steps = found.makespan,
                  .travel = found.travel,
                  .faults = {},
                  .of_another_problem = !file.problem_digest.empty() &&
                                        file.problem_digest != problem_digest(problem)};
  for (const FleetViolation& fault : found.violations)
    verdict.faults.push_back(
        {fault.step, fault.connection, std::string(rule_name(fault.rule)), fault.message});
  return verdict;
}

Verdict verdict_of(const Problem& problem, const std::string& text) {
  const bool of_fleet = problem.objective().of_fleet();
  if (is_fleet_plan(text) != of_fleet) {
    throw InputError(fmt::format("it is a plan of {}, and {} is an objective of {}",
                                 of_fleet ? "one robot" : "several robots",
                                 problem.objective().type, of_fleet ? "several robots" : "one"));
  }
  if (of_fleet) return verdict_of_fleet(problem, text);
  const PlanFile plan = parse_plan(text, problem.direction());
  const Evaluation found = replayed(problem, plan);
  Verdict verdict{.valid = found.valid,
                  .reward = found.reward,
                  .steps = found.steps.size(),
                  .travel = {},
                  .faults = {},
                  .of_another_problem = !plan.problem_digest.empty() &&
                                        plan.problem_digest != problem_digest(problem)};
  for (const StepViolation& fault : found.violations)
    verdict.faults.push_back({fault.step, fault.connection,
                              std::string(constraint_name(fault.violation.constraint)),
                              fault.violation.message});
  return verdict;
}

py::tuple evaluate_plan(const ProblemPointer& problem, const std::string& text) {
  Verdict verdict;
  Run run;
  run.calls_back = calls_python(*problem);
  run_watched(run, false, [&](const Budget&) { verdict = verdict_of(*problem, text); });
  py::list faults;
  for (const Verdict::Fault& fault : verdict.faults)
    faults.append(py::make_tuple(fault.step, fault.connection, fault.constraint, fault.message));
  return py::make_tuple(verdict.valid, verdict.reward, verdict.steps, verdict.travel,
                        std::move(faults), verdict.of_another_problem);
}

py::tuple explain(const ProblemPointer& problem, Run run) {
  require_one_robot(*problem, "explain");
  ProblemExplanation found;
  run.calls_back = calls_python(*problem);
  run_watched(run, true, [&](const Budget& budget) { found = explain_problem(*problem, budget); });
  std::optional<std::string_view> stopped;
  if (found.stop != Stop::None) stopped = stop_name(found.stop);
  return py::make_tuple(status_name(found.status), items_as_tuples(found.conflict), found.minimal,
                        found.tests, stopped);
}

/// The state in which the first connections of a sequence are handled.
ConnectionSet open_after(const Problem& problem, const std::vector<std::string>& done) {
  ConnectionSet open = TransitionSystem(problem).start();
  for (std::size_t i = 0; i < done.size(); ++i) {
    const std::string place = fmt::format("done[{}]", i);
    const ConnectionIndex c = problem.find_connection(done[i], place);
    if (!open.contains(c))
      throw InputError(fmt::format("{}: \"{}\" is handled a second time", place, done[i]));
    open.erase(c);
  }
  return open;
}

py::tuple explain_one(const ProblemPointer& problem, const std::string& id,
                      const std::vector<std::string>& done, Run run) {
  require_one_robot(*problem, "explain");
  if (problem->spec().action == StepKind::Part) {
    throw InputError(
        "explain answers about a connection where steps take one connection; with \"action\": "
        "\"part\" a step takes several");
  }
  const ConnectionIndex connection = problem->find_connection(id, "connection");
  const ConnectionSet open = open_after(*problem, done);
  ConnectionExplanation found;
  run.calls_back = calls_python(*problem);
  run_watched(run, true, [&](const Budget& budget) {
    found = explain_connection(*problem, open, connection, budget);
  });
  const char* const later = found.later == ConnectionExplanation::Later::Legal   ? "legal"
                            : found.later == ConnectionExplanation::Later::Never ? "never"
                                                                                 : "unknown";
  return py::make_tuple(found.legal, items_as_tuples(found.violations),
                        changes_text(*problem, found), found.plan_exists, later,
                        ids_of(*problem, found.after), found.fewest);
}

/// What is known of numbers: mean, deviation, least, the percentiles 5, 25, 50, 75 and 95,
/// greatest; None where there are none.
py::object figures_as_tuple(const std::vector<double>& numbers) {
  if (numbers.empty()) return py::none();
  const RewardFigures figures = figures_of(numbers);
  return py::make_tuple(figures.mean, figures.deviation, figures.least, figures.percentiles,
                        figures.greatest);
}

std::optional<std::string_view> name_of(Stop stop) {
  return stop == Stop::None ? std::nullopt : std::optional(stop_name(stop));
}

py::tuple sample(const ProblemPointer& problem, std::uint64_t count, std::uint64_t seed,
                 bool with_sequences, Run run) {
  require_one_robot(*problem, "sample");
  RandomRewards drawn;
  run.calls_back = calls_python(*problem);
  run_watched(run, true, [&](const Budget& budget) {
    const TransitionSystem system(*problem);
    if (const std::optional<Violation> reason = system.infeasibility()) {
      drawn.last.status = Status::Infeasible;
      drawn.last.notes = {reason->message};
    } else {
      drawn = draw_rewards(system, count, seed, with_sequences, budget);
    }
  });
  py::object sequences = py::none();
  if (with_sequences) {
    py::list list;
    for (const auto& sequence : drawn.sequences) list.append(numbers_of(sequence));
    sequences = std::move(list);
  }
  py::object figures = figures_as_tuple(drawn.rewards);
  return py::make_tuple(array_of(std::move(drawn.rewards)), std::move(figures),
                        std::move(sequences), drawn.last.status == Status::Infeasible,
                        name_of(drawn.last.stop), drawn.last.notes);
}

py::tuple simulate_problem(const ProblemPointer& problem, const std::optional<std::string>& plan,
                           const std::optional<std::string>& policy, std::uint64_t count,
                           std::uint64_t seed, Run run) {
  require_one_robot(*problem, "simulate");
  const TransitionSystem system(*problem);
  if (const auto reason = simulation_obstacle(system)) throw InputError(*reason);
  if (system.wide() && policy)
    throw InputError(
        "policy: a policy is for attempts that may fail, and here each succeeds; give a plan");
  Followed found;
  run.calls_back = calls_python(*problem);
  run_watched(run, true, [&](const Budget& budget) {
    std::optional<Evaluation> replay;
    if (plan) replay = replayed(*problem, parse_plan(*plan, problem->direction()));
    std::optional<std::vector<PolicyState>> states;
    if (policy) states = parse_state_policy(system, *policy);
    const auto find = [&](const Budget& within) {
      return solve(Task(*problem), "auto", Options(), within);
    };
    found = follow(system, replay ? &*replay : nullptr, states ? &*states : nullptr, find,
                   {.runs = count, .seed = seed}, budget);
  });
  if (!found.proved_best) found.notes.emplace_back("the plan is not proved best");
  const bool infeasible = found.status == Status::Infeasible;
  const auto where_known = [&](double value) {
    return found.status == Status::Feasible ? std::optional(value) : std::nullopt;
  };
  Simulation& simulation = found.simulation;
  py::object figures = figures_as_tuple(simulation.rewards);
  return py::make_tuple(
      array_of(std::move(simulation.rewards)),
      array_of(std::vector<std::int64_t>(simulation.attempts.begin(), simulation.attempts.end())),
      std::move(figures), where_known(found.expected), where_known(found.expected_attempts),
      simulation.aborted, simulation.replanned, infeasible, name_of(simulation.stop), found.notes);
}

}  // namespace

void bind_questions(py::module_& module) {
  module.def("evaluate", &evaluate_plan);
  module.def("explain", &explain);
  module.def("explain_connection", &explain_one);
  module.def("sample", &sample);
  module.def("simulate", &simulate_problem);
}

}  // namespace orasp::python
