#include "orasp/model/detail/step_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "orasp/model/detail/reward_size.h"
#include "orasp/model/detail/wording.h"

namespace orasp::detail {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

bool nearly_equal(double a, double b) {
  return std::abs(a - b) <= kRelativeTolerance * std::max(std::abs(a), std::abs(b));
}

/// One side moves: which one is set.
void complete(Movement& movement, const StepFacts& facts, double mass_a, double mass_b) {
  movement.moves = true;
  movement.moved_parts = movement.a_moves ? facts.a_parts : facts.b_parts;
  movement.kept_parts = movement.a_moves ? facts.b_parts : facts.a_parts;
  movement.moved_mass = movement.a_moves ? mass_a : mass_b;
  movement.kept_mass = movement.a_moves ? mass_b : mass_a;
}

}  // namespace

double StepPieces::mass(const Side& side) const {
  if (totals.uniform_mass) return static_cast<double>(side.parts()) * totals.part_mass;
  double sum = 0;
  side.for_each([&](PartIndex part) { sum += totals.problem.parts()[part].mass; });
  return sum;
}

bool StepPieces::has_base(const Side& side) const {
  bool found = false;
  side.for_each([&](PartIndex part) { found = found || totals.problem.in_base(part); });
  return found;
}

double StepPieces::duration(const StepFacts& facts) const {
  const std::vector<Connection>& connections = totals.problem.connections();
  if (several.empty()) return connections[facts.connection].duration;
  double sum = 0;
  for (const ConnectionIndex c : several) sum += connections[c].duration;
  return sum;
}

double StepPieces::number(const StepFacts& facts, const std::string& name) const {
  const auto of = [&](ConnectionIndex c) {
    const auto& stated = totals.problem.connections()[c].numbers;
    const auto found = stated.find(name);
    return found == stated.end() ? 0.0 : found->second;
  };
  if (several.empty()) return of(facts.connection);
  double sum = 0;
  for (const ConnectionIndex c : several) sum += of(c);
  return sum;
}

double StepPieces::sum(const Side& side, const std::string& number) const {
  double sum = 0;
  side.for_each([&](PartIndex part) {
    const auto& numbers = totals.problem.parts()[part].numbers;
    const auto stated = numbers.find(number);
    if (stated != numbers.end()) sum += stated->second;
  });
  return sum;
}

// The side without base part moves, and none where both hold one. Else the side with fewer parts
// moves; where both have as many, the lighter one; where both weigh the
// same, the one that does not hold the earliest listed of their parts.
Movement StepPieces::movement(const StepFacts& facts) const {
  Movement result;
  const double mass_a = mass(a);
  const double mass_b = mass(b);
  if (!totals.problem.base().empty()) {
    const bool a_stays = has_base(a);
    const bool b_stays = has_base(b);
    if (a_stays && b_stays) {
      result.kept_parts = facts.a_parts + facts.b_parts;
      result.kept_mass = mass_a + mass_b;
      return result;
    }
    if (a_stays || b_stays) {
      result.a_moves = b_stays;
      complete(result, facts, mass_a, mass_b);
      return result;
    }
  }
  if (facts.a_parts != facts.b_parts) {
    result.a_moves = facts.a_parts < facts.b_parts;
  } else if (!nearly_equal(mass_a, mass_b)) {
    result.a_moves = mass_a < mass_b;
  } else {
    PartIndex first_a = kNone;
    PartIndex first_b = kNone;
    a.for_each([&](PartIndex part) { first_a = std::min(first_a, part); });
    b.for_each([&](PartIndex part) { first_b = std::min(first_b, part); });
    result.a_moves = first_b < first_a;
  }
  complete(result, facts, mass_a, mass_b);
  return result;
}

std::optional<double> StepPieces::distance(bool a_moves, const Vector3& depot) const {
  const Side& moved = a_moves ? a : b;
  Vector3 sum{};
  bool known = true;
  moved.for_each([&](PartIndex part) {
    const auto& position_of_part = totals.problem.parts()[part].position;
    if (!position_of_part) {
      known = false;
      return;
    }
    for (std::size_t i = 0; i < 3; ++i) sum[i] += (*position_of_part)[i];
  });
  if (!known) return std::nullopt;
  const auto n = static_cast<double>(moved.parts());
  return std::hypot(sum[0] / n - depot[0], sum[1] / n - depot[1], sum[2] / n - depot[2]);
}

Step StepPieces::full_step(const StepFacts& facts) const {
  Step step;
  step.connection = facts.connection;
  step.connections = {facts.connection};
  if (!several.empty()) step.connections.assign(several.begin(), several.end());
  step.before = facts.before;
  step.after = facts.after;
  step.separates = facts.separates;
  step.completes = facts.completes;
  step.subassemblies = totals.assembly ? facts.subassemblies_joined : facts.subassemblies_apart;
  if (!facts.separates) return step;
  Movement moved = movement(facts);
  if (!several.empty()) {
    // A is what moves, whatever its size.
    if (!moved.a_moves) std::swap(moved.moved_mass, moved.kept_mass);
    moved.moves = moved.a_moves = true;
  }
  step.both_stay = !moved.moves;
  step.a_moves = moved.a_moves;
  step.moved_mass = moved.moved_mass;
  step.kept_mass = moved.kept_mass;
  a.for_each([&](PartIndex part) { step.a.push_back(part); });
  b.for_each([&](PartIndex part) { step.b.push_back(part); });
  std::ranges::sort(step.a);
  std::ranges::sort(step.b);
  return step;
}

double StepPieces::checked(double reward, const StepFacts& facts) const {
  if (std::abs(reward) <= largest_reward(totals.problem.num_connections())) return reward;
  throw InputError(
      "objective: the reward of " + std::string(totals.assembly ? "making " : "removing ") +
      in_quotes(totals.problem.connection_id(facts.connection)) + " with " +
      std::to_string(facts.before) + " connections present is " + unfit_reward_text(reward));
}

}  // namespace orasp::detail
