#include "orasp/model/validate.h"

namespace orasp {

namespace {

std::vector<std::string> ids_of(const Problem& problem, std::span<const ConnectionIndex> sequence) {
  std::vector<std::string> ids;
  ids.reserve(sequence.size());
  for (const ConnectionIndex c : sequence) ids.push_back(problem.connection_id(c));
  return ids;
}

}  // namespace

Evaluation evaluate(const TransitionSystem& system, std::span<const std::string> sequence) {
  const Problem& problem = system.problem();
  Expander expander(system);
  Evaluation evaluation;
  ConnectionSet open = system.start();

  const auto report = [&](std::size_t step, const std::string& id, Constraint constraint,
                          std::string message) {
    evaluation.violations.push_back({step, id, {constraint, "", std::move(message), {}}});
  };
  if (auto reason = system.infeasibility();
      reason && reason->constraint == Constraint::MaxSubassemblies) {
    evaluation.violations.push_back({0, "", std::move(*reason)});
  }
  const auto by_id = [&] {
    std::unordered_map<std::string_view, ConnectionIndex> map;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c)
      map.emplace(problem.connection_id(c), c);
    return map;
  }();

  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const std::string& id = sequence[i];
    const auto found = by_id.find(id);
    if (found == by_id.end()) {
      report(i + 1, id, Constraint::NotOpen, "the problem has no connection \"" + id + "\"");
      continue;
    }
    const ConnectionIndex c = found->second;
    for (Violation& violation : expander.violations(open.view(), c)) {
      evaluation.violations.push_back({i + 1, id, std::move(violation)});
    }
    if (!open.contains(c)) continue;
    evaluation.steps.push_back(expander.step(open.view(), c));
    evaluation.reward += evaluation.steps.back().reward;
    open.erase(c);
  }
  for_each_connection(open.view(), [&](ConnectionIndex c) {
    report(sequence.size() + 1, problem.connection_id(c), Constraint::NotOpen,
           "\"" + problem.connection_id(c) + "\" is missing at the end of the sequence");
  });
  evaluation.valid = evaluation.violations.empty();
  return evaluation;
}

Evaluation evaluate(const TransitionSystem& system, std::span<const ConnectionIndex> sequence) {
  return evaluate(system, ids_of(system.problem(), sequence));
}

Evaluation evaluate(const Problem& problem, std::span<const std::string> sequence) {
  return evaluate(TransitionSystem(problem), sequence);
}

Evaluation evaluate(const Problem& problem, std::span<const ConnectionIndex> sequence) {
  return evaluate(TransitionSystem(problem), ids_of(problem, sequence));
}

}  // namespace orasp
