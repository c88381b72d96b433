#include "orasp/model/validate.h"

#include <algorithm>
#include <cassert>
#include <set>
#include <stdexcept>
#include <unordered_map>

#include "orasp/model/detail/plan_replay.h"
#include "orasp/model/detail/wording.h"

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
  if (fault.constraint == Constraint::MaxSubassemblies) return system.infeasibility().value();
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

}  // namespace

Evaluation evaluate(const TransitionSystem& system, std::span<const std::string> sequence) {
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

  detail::PlanReplay replay = detail::replay(problem, system.situation(), indices, true);
  Evaluation evaluation;
  evaluation.valid = replay.faults.empty();
  evaluation.reward = replay.reward;
  evaluation.steps = std::move(replay.steps);
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
    const std::set<Constraint> found = found_at(i + 1);
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
    if (open.contains(indices[i])) open.erase(indices[i]);
  }
  for (; fault != replay.faults.end(); ++fault) {
    const std::string& id = problem.connection_id(fault->connection);
    report(fault->step, id, "\"" + id + "\" is missing at the end of the sequence");
  }
  return evaluation;
}

Evaluation evaluate(const TransitionSystem& system, std::span<const ConnectionIndex> sequence) {
  std::vector<std::string> ids;
  ids.reserve(sequence.size());
  for (const ConnectionIndex c : sequence) ids.push_back(system.problem().connection_id(c));
  return evaluate(system, ids);
}

Evaluation evaluate(const Problem& problem, std::span<const std::string> sequence) {
  return evaluate(TransitionSystem(problem), sequence);
}

Evaluation evaluate(const Problem& problem, std::span<const ConnectionIndex> sequence) {
  return evaluate(TransitionSystem(problem), sequence);
}

}  // namespace orasp
