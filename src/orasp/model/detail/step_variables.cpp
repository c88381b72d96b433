#include "orasp/model/detail/step_variables.h"

#include <set>

namespace orasp::detail {

FormulaVariables variables_of(const StepFacts& facts, const Movement& movement,
                              const StepPieces& pieces, const Vector3& depot) {
  FormulaVariables variables;
  variables.before = static_cast<double>(facts.before);
  variables.after = static_cast<double>(facts.after);
  variables.separates = facts.separates ? 1 : 0;
  variables.completes = facts.completes ? 1 : 0;
  variables.subassemblies = static_cast<double>(pieces.totals.assembly ? facts.subassemblies_joined
                                                                       : facts.subassemblies_apart);
  variables.duration = pieces.duration(facts);
  variables.index = facts.connection;
  variables.elapsed = facts.elapsed;
  if (facts.separates) {
    variables.moved_parts = movement.moved_parts;
    variables.kept_parts = movement.kept_parts;
    variables.moved_mass = movement.moved_mass;
    variables.kept_mass = movement.kept_mass;
    if (movement.moves) variables.distance = pieces.distance(movement.a_moves, depot).value_or(0);
  }
  return variables;
}

void own_numbers_of(const StepFacts& facts, const Movement& movement, const StepPieces& pieces,
                    std::size_t i, std::span<double> own) {
  const std::string& name = pieces.totals.own_numbers[i];
  own[3 * i] = pieces.number(facts, name);
  own[3 * i + 1] = own[3 * i + 2] = 0;
  if (!facts.separates) return;
  const double a = pieces.sum(pieces.a, name);
  const double b = pieces.sum(pieces.b, name);
  own[3 * i + 1] = !movement.moves ? 0.0 : movement.a_moves ? a : b;
  own[3 * i + 2] = !movement.moves ? a + b : movement.a_moves ? b : a;
}

FormulaVariables variables_of(const SeenStep& step, const Vector3& depot) {
  FormulaVariables seen;
  seen.before = static_cast<double>(step.before);
  seen.after = static_cast<double>(step.after);
  seen.separates = step.separates ? 1 : 0;
  seen.completes = step.completes ? 1 : 0;
  seen.moved_parts = static_cast<double>(step.moved_parts);
  seen.kept_parts = static_cast<double>(step.a_parts + step.b_parts - step.moved_parts);
  seen.elapsed = step.elapsed;
  seen.moved_mass = step.moved_mass;
  seen.kept_mass = step.kept_mass;
  seen.subassemblies = static_cast<double>(step.subassemblies);
  seen.duration = step.duration;
  seen.index = static_cast<double>(step.connection);
  if (step.moved_centroid) seen.distance = metres_between(*step.moved_centroid, depot);
  return seen;
}

std::vector<double> own_numbers_of(const SeenStep& step, std::span<const std::string> names) {
  std::vector<double> own;
  for (const std::string& name : names) {
    own.push_back(step.number(name));
    own.push_back(step.moved_number(name));
    own.push_back(step.kept_number(name));
  }
  return own;
}

std::vector<std::string> numbers_of(const ProblemSpec& problem) {
  std::set<std::string> names;
  for (const Part& part : problem.parts) {
    for (const auto& number : part.numbers) names.insert(number.first);
  }
  for (const Connection& connection : problem.connections) {
    for (const auto& number : connection.numbers) names.insert(number.first);
  }
  return {names.begin(), names.end()};
}

}  // namespace orasp::detail
