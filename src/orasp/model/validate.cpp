#include "orasp/model/validate.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <unordered_map>

#include "orasp/model/detail/plan_replay.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/step_directions.h"

namespace orasp {

namespace {

/// The rules found broken at one step by the replay are those found by the planners' own, but for
/// those that an earlier step has broken, which are dropped.
void expect_agreement(const std::set<Constraint>& found, std::vector<Violation>& violations,
                      std::size_t step, const std::string& id) {
  std::erase_if(violations, [](const Violation& violation) { return violation.too_late; });
  std::set<Constraint> named;
  for (const Violation& violation : violations) named.insert(violation.constraint);
  if (named != found) {
    throw std::logic_error("the check of plans and the rules of planners disagree about step " +
                           std::to_string(step) + ", " + detail::in_quotes(id));
  }
}

/// In words, a rule that is broken where the plan begins.
Violation violation_at_start(const TransitionSystem& system, const detail::PlanFault& fault) {
  if (fault.constraint == Constraint::MaxSubassemblies || fault.constraint == Constraint::Grounded)
    return system.infeasibility().value();
  const Problem& problem = system.problem();
  const auto name = [&](ConnectionIndex c) { return detail::in_quotes(problem.connection_id(c)); };
  std::string message = name(fault.connection);
  switch (fault.constraint) {
    case Constraint::Precedence:
      message += " must be made before " + name(fault.other) + ", which is made already";
      break;
    case Constraint::PrecedenceAny:
      message += " must be made before at least one of others, which are all made already";
      break;
    default: message += " is there without any of the connections of which it needs one";
  }
  return {fault.constraint, "precedence[" + std::to_string(fault.entry) + "]", message, {}};
}

/// By their names; none where the plan states none, or one that the problem does not have.
std::vector<std::optional<DirectionIndex>> stated_directions(
    const Problem& problem, std::span<const std::string> directions) {
  std::vector<std::optional<DirectionIndex>> stated;
  stated.reserve(directions.size());
  for (const std::string& name : directions) stated.push_back(problem.find_direction(name));
  return stated;
}

/// For each step that was made, its place in the sequence.
std::vector<std::size_t> places_of(std::span<const Step> steps,
                                   std::span<const ConnectionIndex> sequence) {
  std::vector<std::size_t> places;
  places.reserve(steps.size());
  for (std::size_t i = 0; i < sequence.size() && places.size() < steps.size(); ++i) {
    if (steps[places.size()].connection == sequence[i]) places.push_back(i);
  }
  return places;
}

void direct(std::span<Step> steps, std::span<const ConnectionIndex> sequence,
            std::span<const std::optional<DirectionIndex>> stated) {
  if (stated.empty()) return choose_directions(steps);
  std::vector<std::optional<DirectionIndex>> of_steps;
  for (const std::size_t place : places_of(steps, sequence)) of_steps.push_back(stated[place]);
  choose_directions(steps, of_steps);
}

std::string names_of(const Problem& problem, std::span<const DirectionIndex> directions) {
  std::vector<std::string_view> names;
  for (const DirectionIndex d : directions) names.emplace_back(problem.direction_name(d));
  return detail::listed_in_short(names);
}

/// What is wrong with the directions that a plan states, by place in its sequence. Where no
/// direction is free, that is a violation of its own.
std::map<std::size_t, Violation> wrong_directions(const Problem& problem,
                                                  std::span<const Step> steps,
                                                  std::span<const ConnectionIndex> sequence,
                                                  std::span<const std::string> directions,
                                                  const detail::PlanReplay& replay) {
  std::map<std::size_t, Violation> wrong;
  if (directions.empty() || problem.directions().empty()) return wrong;
  std::map<std::size_t, detail::PlanDirectionFault> faults;
  for (const detail::PlanDirectionFault& fault : replay.direction_faults)
    faults.emplace(fault.step - 1, fault);
  const std::vector<std::size_t> places = places_of(steps, sequence);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const std::size_t place = places[k];
    const std::string& name = directions[place];
    if (steps[k].free_directions.empty() || name.empty() || steps[k].moved().empty()) continue;
    std::string message;
    if (!problem.find_direction(name)) {
      message = "the plan states the direction " + detail::in_quotes(name) +
                ", which is not in blocking.directions; free are " +
                names_of(problem, steps[k].free_directions);
    } else if (const auto fault = faults.find(place); fault != faults.end()) {
      const auto part = [&](PartIndex p) { return detail::in_quotes(problem.part_id(p)); };
      message = "the plan states the direction " + name + ", in which " + part(fault->second.by) +
                " is in the way of " + part(fault->second.part) + "; free are " +
                names_of(problem, steps[k].free_directions);
    } else {
      continue;
    }
    wrong.emplace(place, Violation{Constraint::Blocking, "blocking", std::move(message), {}});
  }
  return wrong;
}

/// What is there after the steps of a plan with a goal.
std::vector<ConnectionIndex> staying(const TransitionSystem& system, std::span<const Step> steps) {
  std::vector<ConnectionIndex> stays;
  if (!system.problem().spec().goal) return stays;
  ConnectionSet there = system.present(system.start().view());
  for (const Step& step : steps) {
    for (const ConnectionIndex c : step.connections) there.erase(c);
  }
  for_each_connection(there.view(), [&](ConnectionIndex c) { stays.push_back(c); });
  return stays;
}

}  // namespace

Evaluation evaluate(const TransitionSystem& system, std::span<const std::string> sequence,
                    std::span<const std::string> directions) {
  const Problem& problem = system.problem();
  const std::size_t connections = problem.num_connections();
  std::unordered_map<std::string_view, ConnectionIndex> by_id;
  for (ConnectionIndex c = 0; c < connections; ++c) by_id.emplace(problem.connection_id(c), c);
  // An id that the problem does not have becomes a position that it does not have.
  std::vector<ConnectionIndex> indices;
  indices.reserve(sequence.size());
  for (const std::string& id : sequence) {
    const auto found = by_id.find(id);
    indices.push_back(found != by_id.end() ? found->second
                                           : static_cast<ConnectionIndex>(connections));
  }

  const std::vector<std::optional<DirectionIndex>> stated = stated_directions(problem, directions);
  detail::PlanReplay replay = detail::replay(problem, system.situation(), indices, true, stated);
  Evaluation evaluation;
  evaluation.reward = replay.reward;
  evaluation.steps = std::move(replay.steps);
  direct(evaluation.steps, indices, stated);
  const std::map<std::size_t, Violation> misdirected =
      wrong_directions(problem, evaluation.steps, indices, directions, replay);
  evaluation.stays = staying(system, evaluation.steps);
  evaluation.valid = replay.faults.empty() && misdirected.empty();
  if (evaluation.valid) return evaluation;

  // The words for what is wrong.
  Expander expander(system);
  ConnectionSet open = system.start();
  auto fault = replay.faults.begin();
  const auto found_at = [&](std::size_t step) {
    std::set<Constraint> found;
    for (; fault != replay.faults.end() && fault->step == step; ++fault)
      found.insert(fault->constraint);
    return found;
  };
  for (const auto at_start = fault; fault != replay.faults.end() && fault->step == 0; ++fault) {
    if (fault == at_start && !system.infeasibility())
      throw std::logic_error("the check of plans and the rules disagree at the start");
    evaluation.violations.push_back({0, "", violation_at_start(system, *fault)});
  }
  const auto report = [&](std::size_t step, const std::string& id, std::string message) {
    evaluation.violations.push_back({step, id, {Constraint::NotOpen, "", std::move(message), {}}});
  };
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const std::string& id = sequence[i];
    std::set<Constraint> found = found_at(i + 1);
    if (found.erase(Constraint::Goal) > 0) {
      evaluation.violations.push_back(
          {i + 1,
           id,
           {Constraint::Goal, "goal", "the goal was reached before, and the plan ends there", {}}});
    }
    if (indices[i] >= connections) {
      report(i + 1, id, "the problem has no connection " + detail::in_quotes(id));
      continue;
    }
    if (!found.empty()) {
      std::vector<Violation> violations = expander.violations(open.view(), indices[i]);
      if (!replay.late_judged) {
        std::erase_if(violations, [](const Violation& violation) {
          return violation.constraint == Constraint::Late;
        });
      }
      expect_agreement(found, violations, i + 1, id);
      for (Violation& violation : violations)
        evaluation.violations.push_back({i + 1, id, std::move(violation)});
    }
    if (const auto wrong = misdirected.find(i); wrong != misdirected.end())
      evaluation.violations.push_back({i + 1, id, wrong->second});
    if (open.contains(indices[i])) open.erase(indices[i]);
  }
  for (; fault != replay.faults.end(); ++fault) {
    const std::string& id = problem.connection_id(fault->connection);
    report(fault->step, id,
           "\"" + id + "\" is missing at the end of the sequence" +
               (problem.spec().goal ? ", and the goal asks for it" : ""));
  }
  return evaluation;
}

Evaluation evaluate(const TransitionSystem& system, std::span<const PlanStep> steps) {
  const Problem& problem = system.problem();
  detail::PlanReplay replay = detail::replay(problem, system.situation(), steps, true);
  Evaluation evaluation;
  evaluation.reward = replay.reward;
  evaluation.steps = std::move(replay.steps);
  std::vector<std::optional<DirectionIndex>> stated;
  for (std::size_t i = 0; i < evaluation.steps.size(); ++i)
    stated.push_back(i < steps.size() ? steps[i].direction : std::nullopt);
  choose_directions(evaluation.steps, stated);
  evaluation.stays = staying(system, evaluation.steps);
  evaluation.valid = replay.faults.empty() && replay.direction_faults.empty();
  const auto id_of = [&](std::size_t step) -> std::string {
    if (step == 0 || step > steps.size() || steps[step - 1].connections.empty()) return "";
    const ConnectionIndex first = steps[step - 1].connections.front();
    return first < problem.num_connections() ? problem.connection_id(first) : "";
  };
  for (const detail::PlanFault& fault : replay.faults) {
    const bool missing = fault.step > steps.size();
    evaluation.violations.push_back(
        {fault.step,
         missing ? problem.connection_id(fault.connection) : id_of(fault.step),
         {fault.constraint, "", detail::fault_sentence(problem, fault, steps.size()), {}}});
  }
  for (const detail::PlanDirectionFault& fault : replay.direction_faults) {
    const auto part = [&](PartIndex p) { return detail::in_quotes(problem.part_id(p)); };
    evaluation.violations.push_back(
        {fault.step,
         id_of(fault.step),
         {Constraint::Blocking,
          "blocking",
          "the plan states the direction " + problem.direction_name(fault.direction) +
              ", in which " + part(fault.by) + " is in the way of " + part(fault.part),
          {}}});
  }
  std::ranges::stable_sort(evaluation.violations, {}, &StepViolation::step);
  return evaluation;
}

Evaluation evaluate(const TransitionSystem& system, std::span<const ConnectionIndex> sequence) {
  std::vector<std::string> ids;
  ids.reserve(sequence.size());
  for (const ConnectionIndex c : sequence) ids.push_back(system.problem().connection_id(c));
  return evaluate(system, ids);
}

Evaluation evaluate(const Problem& problem, std::span<const std::string> sequence,
                    std::span<const std::string> directions) {
  return evaluate(TransitionSystem(problem), sequence, directions);
}

Evaluation evaluate(const Problem& problem, std::span<const ConnectionIndex> sequence) {
  return evaluate(TransitionSystem(problem), sequence);
}

}  // namespace orasp
